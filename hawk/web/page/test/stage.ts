import assert from "node:assert/strict";
import type { LitElement } from "lit";
import type { Operator } from "../src/state/operator.ts";
import { settle } from "./fakes.ts";

/** A component on the page; `find` gives what a person sees. */
export class Stage<T extends LitElement & { model: Operator }> {
  readonly part: T;

  constructor(part: T, model: Operator) {
    this.part = part;
    part.model = model;
    document.body.replaceChildren(part);
  }

  /** Waits until everything that changed is drawn, inner components too. */
  async drawn(): Promise<void> {
    await settle();
    await this.part.updateComplete;
    await settle();
  }

  get text(): string {
    return words(this.part);
  }

  find(selector: string): HTMLElement {
    const found = this.part.querySelector<HTMLElement>(selector);
    assert.ok(found, `no ${selector} in: ${this.text}`);
    return found;
  }

  input(selector: string): HTMLInputElement {
    return this.find(selector) as HTMLInputElement;
  }

  has(selector: string): boolean {
    return this.part.querySelector(selector) !== null;
  }

  /** A button by its name: its label for screen readers, else its words. */
  button(name: string): HTMLButtonElement {
    const all = [...this.part.querySelectorAll("button")];
    const found = all.find((each) => each.getAttribute("aria-label") === name) ?? all.find((each) => words(each).startsWith(name));
    assert.ok(found, `no button ${name} in: ${this.text}`);
    return found;
  }

  /** Which buttons can be pressed, by name. */
  enabled(): string[] {
    const all = [...this.part.querySelectorAll("button")].filter((each) => !each.disabled);
    return all.map((each) => each.getAttribute("aria-label") ?? nameOf(each));
  }

  async press(name: string): Promise<void> {
    const button = this.button(name);
    assert.equal(button.disabled, false, `${name} cannot be pressed: ${words(button)}`);
    button.click();
    await this.drawn();
  }
}

/** A button's words without the note below them. */
function nameOf(button: Element): string {
  const copy = button.cloneNode(true) as Element;
  for (const note of copy.querySelectorAll(".sub")) note.remove();
  return words(copy);
}

export function words(element: Element): string {
  return element.textContent.replace(/\s+/g, " ").trim();
}

/** Time as the screen draws it, moved by hand: stands in for frames, repeated timers and the clock that they are measured by. */
export class Frames {
  private time = 0;
  private waiting = new Map<number, (at: number) => void>();
  private repeated = new Map<number, () => void>();
  private count = 0;

  constructor() {
    globalThis.requestAnimationFrame = (run) => {
      this.count += 1;
      this.waiting.set(this.count, run);
      return this.count;
    };
    globalThis.cancelAnimationFrame = (id) => void this.waiting.delete(id);
    globalThis.setInterval = ((run: () => void) => {
      this.count += 1;
      this.repeated.set(this.count, run);
      return this.count;
    }) as unknown as typeof setInterval;
    globalThis.clearInterval = ((id: number) => void this.repeated.delete(id)) as typeof clearInterval;
    performance.now = () => this.time;
  }

  /** Lets time pass in which the page is too busy to do anything. */
  stall(milliseconds: number): void {
    this.time += milliseconds;
  }

  /** Lets time pass in which the page draws and its timers run; `drawing` false: its timers alone. */
  advance(milliseconds: number, drawing = true): void {
    const end = this.time + milliseconds;
    do {
      this.time = Math.min(end, this.time + 50);
      this.run(drawing);
    } while (this.time < end);
  }

  /** Runs what is due at this moment. */
  run(drawing = true): void {
    const due = drawing ? [...this.waiting.values()] : [];
    if (drawing) this.waiting.clear();
    for (const run of due) run(this.time);
    for (const run of this.repeated.values()) run();
  }
}
