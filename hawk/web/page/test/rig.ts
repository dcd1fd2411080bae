import type { Heartbeat } from "../src/protocol.ts";
import { Operator } from "../src/state/operator.ts";
import { FakeServer, FakeStorage, FakeTimers, settle } from "./fakes.ts";
import { heartbeat, welcome } from "./make.ts";

export interface Sent {
  Type: string;
  Id?: string;
  Token?: string;
  [field: string]: unknown;
}

/** The real model, connected to a server that a test plays. */
export interface Rig {
  operator: Operator;
  server: FakeServer;
  timers: FakeTimers;
  /** What was sent over the present connection, in order. */
  sent: () => Sent[];
  /** Answers the last command. */
  answer: (accepted: boolean, reason?: string) => Promise<void>;
  /** The drone says how it is. */
  hear: (changes: Partial<Heartbeat>) => void;
}

export function flying(changes: Partial<Heartbeat> = {}, session = new FakeStorage()): Rig {
  const timers = new FakeTimers();
  const server = new FakeServer();
  const operator = new Operator({
    commandUrl: "ws://drone/ws",
    open: server.open,
    timers,
    wallClock: () => 1_000_000 + timers.now(),
    storage: new FakeStorage(),
    session,
  });
  operator.connect();
  server.last.accept();
  server.last.say(welcome());
  server.last.say(heartbeat(changes));
  const sent = (): Sent[] => server.last.sent.map((text) => JSON.parse(text) as Sent);
  const answer = async (accepted: boolean, reason = ""): Promise<void> => {
    server.last.say({ Type: "Ack", Id: sent().at(-1)?.Id, Accepted: accepted, Reason: reason });
    await settle();
  };
  const hear = (news: Partial<Heartbeat>): void => server.last.say(heartbeat({ ...changes, ...news }));
  return { operator, server, timers, sent, answer, hear };
}
