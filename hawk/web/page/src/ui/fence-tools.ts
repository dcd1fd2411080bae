import { html, type TemplateResult } from "lit";
import { customElement, query } from "lit/decorators.js";
import { LARGEST_FILE } from "../fence/geojson.ts";
import { readAreaFile } from "../link/area-file.ts";
import type { Drawing } from "../state/drawing.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon, type IconName } from "./icons.ts";

/** A ring that is not closed yet belongs to the map: these ask it to take back a corner, or to close. */
export type FenceToolEvent = CustomEvent<"back" | "close" | "square">;

interface Tool {
  label: string;
  /** Read aloud, where the label alone does not say it. */
  aloud?: string;
  name: IconName;
  possible: boolean;
  run: () => void;
  on?: boolean;
}

/** What can be done with the fence that is being drawn, over the map's upper edge. */
@customElement("hawk-fence-tools")
export class FenceTools extends Part {
  @query("input") private file!: HTMLInputElement;

  override render(): TemplateResult {
    return html`<div class="fencetools" role="toolbar" aria-label=${say(this.model.outline.open ? "outline-tools" : "fence-tools")}>
      ${this.tools().map((each) => this.tool(each))}
      <input type="file" accept=".geojson,.json,.kml,.kmz,application/geo+json,application/json,application/vnd.google-earth.kml+xml,application/vnd.google-earth.kmz" hidden aria-label=${say(this.model.outline.open ? "outline-file" : "fence-file")} @change=${() => void this.read()} />
    </div>`;
  }

  private tools(): Tool[] {
    const { edited } = this;
    const drawn = edited.draft?.isDrawn === true;
    const begun = edited.begun > 0;
    const whole = drawn && !edited.zoning;
    const undo = begun ? () => this.ask("back") : () => edited.undo();
    const shape: Tool = whole
      ? { label: say("tool-remove"), aloud: say("tool-remove-aloud"), name: "minus", possible: true, run: () => edited.remove(!edited.removing), on: edited.removing }
      : begun
        ? { label: say("close"), aloud: say("close-ring"), name: "check", possible: edited.begun >= 3, run: () => this.ask("close") }
        : { label: say("tool-square"), name: "square", possible: true, run: () => this.ask("square") };
    return [
      { label: say("tool-undo"), name: "undo", possible: begun || edited.draft?.canUndo === true, run: undo },
      shape,
      { ...this.cut(), name: "zone", possible: drawn, run: () => edited.zone(!edited.zoning), on: edited.zoning },
      { label: say("tool-clear"), name: "clear", possible: drawn || begun, run: () => edited.draw([]) },
      { label: say("tool-import"), name: "upload", possible: true, run: () => this.file.click() },
      { label: say("tool-export"), name: "download", possible: drawn, run: () => this.export() },
    ];
  }

  /** What is cut out of the fence is a zone that the drone keeps out of, and out of the outline a part that it does not look at. */
  private cut(): Pick<Tool, "label" | "aloud"> {
    if (this.model.outline.open) return { label: say("tool-hole"), aloud: say("tool-hole-aloud") };
    return { label: say("tool-zone"), aloud: say("tool-zone-aloud") };
  }

  private get edited(): Drawing {
    return this.model.drawing ?? this.model.fence;
  }

  private tool({ label, aloud = label, name, possible, run, on = false }: Tool): TemplateResult {
    return html`<button class=${on ? "on" : ""} aria-label=${aloud} aria-pressed=${on ? "true" : "false"} ?disabled=${!possible} @click=${run}>
      ${icon(name)}<span>${label}</span>
    </button>`;
  }

  private ask(what: "back" | "close" | "square"): void {
    this.dispatchEvent(new CustomEvent("fence-tool", { detail: what, bubbles: true }));
  }

  private async read(): Promise<void> {
    const file = this.file.files?.[0];
    this.file.value = "";
    if (!file) return;
    if (file.size > LARGEST_FILE) {
      this.model.toasts.show({ level: "warning", text: say("file-too-large") });
      return;
    }
    const edited = this.edited;
    const read = await readAreaFile(file, this.model.outline.open ? "outline" : "fence");
    if ("problem" in read) this.model.toasts.show({ level: "warning", text: read.problem });
    else if (edited.import(read.text)) this.dispatchEvent(new CustomEvent("fence-imported", { bubbles: true }));
  }

  private export(): void {
    const text = this.edited.export();
    if (text === null) return;
    const address = URL.createObjectURL(new Blob([text], { type: "application/geo+json" }));
    const link = document.createElement("a");
    link.href = address;
    link.download = this.model.outline.open ? "outline.geojson" : "fence.geojson";
    link.click();
    URL.revokeObjectURL(address);
  }
}
