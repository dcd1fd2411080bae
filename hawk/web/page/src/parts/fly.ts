/** What Fly shows, and what every view shows while the drone is in the air. */
export * from "./map.ts";
import "../ui/action-bar.ts";
import "../ui/control-note.ts";
import "../ui/counts-card.ts";
import "../ui/earlier-survey.ts";
import "../ui/glance-line.ts";
import "../ui/keys-list.ts";
import "../ui/kill-dialog.ts";
import "../ui/link-banner.ts";
import "../ui/lots.ts";
import "../ui/map-panel.ts";
import "../ui/more-actions.ts";
import "../ui/plan-panel.ts";
import "../ui/settings-tab.ts";
import "../ui/survey-panel.ts";
import "../ui/tabs.ts";
import "../ui/video-panel.ts";
