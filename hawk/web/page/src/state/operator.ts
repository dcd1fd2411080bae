import { Commands, isByDrone } from "../link/commands.ts";
import { readIncoming } from "../link/incoming.ts";
import { type LinkStatus, ReconnectingSocket } from "../link/reconnect.ts";
import type { OpenSocket, Timers } from "../link/socket.ts";
import type { Command, FenceCorner, Heartbeat, Point } from "../protocol.ts";
import type { MoveKind } from "../words/move.ts";
import { say } from "../words/say.ts";
import { linkOf, option, type View } from "../words/view.ts";
import { Alarms } from "./alarms.ts";
import { Controlling } from "./controlling.ts";
import { DaemonClock } from "./daemon-clock.ts";
import type { Drawing } from "./drawing.ts";
import { FenceEditing } from "./fence-edit.ts";
import { Flight, isSteered } from "./flight.ts";
import { HiddenPage } from "./hidden-page.ts";
import { Measure } from "./measure.ts";
import { type MapChange, MapStore } from "./map-store.ts";
import { MotorCut } from "./motor-cut.ts";
import { OutlineEditing } from "./outline-edit.ts";
import { Picture } from "./picture.ts";
import { PlanEditing } from "./plan-edit.ts";
import { type Moment, PlotHistory } from "./plot-history.ts";
import { type Preferences, readPreferences, writePreferences } from "./preferences.ts";
import type { Question } from "./question.ts";
import { RoutePlan } from "./route-plan.ts";
import { Toasts } from "./toasts.ts";

export interface Outside {
  commandUrl: string;
  open: OpenSocket;
  timers: Timers;
  /** Time of day, milliseconds. */
  wallClock: () => number;
  storage: Pick<Storage, "getItem" | "setItem">;
  /** Speaks; absent where nobody listens. */
  say?: (text: string) => void;
  /** Shows the login page: the login has ended. */
  logIn?: () => void;
  /** Looks whether the login still holds: a browser does not say why a connection was refused. */
  checkLogin?: () => void;
  /** Ends the login. */
  logOut?: () => void;
  /** Lasts as long as the browser's tab. */
  session: Pick<Storage, "getItem" | "setItem">;
}

/** Stalls of a lot that begin and end, by their corners on Earth. */
export interface ShownChanges {
  begin: readonly (readonly FenceCorner[])[];
  end: readonly (readonly FenceCorner[])[];
}

/** In all others the bar is needed to fly, and the drone refuses another fence. */
const FENCE_STATES = new Set(["Idle", "Configure"]);

/** The page's one model: what the drone said, what the operator is about to do. Reports "change" after each change. */
export class Operator extends EventTarget {
  readonly flight = new Flight();
  readonly map = new MapStore();
  readonly daemonClock = new DaemonClock();
  readonly picture = new Picture(this.daemonClock);
  preferences: Preferences;
  picking = false;
  question: Question | null = null;
  lotChanges: ShownChanges | null = null;
  /** Id of the changed plan that this operator leaves. */
  leftOffer: string | null = null;
  readonly hidden = new HiddenPage();
  readonly toasts: Toasts;
  readonly cut: MotorCut;
  readonly fence: FenceEditing;
  readonly outline: OutlineEditing;
  readonly plan: PlanEditing;
  readonly measure = new Measure(() => this.changed());
  readonly controlling: Controlling;
  /** The route to the place that is asked about, where the drone plans one. */
  readonly routePlan: RoutePlan;

  private readonly socket: ReconnectingSocket;
  private readonly commands: Commands;
  private lostReported = false;
  /** This operator asked for the motors to be switched off. */
  private disarming = false;
  /** They went off before take-off, and nobody here asked for it. */
  private selfDisarmed = false;
  /** Who took control while this operator was lost. */
  private taker: string | null = null;

  private readonly history: PlotHistory;
  private readonly alarms = new Alarms();

  private readonly outside: Outside;

