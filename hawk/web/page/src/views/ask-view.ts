import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { AskedUse, Figures, SurveysUse } from "../api.ts";
import { icon } from "../ui/icons.ts";
import { percent } from "../words/format.ts";
import { capital, language, number, say } from "../words/say.ts";
import "./ask-heat.ts";
import { type Chosen, heatLegend } from "./ask-heat.ts";
import { amountOf, answerWords, behindWords, dayName, daysWords, hoursWords, hourWords, monthEnds, monthOf, monthWords, partName, partsWords, percentOf, periodWords, rangeOf, shadeOf, type Use } from "./ask-words.ts";
import { moment } from "./figures.ts";
import "./picker.ts";
import { commandOf, DAYS, daysOf, daysText, HOURS, hoursOf, hoursText, KINDS_OF_PARTS, type KindOfPart, namesOf, switchedPart } from "./question.ts";
import "./time-bar.ts";
import { Asked, View } from "./view.ts";

/** Hours of the day that are asked about often. */
const OFTEN = ["7-11", "11-15", "15-19"];
/** Where the words of a question have their pickers. */
const SLOTS = { part: "\uE001", days: "\uE002", clock: "\uE003", when: "\uE004" };

/** "How full is row B on weekdays between 7 and 11 in May?": the question, its answer, the hours of the week, and the figures. */
@customElement("archive-ask")
export class AskView extends View {
  private readonly found = new Asked<AskedUse>(this);
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly parts: Readonly<Record<KindOfPart, Asked<Figures>>> = { row: new Asked(this), zone: new Asked(this), kind: new Asked(this), section: new Asked(this) };

  override willUpdate(): void {
    const { lot, parts, days, hours, from, to } = this.place;
    this.found.ask(JSON.stringify([lot, parts, days, hours, from, to, this.revision]), () => this.source.asked(this.place));
  }

  override render(): TemplateResult {
    const { value, problem } = this.found;
    const shares = new Map(value?.surveys.map((each) => [each.survey, shadeOf(value, each)]));
    return html`<div class="ask">
      ${this.question()}
      ${problem === "" ? nothing : html`<div class="card answer" role="alert"><p>${problem}</p>${this.there()}</div>`}
      ${value === null ? (problem === "" ? html`<p class="card answer">${say("archive-asking")}</p>` : nothing) : html`${this.answer(value)} ${this.heat(value)} ${this.figures(value)}`}
      <hawk-time-bar .source=${this.source} .lot=${this.place.lot} .revision=${this.revision} .marked=${new Set(shares.keys())} .shares=${shares} .spoken=${language()} @survey=${(event: CustomEvent<string>) => this.go({ view: "lots", survey: event.detail })}></hawk-time-bar>
    </div>`;
  }

  /** The rows, zones or kinds that there are, where the address asks about one that is not there: a row was renamed, say. */
  private there(): TemplateResult | typeof nothing {
    const kind = KINDS_OF_PARTS.find((each) => each === this.found.field);
    if (kind === undefined) return nothing;
    return html`<p class="others">${this.names(kind).map((name) => html`<button class="small" @click=${() => this.go({ parts: [`${kind}.${name}`] })}>${partName(kind, name)}</button>`)}</p>`;
  }

  /** What the lot's rows, zones or kinds are called. */
  private names(kind: KindOfPart): string[] {
    const { from, to, lot } = this.place;
    const found = this.parts[kind];
    found.ask(JSON.stringify([lot, from, to, this.revision]), () => this.source.statistics({ from, to }, kind));
    return (found.value?.parts ?? []).map(({ name }) => name);
  }

  private answer(value: AskedUse): TemplateResult {
    const { days, hours, from, to } = this.place;
    return answer(value, days + hours + from + to === "");
  }

  private question(): TemplateResult {
    const { days, hours, parts } = this.place;
    const { period, when } = periodWords(this.place);
    const pickers: Readonly<Record<string, TemplateResult>> = {
      [SLOTS.part]: picker(say("ask-part"), partsWords(parts), () => this.partChoices()),
      [SLOTS.days]: picker(say("ask-days"), daysWords(days), () => this.dayChoices()),
      [SLOTS.clock]: picker(say("ask-hours"), hoursWords(hours), () => this.hourChoices()),
      [SLOTS.when]: picker(say("ask-period"), when, () => this.periodChoices()),
    };
    const words = say("ask-question", { ...SLOTS, hours: hours === "" ? "all" : "some", period }).split(/([\uE001-\uE004])/);
    const shown = words.filter((each) => each.trim() !== "").map((each) => pickers[each] ?? html`<span>${each}</span>`);
    return html`<section class="card question" aria-label=${say("view-report")}>
      <p>${shown.slice(0, -2)}<span class="end">${shown.slice(-2)}</span></p>
      <span class="does">
        <button aria-label=${say("ask-copy-address")} title=${say("ask-copy-address")} @click=${() => void this.copy(location.href)}>${icon("chain")}</button>
        <button class="print" aria-label=${say("ask-document")} title=${say("ask-document")} @click=${() => this.go({ show: "document" })}>${icon("download")}</button>
      </span>
    </section>`;
  }

