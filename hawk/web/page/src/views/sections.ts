import { html, nothing, type TemplateResult } from "lit";
import type { ListedSection, SectionChange } from "../api.ts";
import type { LocalPlane } from "../fence/plane.ts";
import { type Coordinate, toCoordinate } from "../map/geometry.ts";
import type { SectionShape } from "../map/sections-layer.ts";
import { icon } from "../ui/icons.ts";
import { nameButton } from "../ui/sections-table.ts";
import { say } from "../words/say.ts";
import { changeWords, fullness, parkedWords, sectionLines, trend } from "../words/section.ts";

/** Sections as the map of a survey shows them, or as they changed; without those that neither survey saw then. */
export function shapesOf(sections: readonly ListedSection[], plane: LocalPlane, changes: readonly SectionChange[] | null): SectionShape[] {
  const changed = new Map(changes?.map((each) => [each.id, each]));
  return sections.flatMap(({ id, name, look, ground }) => {
    const ring = ground.map(([latitude, longitude]): Coordinate => toCoordinate(plane.toMap({ Latitude: latitude, Longitude: longitude })));
    const change = changed.get(id);
    if (changes === null) return { id, name, words: parkedWords(look), look: fullness(look), ring };
    return change === undefined ? [] : { id, name, words: changeWords(change), look: trend(change), ring };
  });
}

const countOf = (found: SectionChange["before"]): string => (found === null ? "–" : say("section-count", found));
const differsWords = ({ is_changed: isChanged }: SectionChange): string => (isChanged === null ? "" : say(isChanged ? "section-differs" : "section-may-be-same"));

/** Sections at two surveys: how many vehicles then and now, and whether the numbers differ for sure. */
export function sectionChanges(sections: readonly SectionChange[], chosen: string, choose: (section: string) => void): TemplateResult | typeof nothing {
  if (sections.length === 0) return nothing;
  return html`<h3>${say("sections")}</h3>
    <table class="rows sections"><caption class="unseen">${say("sections")}</caption><thead><tr><th scope="col">${say("section-head")}</th><th scope="col">${say("archive-before")}</th><th scope="col">${say("archive-after")}</th><th scope="col"><span class="unseen">${say("archive-changes")}</span></th></tr></thead>
    <tbody>${sections.map(
      (each) => html`<tr class=${each.id === chosen ? "on" : ""}><th scope="row">${nameButton(each, chosen, choose)}</th><td>${countOf(each.before)}</td><td>${countOf(each.after)}</td><td>${differsWords(each)}</td></tr>`,
    )}</tbody></table>`;
}

function changeLines(change: SectionChange): string[] {
  const { before, after } = change;
  return [`${say("archive-before")}: ${countOf(before)}`, `${say("archive-after")}: ${countOf(after)}`, differsWords(change)].filter((each) => each !== "");
}

/** All that is said of one section, beside its place on the map: of one survey, or of its change. */
export function sectionCard(section: ListedSection, change: SectionChange | undefined, close: () => void): TemplateResult {
  return html`<div class="pop stall section" data-section>
    <button class="plain close" aria-label=${say("close")} @click=${close}>${icon("close")}</button>
    <div><div class="h">${say("section-of", { name: section.name })}</div>
      <div class="kind">${change ? changeWords(change) : parkedWords(section.look)}</div>
      ${(change ? changeLines(change) : sectionLines(section)).map((line) => html`<div class="sub">${line}</div>`)}</div>
  </div>`;
}