  constructor(outside: Outside) {
    super();
    this.outside = outside;
    this.preferences = readPreferences(outside.storage);
    this.history = new PlotHistory(outside.session);
    this.socket = new ReconnectingSocket(outside.commandUrl, outside.open, outside.timers, {
      message: (data) => this.take(data),
      status: (status) => this.linkChanged(status),
      ended: () => outside.logIn?.(),
      refused: () => outside.checkLogin?.(),
    });
    this.commands = new Commands((text) => this.socket.send(text), outside.timers);
    this.toasts = new Toasts(outside.timers, () => this.changed());
    this.cut = new MotorCut({
      command: (command, what) => this.command(command, what),
      send: (command) => this.commands.send(command),
      rate: () => this.daemonClock.rate,
      timers: outside.timers,
      changed: () => this.changed(),
    });
    this.routePlan = new RoutePlan((command) => this.commands.send(command), () => this.changed());
    this.controlling = new Controlling({
      command: (command, what) => this.command(command, what),
      send: (command) => this.commands.send(command),
      heartbeat: () => this.flight.heartbeat,
      name: () => this.preferences.name,
      showToast: (toast) => this.toasts.show(toast),
      note: (level, text) => this.note(level, text),
      say: (text) => outside.say?.(text),
      changed: () => this.changed(),
    });
    this.fence = new FenceEditing({
      send: (command) => this.commands.send(command),
      changed: () => this.changed(),
      showToast: (text, level, quoted) => this.toasts.show({ level, text, ...(quoted ? { quoted } : {}) }),
      timers: outside.timers,
    });
    this.plan = new PlanEditing({
      who: () => [this.preferences.name, this.flight.heartbeat?.["Own Name"]].find((name) => name) ?? say("plan-nameless"),
      changed: () => this.changed(),
      showToast: (text, level) => this.toasts.show({ level, text }),
      timers: outside.timers,
    });
    this.outline = new OutlineEditing({
      command: (command, what) => this.command(command, what),
      changed: () => this.changed(),
      showToast: (text, level) => this.toasts.show({ level, text }),
      storage: outside.storage,
    });
  }

  /** Shows on the map which stalls of a lot begin and end if a survey is taken over; null: none. */
  showChanges(changes: ShownChanges | null): void {
    this.lotChanges = changes;
    this.changed();
  }

  /** What is being drawn on the map: the fence, or the area to explore. */
  get drawing(): Drawing | null {
    return this.fence.open ? this.fence : this.outline.open ? this.outline : null;
  }

  connect(): void {
    this.socket.connect();
  }

  logOut(): void {
    this.outside.logOut?.();
  }

  /** Sends the operator's sign of life, and whether the page is hidden. Not a command: nobody waits for its answer. */
  signOfLife(hidden = false): void {
    const sent = hidden ? { Type: "Heartbeat", Hidden: true } : { Type: "Heartbeat" };
    if (this.flight.heartbeat?.["In Control"]) this.socket.send(JSON.stringify(sent));
    const text = this.hidden.look(hidden, this.view(), this.seconds());
    if (text === null) return;
    this.note("warning", text);
    this.outside.say?.(text);
    this.changed();
  }

  /** Goes on with the plan that the flight began with. */
  leaveOffer(): void {
    this.leftOffer = this.flight.heartbeat?.["Plan Offer"]?.Plan ?? null;
    this.changed();
  }

  /** Flies the plan as somebody changed it. */
  flyPlan(): void {
    const plan = this.flight.heartbeat?.["Plan Offer"]?.Plan;
    if (plan !== undefined) void this.command({ Type: "Fly Plan", Plan: plan }, say("fly-plan"));
  }

  /** Everything that the words on the page depend on. */
  view(): View {
    const heardAt = this.flight.heardAt;
    return {
      link: this.socket.status,
      attempts: this.socket.attempts,
      welcome: this.flight.welcome,
      heartbeat: this.flight.heartbeat,
      silence: heardAt === null ? null : Math.max(0, this.seconds() - heardAt),
      gap: this.flight.gap,
      now: this.outside.wallClock(),
      landedAt: this.flight.landedAt,
      pictureAge: this.picture.age(this.seconds()),
      units: this.preferences.units,
      selfDisarmed: this.selfDisarmed,
      sections: this.flight.sections,
    };
  }

