import { LitElement } from "lit";
import { property } from "lit/decorators.js";
import type { Operator } from "../state/operator.ts";
import { RedrawOnChange } from "./redraw-on-change.ts";

/** A part of the page: draws into the page itself (one style sheet for all), again whenever the model changes. */
export class Part extends LitElement {
  @property({ attribute: false }) model!: Operator;

  constructor() {
    super();
    new RedrawOnChange(this, () => this.model);
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }
}
