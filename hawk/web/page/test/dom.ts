import { Window } from "happy-dom";

/** A page without a browser: import this before any component. */
const page = new Window({ url: "http://drone:3000/" });

const NAMES = [
  "document",
  "Document",
  "customElements",
  "Element",
  "HTMLElement",
  "HTMLInputElement",
  "Node",
  "ShadowRoot",
  "CSSStyleSheet",
  "DocumentFragment",
  "MutationObserver",
  "Event",
  "EventTarget",
  "CustomEvent",
  "KeyboardEvent",
  "PointerEvent",
] as const;

const values: Record<string, unknown> = {
  ...Object.fromEntries(NAMES.map((name) => [name, page[name]])),
  window: page,
  devicePixelRatio: 1,
  matchMedia: page.matchMedia.bind(page),
};
for (const [name, value] of Object.entries(values)) {
  Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
}