  /** This operator is in control while the motors are on, as far as the page knows. */
  get isFlyingIt(): boolean {
    const { heartbeat } = this.flight;
    return isSteered(heartbeat) && heartbeat?.["In Control"] === true;
  }

  /** Seconds of this page's clock. */
  seconds(): number {
    return this.outside.timers.now() / 1000;
  }

  /** Asks the map to show a stall: "stall" with its number. */
  showStall(stall: number): void {
    this.dispatchEvent(new CustomEvent<number>("stall", { detail: stall }));
  }

  /** Sends a command; a refusal is shown. Resolves to whether it was accepted. */
  async command(command: Command, what: string): Promise<boolean> {
    if (command.Type === "Disarm") this.disarming = true;
    const answer = await this.commands.send(command);
    if (answer.Type !== "Ack" || answer.Accepted) {
      this.toasts.dismiss();
      return true;
    }
    const text = say("refused", { what, reason: answer.Reason === "" ? say("no-reason") : answer.Reason });
    const quoted = isByDrone(answer) ? answer.Reason : "";
    this.toasts.show({ level: "error", text, quoted });
    this.note("warning", text, quoted);
    return false;
  }

  /** Opens the fence editor in place of whatever else is asked. */
  editFence(): void {
    const setup = this.flight.fenceSetup;
    if (!setup || !this.canDraw()) return;
    this.leaveMap();
    this.fence.begin(setup);
  }

  /** Opens the editor of the area to explore. */
  editOutline(): void {
    if (!this.outline.setup || !this.canDraw()) return;
    this.leaveMap();
    this.outline.begin();
  }

  /** Opens the editor of a lot's plan, on the ground and in flight. */
  editPlan(lot: string): void {
    if (this.drawing !== null) return;
    this.leaveMap();
    void this.plan.begin(lot);
  }

  private canDraw(): boolean {
    return this.drawing === null && !this.plan.open && FENCE_STATES.has(this.flight.heartbeat?.State ?? "");
  }

  /** Nothing is asked, and the map is pointed at for nothing. */
  private leaveMap(): void {
    this.question = null;
    this.picking = false;
    this.measure.end();
  }

  async takeControl(): Promise<void> {
    await this.controlling.request();
  }

  async releaseControl(): Promise<void> {
    await this.controlling.release();
  }

  /** Begins to measure, in place of what else the map is pointed at for. */
  beginMeasure(): void {
    if (this.drawing || this.plan.open) return;
    if (this.picking || this.question?.about === "move") this.ask(null);
    this.measure.begin();
  }

  ask(question: Question | null): void {
    if (question?.about === "move") this.measure.end();
    this.question = question;
    this.picking = false;
    if (question?.about === "move" && option(this.view(), "Autonomous Move").Possible) void this.routePlan.ask(question.target);
    else this.routePlan.clear();
    this.changed();
  }

  /** The kind of move that was chosen in place of the one suggested. */
  choose(kind: MoveKind): void {
    if (this.question?.about === "move") this.question = { ...this.question, kind };
    this.changed();
  }

  pick(picking: boolean): void {
    if (picking) this.measure.end();
    this.picking = picking;
    this.question = null;
    this.changed();
  }

  /** A click on the map: a place to move to while one is asked for, or another one for the open question. Returns whether it was taken. */
  pointAt(target: Point, isStall: boolean): boolean {
    const taken = this.picking || (this.question?.about === "move" && !isStall);
    if (taken) this.ask({ about: "move", target });
    return taken;
  }

  /** Leaves the innermost thing that is asked. Returns whether there was one. */
  leave(): boolean {
    if (this.cut.current) this.cut.end();
    else if (this.question) this.ask(null);
    else if (this.picking) this.pick(false);
    else if (this.measure.open) this.measure.end();
    else return this.plan.back();
    return true;
  }

  prefer(preferences: Partial<Preferences>): void {
    this.preferences = { ...this.preferences, ...preferences };
    writePreferences(this.outside.storage, this.preferences);
    this.changed();
  }