  private partChoices(): TemplateResult {
    const { parts } = this.place;
    const asked = parts.length === 0;
    return html`<button aria-pressed=${asked} @click=${() => this.go({ parts: [] })}>${capital(say("ask-whole-lot"))}</button>
      ${KINDS_OF_PARTS.map((kind) => {
        const names = [...new Set([...this.names(kind), ...namesOf(parts, kind)])];
        if (names.length < (kind === "row" || kind === "section" ? 1 : 2)) return nothing;
        return html`<fieldset><legend>${say(`archive-by-${kind}`)}</legend>${names.map((name) => this.box(partName(kind, name), parts.includes(`${kind}.${name}`), () => this.go({ parts: switchedPart(parts, `${kind}.${name}`) })))}</fieldset>`;
      })}`;
  }

  private dayChoices(): TemplateResult {
    const days = daysOf(this.place.days);
    const choose = (next: readonly number[]): void => this.go({ days: daysText(next.length === 0 ? daysOf("") : next) });
    return html`<span class="often">${["", "mon-fri", "sat-sun"].map((text) => html`<button aria-pressed=${text === this.place.days} @click=${() => this.go({ days: text })}>${capital(daysWords(text))}</button>`)}</span>
      <fieldset><legend class="unseen">${say("ask-days")}</legend>${DAYS.map((_, day) => this.box(dayName(day, "long"), days.includes(day), () => choose(switched(days, day))))}</fieldset>`;
  }

  private hourChoices(): TemplateResult {
    const hours = hoursOf(this.place.hours);
    const choose = (next: readonly number[]): void => this.go({ hours: hoursText(next.length === 0 ? hoursOf("") : next) });
    return html`<span class="often">${["", ...OFTEN].map((text) => html`<button aria-pressed=${text === this.place.hours} @click=${() => this.go({ hours: text })}>${capital(hoursWords(text))}</button>`)}</span>
      <fieldset class="hours"><legend class="unseen">${say("ask-hours")}</legend>${Array.from({ length: HOURS }, (_, hour) => this.box(String(hour), hours.includes(hour), () => choose(switched(hours, hour)), hourWords(hour)))}</fieldset>`;
  }

  private periodChoices(): TemplateResult {
    this.listed.ask(`${this.place.lot} ${this.revision}`, () => this.source.surveys({ from: "", to: "" }));
    const { surveys, clock } = this.listed.value ?? { surveys: [], clock: "UTC" };
    const months = new Map<string, number>();
    for (const { at } of surveys) {
      const month = moment(at, clock).slice(0, 7);
      months.set(month, (months.get(month) ?? 0) + 1);
    }
    const chosen = monthOf(this.place);
    const { from, to } = this.place;
    return html`<button aria-pressed=${from === "" && to === ""} @click=${() => this.go({ from: "", to: "" })}>${capital(say("ask-every-survey"))}</button>
      ${[...months].map(([month, count]) => {
        const [begin, end] = monthEnds(month);
        return html`<button aria-pressed=${month === chosen} @click=${() => this.go({ from: begin, to: end })}>${say("ask-month-surveys", { month: capital(monthWords(month)), surveys: count })}</button>`;
      })}
      <span class="often">${(["from", "to"] as const).map((end) => html`<label>${say(`archive-${end}`)}<input type="date" .value=${this.place[end]} @change=${(event: Event) => this.go({ [end]: (event.target as HTMLInputElement).value })} /></label>`)}</span>`;
  }

  private box(words: string, isOn: boolean, change: () => void, label = words): TemplateResult {
    return html`<label class=${isOn ? "on" : ""}><input type="checkbox" aria-label=${label} .checked=${isOn} @change=${change} />${words}</label>`;
  }

  private heat(value: AskedUse): TemplateResult {
    const label = say("ask-heat", { part: capital(partsWords(this.place.parts)), when: periodWords(this.place).when });
    const isWeek = this.place.days === "" && this.place.hours === "";
    return html`<section class="card weekly"><div class="headed"><h2>${label}</h2>${heatLegend(value)}</div>
      <archive-heat .answer=${value} .label=${label} .spoken=${language()} @hours=${({ detail }: CustomEvent<Chosen>) => this.go({ days: daysText(detail.days), hours: hoursText(detail.hours) })}></archive-heat>
      ${isWeek ? nothing : html`<button class="whole" @click=${() => this.go({ days: "", hours: "" })}>${say("ask-whole-week")}</button>`}</section>`;
  }

