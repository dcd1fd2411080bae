import type { Incoming } from "../protocol.ts";
import { learn } from "../words/drone.ts";

const KINDS = new Set(["Ack", "Fence Check", "Heartbeat", "Kill Token", "Route", "Welcome"]);

/** A message of the server, its sentences learnt; null for one that this page does not know. */
export function readIncoming(data: string | ArrayBuffer): Incoming | null {
  if (typeof data !== "string") return null;
  try {
    const message: unknown = JSON.parse(data);
    if (typeof message !== "object" || message === null) return null;
    if (!KINDS.has((message as { Type?: string }).Type ?? "")) return null;
    learnFrom(message as Incoming);
    return message as Incoming;
  } catch {
    return null;
  }
}

/** The sentences of a message, and of those within it. */
function learnFrom(message: Incoming): void {
  if ("Sentences" in message) learn(message.Sentences);
  if (message.Type !== "Heartbeat") return;
  for (const part of [...message.Messages, message["Fence Setup"], message["Outline Setup"]]) learn(part?.Sentences);
}