  /** Keeps another name, and sends it to the drone. */
  rename(name: string): void {
    const before = this.preferences.name;
    this.prefer({ name });
    if ((before ?? "") !== name) void this.controlling.introduce();
  }

  /** Something that is no part of the model has changed all that is shown. */
  drawAgain(): void {
    this.changed();
  }

  /** Looks at the time: values grow old without any message. */
  tick(): void {
    const lost = linkOf(this.view()) === "lost";
    if (lost && !this.lostReported) {
      this.note("warning", say("link-lost-note"));
      this.question = null;
      this.picking = false;
      if (this.cut.current) this.cut.end();
    }
    if (!lost && this.lostReported) this.note("ok", say("link-back-note"));
    this.lostReported = lost;
    this.sayAlarms();
    this.changed();
  }

  private take(data: string | ArrayBuffer): void {
    const message = readIncoming(data);
    if (!message) return;
    if (message.Type === "Heartbeat") this.hear(message);
    else if (message.Type === "Welcome") {
      this.flight.greet(message);
      this.map.expectAll();
      this.daemonClock.reset(message.Speed);
      this.controlling.greet(message.Role === "operator");
      this.changed();
    } else this.commands.answer(message);
  }

  private hear(heartbeat: Heartbeat): void {
    const at = this.seconds();
    const before = this.flight.heartbeat?.State;
    this.watchDisarming(this.flight.heartbeat, heartbeat);
    this.reportTaken(heartbeat["Control Taken By"]);
    this.daemonClock.add(at, heartbeat.Time);
    const now: Moment = { at, theirs: heartbeat.Time, wall: this.outside.wallClock(), rate: this.daemonClock.rate };
    if (this.flight.heartbeat === null) this.flight.samples = this.history.read(now);
    this.flight.hear(heartbeat, at);
    this.controlling.hear(heartbeat);
    this.history.keep(this.flight.samples, now);
    if (before !== undefined && before !== heartbeat.State) this.question = null;
    if (this.cut.current && heartbeat.Armed === false) this.cut.end();
    this.fence.hear(heartbeat);
    if (heartbeat["Outline Setup"]) this.outline.hear(heartbeat["Outline Setup"]);
    if (!FENCE_STATES.has(heartbeat.State)) {
      this.fence.pause(say("fence-on-ground-only"));
      this.outline.pause(say("outline-paused"));
    }
    const update = heartbeat["Occupancy Map"];
    if (update) this.dispatchEvent(new CustomEvent<MapChange>("map", { detail: this.map.apply(update) }));
    this.sayAlarms();
    this.changed();
  }

  /** The autopilot switches motors that only idle off by itself: Take off is refused then, and the one who waits must know why. */
  private watchDisarming(before: Heartbeat | null, now: Heartbeat): void {
    if (now.Armed === true) this.selfDisarmed = false;
    const idled = before?.State === "Arm" && before.Armed === true && before["In Control"];
    if (!idled || now.State !== "Idle" || now.Armed !== false || now.Killed) return;
    this.selfDisarmed = !this.disarming;
    this.disarming = false;
    if (!this.selfDisarmed) return;
    this.toasts.show({ level: "warning", text: say("disarmed-by-itself") });
    this.note("warning", say("disarmed-by-itself"));
  }

  private sayAlarms(): void {
    for (const text of this.alarms.look(this.view())) this.outside.say?.(text);
  }

  /** Reports once that control was taken while this operator was lost. */
  private reportTaken(taker: string | null): void {
    if (taker !== null && taker !== this.taker) {
      const text = say("took-control", { name: taker });
      this.toasts.show({ level: "warning", text });
      this.note("warning", text);
    }
    this.taker = taker;
  }

  private linkChanged(status: LinkStatus): void {
    if (status !== "open") this.commands.abandon();
    this.changed();
  }

  private note(level: "ok" | "warning" | "info", text: string, quoted = ""): void {
    this.flight.note(level, text, new Date(this.outside.wallClock()).toISOString(), "", quoted);
  }

  private changed(): void {
    this.dispatchEvent(new Event("change"));
  }
}
