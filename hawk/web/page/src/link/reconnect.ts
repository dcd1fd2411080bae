import { type OpenSocket, type SocketLike, SOCKET_OPEN, type Timers } from "./socket.ts";

export type LinkStatus = "connecting" | "open" | "waiting" | "closed";

/** Waits between attempts, milliseconds; the last one repeats. */
export const BACKOFF_MS: readonly number[] = [250, 500, 1000, 2000, 4000];

/** The server's close code when the login or its token has ended. */
export const ACCESS_ENDED = 4401;

/** A socket that says nothing for so long is given up and opened again. */
export const SILENCE_MS = 4000;

export interface ReconnectHandlers {
  message(data: string | ArrayBuffer): void;
  status(status: LinkStatus): void;
  /** The server closed the connection because the login has ended. */
  ended?(): void;
  /** An attempt failed before the connection was open. */
  refused?(): void;
}

/** Keeps one WebSocket open: tries again after each loss, and drops one that has gone silent. */
export class ReconnectingSocket {
  status: LinkStatus = "closed";
  /** Attempts since the last message that arrived. */
  attempts = 0;

  private socket: SocketLike | null = null;
  private cancelRetry: (() => void) | null = null;
  private cancelSilence: (() => void) | null = null;

  private readonly url: string;
  private readonly open: OpenSocket;
  private readonly timers: Timers;
  private readonly handlers: ReconnectHandlers;
  private readonly silenceMs: number;

  constructor(
    url: string,
    open: OpenSocket,
    timers: Timers,
    handlers: ReconnectHandlers,
    silenceMs: number = SILENCE_MS,
  ) {
    this.url = url;
    this.open = open;
    this.timers = timers;
    this.handlers = handlers;
    this.silenceMs = silenceMs;
  }

  /** Connects at once, also while waiting for the next attempt. */
  connect(): void {
    this.drop();
    this.attempts += 1;
    this.setStatus("connecting");
    const socket = this.open(this.url);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      if (socket === this.socket) this.setStatus("open");
    };
    socket.onmessage = (event: MessageEvent) => {
      if (socket !== this.socket) return;
      this.attempts = 0;
      this.watchSilence();
      this.handlers.message(event.data as string | ArrayBuffer);
    };
    socket.onclose = (event: CloseEvent) => {
      if (socket !== this.socket) return;
      if (event.code === ACCESS_ENDED) this.handlers.ended?.();
      else if (this.status === "connecting") this.handlers.refused?.();
      this.retry();
    };
    this.socket = socket;
    this.watchSilence();
  }

  /** Closes and stays closed until connect. */
  close(): void {
    this.drop();
    this.setStatus("closed");
  }

  /** Sends a text; false when there is no open socket. */
  send(text: string): boolean {
    if (this.socket?.readyState !== SOCKET_OPEN) return false;
    this.socket.send(text);
    return true;
  }

  private retry(): void {
    this.drop();
    const wait = BACKOFF_MS[Math.min(Math.max(this.attempts - 1, 0), BACKOFF_MS.length - 1)] ?? 4000;
    this.setStatus("waiting");
    this.cancelRetry = this.timers.after(wait, () => this.connect());
  }

  private watchSilence(): void {
    this.cancelSilence?.();
    this.cancelSilence = this.timers.after(this.silenceMs, () => this.retry());
  }

  private drop(): void {
    this.cancelRetry?.();
    this.cancelSilence?.();
    this.cancelRetry = this.cancelSilence = null;
    const socket = this.socket;
    this.socket = null;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  private setStatus(status: LinkStatus): void {
    if (status === this.status) return;
    this.status = status;
    this.handlers.status(status);
  }
}
