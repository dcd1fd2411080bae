/** Components that draw on a canvas, where nothing is drawn. */
import "./dom.ts";

/** Takes every call and draws nothing. */
const NO_CONTEXT: unknown = new Proxy(() => NO_CONTEXT, {
  get: (_, name) => (name === Symbol.toPrimitive ? () => 0 : name === "width" ? 10 : NO_CONTEXT),
  set: () => true,
});
Object.defineProperty(Object.getPrototypeOf(document.createElement("canvas")), "getContext", { value: () => NO_CONTEXT });
Object.assign(globalThis, {
  ResizeObserver: class {
    observe = (): void => undefined;
    unobserve = (): void => undefined;
    disconnect = (): void => undefined;
  },
  Path2D: class {
    moveTo = (): void => undefined;
    lineTo = (): void => undefined;
    rect = (): void => undefined;
  },
  getComputedStyle: window.getComputedStyle.bind(window),
  requestAnimationFrame: () => 0,
  location: { protocol: "http:", host: "drone:3000" },
});
