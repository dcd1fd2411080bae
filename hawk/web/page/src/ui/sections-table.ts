import { html, nothing, type TemplateResult } from "lit";
import { number, say } from "../words/say.ts";
import { type Counted, parkedWords } from "../words/section.ts";

/** A section with its count, by a stored survey or by the flight so far. */
interface CountedSection {
  id: string;
  name: string;
  look: Counted | null;
}

/** Every section with what was counted; nothing without one. */
export function sectionsTable(sections: readonly CountedSection[], chosen = "", choose: ((section: string) => void) | null = null): TemplateResult | typeof nothing {
  if (sections.length === 0) return nothing;
  return html`<table class="rows sections"><caption class="unseen">${say("sections")}</caption><thead><tr><th scope="col">${say("section-head")}</th><th scope="col">${say("section-head-parked")}</th><th scope="col">${say("section-head-between")}</th><th scope="col">${say("section-head-room")}</th></tr></thead>
    <tbody>${sections.map(
      ({ id, name, look }) => html`<tr class=${id === chosen ? "on" : ""}><th scope="row">${nameButton({ id, name }, chosen, choose)}</th>
        <td>${parkedWords(look)}</td><td>${look === null ? "–" : `${number(look.least)}–${number(look.most)}`}</td><td>${look?.room == null ? "–" : number(look.room)}</td></tr>`,
    )}</tbody></table>`;
}

/** A section's name; a press of it shows it on the map, or no more, where something chooses. */
export function nameButton({ id, name }: { id: string; name: string }, chosen: string, choose: ((section: string) => void) | null): TemplateResult | string {
  if (choose === null) return name;
  return html`<button class="plain link" aria-pressed=${id === chosen} @click=${() => choose(id === chosen ? "" : id)}>${name}</button>`;
}
