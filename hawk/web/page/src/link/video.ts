import type { LinkStatus } from "./reconnect.ts";
import { ReconnectingSocket } from "./reconnect.ts";
import type { OpenSocket, Timers } from "./socket.ts";

/** Little-endian: magic "HWK1", u32 sequence, f64 capture time (the daemon's clock), u32 flags. */
export const HEADER_BYTES = 20;
const MAGIC = 0x314b5748;

export interface VideoFrame {
  sequence: number;
  captureTime: number;
  jpeg: Uint8Array;
}

/** Reads one frame; null for anything else. */
export function readFrame(buffer: ArrayBuffer): VideoFrame | null {
  if (buffer.byteLength <= HEADER_BYTES) return null;
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) return null;
  return {
    sequence: view.getUint32(4, true),
    captureTime: view.getFloat64(8, true),
    jpeg: new Uint8Array(buffer, HEADER_BYTES),
  };
}

/** Shows a frame, then the promise is done: only then is the next one asked for. */
export type ShowFrame = (frame: VideoFrame) => Promise<void>;

/** Frames from the server: one at a time, the next is asked for by acknowledging the last. */
export class VideoLink {
  private readonly socket: ReconnectingSocket;

  private readonly show: ShowFrame;

  constructor(
    url: string,
    open: OpenSocket,
    timers: Timers,
    show: ShowFrame,
    status: (status: LinkStatus) => void = () => undefined,
  ) {
    this.show = show;
    this.socket = new ReconnectingSocket(url, open, timers, { message: (data) => void this.take(data), status }, 15_000);
  }

  start(): void {
    if (this.socket.status === "closed") this.socket.connect();
  }

  stop(): void {
    this.socket.close();
  }

  private async take(data: string | ArrayBuffer): Promise<void> {
    const frame = typeof data === "string" ? null : readFrame(data);
    if (!frame) return;
    try {
      await this.show(frame);
    } catch (error) {
      console.warn("video frame", frame.sequence, error);
    }
    this.socket.send(JSON.stringify({ ack: frame.sequence }));
  }
}
