import { html, nothing, type TemplateResult } from "lit";
import type { ListedSection, SectionChange } from "../api.ts";
import type { LocalPlane } from "../fence/plane.ts";
import { type Coordinate, toCoordinate } from "../map/geometry.ts";
import type { SectionShape } from "../map/sections-layer.ts";
import { icon } from "../ui/icons.ts";
import { number, say } from "../words/say.ts";
import { fullness, parkedWords, sectionLines } from "../words/section.ts";

/** Sections as the map of a survey shows them. */
export function shapesOf(sections: readonly ListedSection[], plane: LocalPlane): SectionShape[] {
  return sections.map(({ id, name, look, ground }) => {
    const ring = ground.map(([latitude, longitude]): Coordinate => toCoordinate(plane.toMap({ Latitude: latitude, Longitude: longitude })));
    return { id, name, words: parkedWords(look), fullness: fullness(look), ring };
  });
}

/** Every section with what was counted; nothing without one. */
export function sectionsTable(sections: readonly ListedSection[], chosen: string, choose: (section: string) => void): TemplateResult | typeof nothing {
  if (sections.length === 0) return nothing;
  return html`<table class="rows sections"><caption class="unseen">${say("sections")}</caption><thead><tr><th scope="col">${say("section-head")}</th><th scope="col">${say("section-head-parked")}</th><th scope="col">${say("section-head-between")}</th><th scope="col">${say("section-head-room")}</th></tr></thead>
    <tbody>${sections.map(
      ({ id, name, look }) => html`<tr class=${id === chosen ? "on" : ""}><th scope="row"><button class="plain link" aria-pressed=${id === chosen} @click=${() => choose(id === chosen ? "" : id)}>${name}</button></th>
        <td>${parkedWords(look)}</td><td>${look === null ? "–" : `${number(look.least)}–${number(look.most)}`}</td><td>${look?.room == null ? "–" : number(look.room)}</td></tr>`,
    )}</tbody></table>`;
}

/** Sections at two surveys: how many vehicles then and now, and whether the numbers differ for sure. */
export function sectionChanges(sections: readonly SectionChange[]): TemplateResult | typeof nothing {
  if (sections.length === 0) return nothing;
  const count = (found: SectionChange["before"]): string => (found === null ? "–" : say("section-count", found));
  return html`<h3>${say("sections")}</h3>
    <table class="rows sections"><caption class="unseen">${say("sections")}</caption><thead><tr><th scope="col">${say("section-head")}</th><th scope="col">${say("archive-before")}</th><th scope="col">${say("archive-after")}</th><th scope="col"></th></tr></thead>
    <tbody>${sections.map(
      ({ name, before, after, is_changed: isChanged }) => html`<tr><th scope="row">${name}</th><td>${count(before)}</td><td>${count(after)}</td><td>${isChanged === null ? "" : say(isChanged ? "section-differs" : "section-may-be-same")}</td></tr>`,
    )}</tbody></table>`;
}

/** All that is said of one section, beside its place on the map. */
export function sectionCard(section: ListedSection, close: () => void): TemplateResult {
  return html`<div class="pop stall section" data-section>
    <button class="plain close" aria-label=${say("close")} @click=${close}>${icon("close")}</button>
    <div><div class="h">${say("section-of", { name: section.name })}</div>
      <div class="kind">${parkedWords(section.look)}</div>
      ${sectionLines(section).map((line) => html`<div class="sub">${line}</div>`)}</div>
  </div>`;
}
