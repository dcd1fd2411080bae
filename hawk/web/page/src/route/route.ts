import { hashOf, type Place, placeOf, unreadOf } from "./place.ts";

/** Where the address stands: the browser's, or none in a test. */
export interface Address {
  hash: () => string;
  /** Writes the address; `replace`: "back" does not lead to the one before. */
  write: (hash: string, replace: boolean) => void;
}

/** The place that the page shows, in step with the address. Reports "change" after each change. */
export class Route extends EventTarget {
  place: Place;
  /** What the address names that is no place, until the person goes on. */
  unread: readonly string[] = [];
  private readonly address: Address;
  /** The token of a link that was shared stands before the place. */
  private readonly token: string;

  constructor(address: Address = { hash: () => "", write: () => undefined }, token = "") {
    super();
    this.address = address;
    this.token = token;
    this.place = this.read();
  }

  /** Reads the address again: somebody went back, or followed a link. */
  follow(): void {
    this.place = this.read();
    this.dispatchEvent(new Event("change"));
  }

  /** Says what the address left open: the first lot, say. No step of "back". */
  settle(change: Partial<Place>): void {
    this.place = { ...this.place, ...change };
    this.address.write(this.hashTo({}), true);
    this.dispatchEvent(new Event("change"));
  }

  /** Goes to a place that differs from this one so. Another view is a step that "back" undoes; a moment of it is none. */
  go(change: Partial<Place>): void {
    const before = this.place;
    this.unread = [];
    this.place = { ...before, ...change };
    this.address.write(this.hashTo({}), before.view === this.place.view && before.lot === this.place.lot);
    this.dispatchEvent(new Event("change"));
  }

  /** The address of a place that differs from this one so: for a link. */
  hashTo(change: Partial<Place>): string {
    const hash = hashOf({ ...this.place, ...change });
    return this.token === "" ? hash : `#${this.token}${hash.slice(1)}`;
  }

  private read(): Place {
    const hash = this.address.hash().replace(`#${this.token}`, "#");
    const place = placeOf(hash);
    this.unread = unreadOf(hash);
    return this.token !== "" && place.view === "fly" ? { ...place, view: "lots" } : place;
  }
}

/** Follows the browser's window: back, forward, a link, an address that was typed. */
export function followWindow(route: Route): void {
  window.addEventListener("popstate", () => route.follow());
  window.addEventListener("hashchange", () => route.follow());
}

/** The address of the browser's window. */
export function windowAddress(): Address {
  return {
    hash: () => location.hash,
    write: (hash, replace) => {
      if (replace) history.replaceState(null, "", hash);
      else history.pushState(null, "", hash);
    },
  };
}
