import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type ControlNote, controlNote, offerNote } from "../words/control.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

/** The question for control, with its answers, on the page of the one who is asked and of the one who asks; and that about a changed plan. */
@customElement("hawk-control")
export class ControlNotePart extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    return html`${this.note(controlNote(view, this.model.controlling.releasing))}${this.note(offerNote(view, this.model.leftOffer))}`;
  }

  private note(note: ControlNote | null): TemplateResult | typeof nothing {
    if (!note) return nothing;
    return html`<div class="banner warn control" role="alertdialog" aria-label=${note.title}>
      ${icon("person")}
      <div>
        <div class="big">${note.title}</div>
        <div aria-live="off">${note.text}</div>
      </div>
      <div class="act-side">${this.answers(note.kind)}</div>
    </div>`;
  }

  private answers(kind: ControlNote["kind"]): TemplateResult {
    const { controlling } = this.model;
    switch (kind) {
      case "asked":
        return html`<button @click=${() => void controlling.answer(true)}>${say("give")}</button>
          <button @click=${() => void controlling.answer(false)}>${say("keep")}</button>`;
      case "asking":
        return html`<button @click=${() => void controlling.withdraw()}>${say("withdraw")}</button>`;
      case "free":
        return html`<button @click=${() => void controlling.request()}>${say("take-control-now")}</button>
          <button @click=${() => void controlling.withdraw()}>${say("withdraw")}</button>`;
      case "releasing":
        return html`<button @click=${() => void controlling.release()}>${say("give-back")}</button>
          <button @click=${() => controlling.keep()}>${say("keep-control")}</button>`;
      case "changed":
        return html`<button @click=${() => this.model.flyPlan()}>${say("fly-plan")}</button>
          <button @click=${() => this.model.leaveOffer()}>${say("leave-plan")}</button>`;
    }
  }
}