  private figures(value: AskedUse): TemplateResult {
    const rows = value.cells.map((cell, k) => ({ ...cell, day: Math.floor(k / HOURS) })).filter((cell) => cell.is_asked && cell.days > 0);
    const isNumber = value.unit === "vehicles";
    const times = number(10 * value.interval);
    return html`<section class="card figures"><h2>${say("ask-figures")}</h2>
      <div class="wide" tabindex="0" role="region" aria-label=${say("ask-figures")}><table>
        <thead><tr><th scope="col" colspan="2">${say("archive-when")}</th><th scope="col">${say("archive-surveys")}</th><th scope="col">${say(isNumber ? "ask-head-vehicles" : "archive-taken")}</th><th scope="col">${say("ask-times", { times })}</th></tr></thead>
        <tbody>${rows.map(({ day, hour, ...use }, k) => {
          const isSame = rows[k - 1]?.day === day;
          return html`<tr class=${isSame ? "same" : ""}><th scope="row"><span class=${isSame ? "unseen" : ""}>${dayName(day, "short")}</span></th><td>${hourWords(hour)}</td>${useCells(use)}</tr>`;
        })}</tbody>
        <tfoot><tr><th scope="row" colspan="2">${say("ask-all")}</th>${useCells(value)}</tr></tfoot>
      </table></div>
      ${this.elsewhere(value)}</section>`;
  }

  private elsewhere(value: AskedUse): TemplateResult | typeof nothing {
    const command = this.source.isShared ? "" : commandOf(value.name, this.place);
    const others = value.others.filter(({ occupancy }) => occupancy.value !== null);
    if (command === "" && others.length === 0) return nothing;
    const kept = this.place.parts.filter((part) => !part.startsWith("row."));
    return html`<h2>${say("ask-elsewhere")}</h2>
      ${others.length === 0 ? nothing : html`<p class="others">${say("ask-other-rows")} ${others.map(({ row, occupancy }) => html`<button class="small" @click=${() => this.go({ parts: [`row.${row}`, ...kept] })}>${`${row} ${percent(100 * (occupancy.value ?? 0))}`}</button>`)}</p>`}
      ${command === "" ? nothing : html`<div class="command"><code tabindex="0" role="region" aria-label=${say("ask-command")}>${command.split(/ (?=--)/).map((each) => html`<span>${each}</span> `)}</code><button aria-label=${say("ask-copy-command")} title=${say("ask-copy-command")} @click=${() => void this.copy(command)}>${icon("copy")}</button></div>`}`;
  }

  /** Without HTTPS a browser keeps its clipboard to itself: then the text is shown. */
  private async copy(text: string): Promise<void> {
    const isCopied = "clipboard" in navigator && (await navigator.clipboard.writeText(text).then(() => true, () => false));
    this.said(say(isCopied ? "ask-copied" : "ask-copy-by-hand", { text }));
  }
}

function picker(label: string, word: string, choices: () => TemplateResult): TemplateResult {
  return html`<archive-picker .label=${label} .word=${word} .choices=${choices}></archive-picker>`;
}

function answer(value: AskedUse, isOfAll: boolean): TemplateResult {
  if (value.accumulation.value === null) return html`<section class="card answer" aria-live="polite">${noAnswer(value.left_out.length, isOfAll)}</section>`;
  return html`<section class="card answer" aria-live="polite">
    <p class="share"><b class="large">${value.unit === "vehicles" ? say("ask-vehicles-large", { value: amountOf(value) }) : say("ask-taken", { value: percentOf(value.occupancy.value) })}</b><span class="sub">${`${rangeOf(value)}, ${say("ask-times", { times: number(10 * value.interval) })}`}</span></p>
    <div><p>${answerWords(value)}</p><p class="sub">${behindWords(value)}</p></div>
  </section>`;
}

/** Why there is no figure: surveys that do not count are no hours that nobody flew. */
function noAnswer(leftOut: number, isOfAll: boolean): TemplateResult {
  if (leftOut > 0) return html`<p class="large">${say("ask-none-counts")}</p><p>${say("archive-left-out-count", { surveys: leftOut })}</p>`;
  if (isOfAll) return html`<p>${say("archive-no-survey")}</p>`;
  return html`<p class="large">${say("ask-none")}</p><p>${say("ask-none-remedy")}</p>`;
}

function useCells(use: Use): TemplateResult {
  return html`<td>${number(use.accumulation.surveys)}</td><td><b>${amountOf(use)}</b></td><td>${rangeOf(use)}</td>`;
}

/** A list with one more, or one less. */
function switched<T>(all: readonly T[], one: T): T[] {
  return all.includes(one) ? all.filter((each) => each !== one) : [...all, one];
}
