import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { AskedUse, Cell } from "../api.ts";
import { cssVars } from "../ui/css-vars.ts";
import { say } from "../words/say.ts";
import { amountOf, dayName, hourWords, mostOf, percentOf, rangeOf, shadeOf } from "./ask-words.ts";
import { cellAt, DAYS, HOURS, hoursShown, type Run, runs, upTo } from "./question.ts";

/** Days and hours that a press, a drag or the keys choose. */
export interface Chosen {
  days: number[];
  hours: number[];
}

type Spot = readonly [day: number, hour: number];

const STEPS: Readonly<Record<string, Spot>> = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/** The hours of a week by the share that was taken, hatched where nobody flew, with a frame around what is asked. */
@customElement("archive-heat")
export class HeatMap extends LitElement {
  @property({ attribute: false }) answer!: AskedUse;
  @property() label = "";
  /** Redraws it in another language. */
  @property() spoken = "";
  /** The cell that the Tab key comes to. */
  @state() private at: Spot | null = null;
  /** Where a choice of several cells began, and the other corner of it. */
  @state() private drag: readonly [Spot, Spot] | null = null;
  @state() private isWhole = false;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    const shown: Run = this.isWhole ? [0, HOURS - 1] : hoursShown(this.answer);
    const hours = upTo(...shown);
    return html`<div class="heat" role="grid" aria-label=${this.label} aria-description=${say("ask-heat-keys")} aria-multiselectable="true" ${cssVars({ "--hours": String(hours.length) })}
        @keydown=${(event: KeyboardEvent) => this.key(event, shown)} @pointerdown=${(event: PointerEvent) => this.down(event)} @pointermove=${(event: PointerEvent) => this.move(event)} @pointerup=${() => this.ask()} @pointercancel=${() => (this.drag = null)}>
        <div role="row"><span role="columnheader" class="corner"><span class="unseen">${say("ask-days")}</span></span>${hours.map((hour, k) => html`<span role="columnheader" class="hour" aria-label=${hourWords(hour)} ${cssVars({ "--h": String(k) })}>${hour}</span>`)}</div>
        ${DAYS.map((_, day) => html`<div role="row"><span role="rowheader" class="day" aria-label=${dayName(day, "long")} ${cssVars({ "--d": String(day) })}>${dayName(day, "short")}</span>${hours.map((hour, k) => this.cell(day, hour, k, shown))}</div>`)}
        ${this.frames(shown)}
      </div>
      <button class="all" aria-pressed=${this.isWhole} @click=${() => (this.isWhole = !this.isWhole)}>${say(this.isWhole ? "ask-flown-hours" : "ask-all-hours")}</button>`;
  }

  private cell(day: number, hour: number, column: number, shown: Run): TemplateResult {
    const cell = cellAt(this.answer, day, hour);
    const words = say("ask-cell", { day: dayName(day, "long"), hours: hourWords(hour), what: cellWords(cell) });
    const [homeDay, homeHour] = this.home(shown);
    const flown = cell !== undefined && cell.days > 0;
    return html`<span role="gridcell" class="cell ${flown ? "flown" : ""}" data-day=${day} data-hour=${hour} tabindex=${day === homeDay && hour === homeHour ? 0 : -1}
      aria-selected=${this.drag ? isIn(this.drag, day, hour) : (cell?.is_asked ?? false)} aria-label=${words} title=${words} @focus=${() => (this.at = [day, hour])}
      ${cssVars({ "--d": String(day), "--h": String(column), "--share": String(cell ? shadeOf(this.answer, cell) : 0) })}>${flown ? html`<b>${cell.occupancy.value === null ? amountOf(cell) : html`${percentOf(cell.occupancy.value)}<span class="sign"> %</span>`}</b><span class="count">${say("ask-surveys", { surveys: cell.accumulation.surveys })}</span>` : nothing}</span>`;
  }

  /** The cell that was visited last; else the first that is asked. */
  private home([first, last]: Run): Spot {
    if (this.at !== null && this.at[1] >= first && this.at[1] <= last) return this.at;
    const { cells } = this.answer;
    const asked = cells.findIndex((cell) => cell.is_asked && cell.hour >= first);
    return asked < 0 ? [0, first] : [Math.floor(asked / HOURS), asked % HOURS];
  }

  /** Around each block of hours that are asked, or are about to be. */
  private frames([first, last]: Run): TemplateResult[] {
    const days = DAYS.map((_, day) => day).filter((day) => upTo(first, last).some((hour) => this.isAsked(day, hour)));
    const hours = upTo(first, last).filter((hour) => days.some((day) => this.isAsked(day, hour)));
    return runs(days).flatMap(([top, bottom]) =>
      runs(hours).map(([left, right]) => html`<i class="frame" aria-hidden="true" ${cssVars({ "--d": String(top), "--days": String(bottom - top + 1), "--h": String(left - first), "--wide": String(right - left + 1) })}></i>`),
    );
  }

  private isAsked(day: number, hour: number): boolean {
    return this.drag ? isIn(this.drag, day, hour) : (cellAt(this.answer, day, hour)?.is_asked ?? false);
  }

  /** A finger that moves scrolls the page: it asks one hour by a press. */
  private down(event: PointerEvent): void {
    const spot = spotOf(event.target);
    if (spot !== null && event.button === 0) this.drag = [event.shiftKey && this.at ? this.at : spot, spot];
  }

  private move({ pointerType, clientX, clientY }: PointerEvent): void {
    if (this.drag === null || pointerType === "touch") return;
    const spot = spotOf(document.elementFromPoint(clientX, clientY));
    if (spot !== null) this.drag = [this.drag[0], spot];
  }

  private ask(): void {
    if (this.drag === null) return;
    const [[day, hour], [otherDay, otherHour]] = this.drag;
    this.drag = null;
    const between = (one: number, other: number): number[] => upTo(Math.min(one, other), Math.max(one, other));
    this.dispatchEvent(new CustomEvent<Chosen>("hours", { detail: { days: between(day, otherDay), hours: between(hour, otherHour) }, bubbles: true }));
  }

  private key(event: KeyboardEvent, shown: Run): void {
    const [day, hour] = this.home(shown);
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      this.drag ??= [[day, hour], [day, hour]];
      this.ask();
    }
    if (event.key === "Escape") this.drag = null;
    // on a phone the days stand side by side, and the hours below each other
    const isTurned = getComputedStyle(this).getPropertyValue("--turned").trim() === "1";
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    const [down, right] = isTurned ? [step[1], step[0]] : step;
    const next: Spot = [within(day + down, 0, DAYS.length - 1), within(hour + right, ...shown)];
    this.drag = event.shiftKey ? [this.drag?.[0] ?? [day, hour], next] : null;
    this.at = next;
    void this.updateComplete.then(() => this.querySelector<HTMLElement>(`[data-day="${next[0]}"][data-hour="${next[1]}"]`)?.focus());
  }
}

