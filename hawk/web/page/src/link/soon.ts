/** Lets the browser ask for an address of the drone: the page, which reads it soon, finds the answer there. */
export function askSoon(address: string): void {
  add({ rel: "preload", as: "fetch", href: address, crossOrigin: "anonymous" });
}

/** The same for a script or a style sheet of the page. */
export function readSoon(name: string): void {
  add(name.endsWith(".css") ? { rel: "preload", as: "style", href: name } : { rel: "modulepreload", href: name });
}

function add(values: Partial<HTMLLinkElement>): void {
  document.head.append(Object.assign(document.createElement("link"), values));
}
