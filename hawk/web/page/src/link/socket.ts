/** What this page needs of a WebSocket, so that tests can give it another. */
export interface SocketLike {
  binaryType: BinaryType;
  readyState: number;
  onopen: ((event: Event) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  send(data: string): void;
  close(): void;
}

export type OpenSocket = (url: string) => SocketLike;

export interface Timers {
  now(): number;
  after(milliseconds: number, run: () => void): () => void;
}

export const SOCKET_OPEN = 1;

export const browserTimers: Timers = {
  now: () => performance.now(),
  after: (milliseconds, run) => {
    const timer = setTimeout(run, milliseconds);
    return () => clearTimeout(timer);
  },
};

export const openBrowserSocket: OpenSocket = (url) => new WebSocket(url);

/** Address of a WebSocket beside the page at this address: under the same sub-path of a proxy. */
export function socketUrl(name: string, page: string): string {
  const url = new URL(name, page);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return url.href;
}