function cellWords(cell: Cell | undefined): string {
  if (cell === undefined || cell.days === 0) return say("ask-nobody");
  return say("ask-cell-flown", { value: amountOf(cell), range: rangeOf(cell), surveys: cell.accumulation.surveys });
}

function isIn([[day, hour], [otherDay, otherHour]]: readonly [Spot, Spot], atDay: number, atHour: number): boolean {
  return atDay === within(atDay, Math.min(day, otherDay), Math.max(day, otherDay)) && atHour === within(atHour, Math.min(hour, otherHour), Math.max(hour, otherHour));
}

function within(value: number, least: number, most: number): number {
  return Math.min(most, Math.max(least, value));
}

function spotOf(target: EventTarget | null): Spot | null {
  const { day, hour } = (target as Element | null)?.closest<HTMLElement>("[data-day]")?.dataset ?? {};
  return day === undefined || hour === undefined ? null : [Number(day), Number(hour)];
}

/** What the colours and marks of the hours mean. */
export function heatLegend(answer: AskedUse): TemplateResult {
  const scale = answer.unit === "vehicles" ? say("ask-scale-vehicles", { most: mostOf(answer) }) : say("ask-scale");
  return html`<p class="legend"><span><i class="ramp"></i>${scale}</span><span><i class="key hatched"></i>${say("ask-nobody")}</span><span><i class="key frame"></i>${say("ask-asked")}</span></p>`;
}

