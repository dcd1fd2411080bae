import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { fenceWords } from "../words/fence.ts";
import { say } from "../words/say.ts";
import { metresOf, SCALES, typed, type Units } from "../words/units.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { noted, quoting } from "./quoting.ts";
import { isTouch } from "./touch.ts";

/** The fence editor's part of the bar: what is said about the fence, its ceiling, and keeping it. */
@customElement("hawk-fence-bar")
export class FenceBar extends Part {
  /** What was typed in feet, and the metres that the drawing keeps of it. */
  private typed = { text: "", kept: "" };

  override render(): TemplateResult | typeof nothing {
    const { fence, flight } = this.model;
    if (!fence.open) return nothing;
    const { units } = this.model.preferences;
    const words = fenceWords(fence, flight.fenceSetup, this.model.view(), isTouch());
    return html`<div class="confirm fence" role="group" aria-label=${say("edit-the-fence")}>
      <button class="cancel" aria-label=${say("cancel")} @click=${() => fence.cancel()}>${icon("close")}<span>${say("cancel")}</span></button>
      <div class="txt" role="status">
        <b>${words.title}</b><span class="sub ${words.level}">${quoting(words.line, fence.quoted)}</span>
      </div>
      <label class="number"
        ><span class="t">${say("ceiling")}</span>
        <input
          inputmode="decimal"
          aria-label=${say("ceiling-label", { units })}
          .value=${this.ceiling(units)}
          @input=${(event: Event) => this.typeCeiling((event.target as HTMLInputElement).value, units)}
        />${SCALES[units].symbol}</label
      >
      <button
        class="act save primary"
        ?disabled=${words.reason !== ""}
        @click=${() => void fence.save()}
      >
        <b>${say("save-fence")}</b>${words.reason === "" ? nothing : html`<span class="sub">${noted(this.model.view(), words.reason)}</span>`}
      </button>
    </div>`;
  }

  /** The drawing keeps metres. */
  private ceiling(units: Units): string {
    const { draft } = this.model.fence;
    if (!draft || units === "metres") return draft?.ceiling ?? "";
    if (draft.ceiling === this.typed.kept) return this.typed.text;
    return draft.ceilingMetres === null ? draft.ceiling : typed(draft.ceilingMetres, units);
  }

  private typeCeiling(text: string, units: Units): void {
    const metres = metresOf(text, units);
    const kept = units === "metres" || metres === null ? text : String(metres);
    this.typed = { text, kept };
    this.model.fence.typeCeiling(kept);
  }
}
