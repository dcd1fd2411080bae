// Written by packaging/page_protocol.py from hawk/comm/messages.py: change that and run this again.

/** Start the motors. */
export interface ArmCommand {
  Id?: string | number | null;
  Type: "Arm";
}

/** See the whole lot. */
export interface AutonomousExploreCommand {
  Id?: string | number | null;
  Type: "Autonomous Explore";
}

/** Fly to a place inside the lot. */
export interface AutonomousMoveCommand {
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
  Type: "Autonomous Move";
}

/** Ask what would be said about this fence (answered by FenceCheck); changes nothing and needs no control. */
export interface CheckFenceCommand {
  Id?: string | number | null;
  Corners: FenceCorner[];
  Ceiling: number;
  Type: "Check Fence";
}

/** Put the drawn fence aside: the configured file or circle counts again. On the ground only. */
export interface ClearFenceCommand {
  Id?: string | number | null;
  Type: "Clear Fence";
}

/** On the ground after a kill: Arm may be asked for again. */
export interface ClearKillCommand {
  Id?: string | number | null;
  Type: "Clear Kill";
}

/** Fly to any place inside the fence. */
export interface CompulsiveMoveCommand {
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
  Type: "Compulsive Move";
  Height?: number | null;
}

/** Travel heights, metres above the arm place. */
export interface ConfigureCommand {
  Id?: string | number | null;
  Type: "Configure";
  Min: number;
  Des: number;
  Max: number;
}

/** Ask for control or give it back. */
export interface ControlCommand {
  Id?: string | number | null;
  Type: "Control";
  Action: "Request" | "Release";
}

/** Stop the motors on the ground. */
export interface DisarmCommand {
  Id?: string | number | null;
  Type: "Disarm";
}

/** Stop and stay. */
export interface HoldCommand {
  Id?: string | number | null;
  Type: "Hold";
}

/** Second step: cut the motors at once, with the token that was given for it. */
export interface KillCommand {
  Id?: string | number | null;
  Type: "Kill";
  Token: string;
}

/** First step of cutting the motors: ask for a one-use token (answered by KillToken). */
export interface KillRequestCommand {
  Id?: string | number | null;
  Type: "Kill Request";
}

/** Straight down. */
export interface LandCommand {
  Id?: string | number | null;
  Type: "Land";
  Confirmed?: boolean;
}

/** Forget what this client was sent of the map: send it again. */
export interface MapResyncCommand {
  Id?: string | number | null;
  Type: "Map Resync";
}

/** The operator's sign of life. */
export interface OperatorHeartbeatCommand {
  Id?: string | number | null;
  Type: "Heartbeat";
}

/** Take the drone back from Manual. */
export interface ResumeCommand {
  Id?: string | number | null;
  Type: "Resume";
  Confirmed?: boolean;
}

/** Fly home and land. */
export interface ReturnToLaunchCommand {
  Id?: string | number | null;
  Type: "Return To Launch";
  Confirmed?: boolean;
}

/** Ask for the way that an Autonomous Move there would take (answered by RouteAnswer); nothing is flown. */
export interface RouteRequestCommand {
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
  Type: "Route Request";
}

/** Set the autopilot's own failsafes that the preflight check found missing. */
export interface SetFailsafesCommand {
  Id?: string | number | null;
  Type: "Set Failsafes";
}

/** Keep this fence: the next Arm uploads it and puts it in force. On the ground only. */
export interface SetFenceCommand {
  Id?: string | number | null;
  Corners: FenceCorner[];
  Ceiling: number;
  Type: "Set Fence";
}

/** Climb to the desired height. */
export interface TakeoffCommand {
  Id?: string | number | null;
  Type: "Takeoff";
}

export type Command =
  | ArmCommand
  | AutonomousExploreCommand
  | AutonomousMoveCommand
  | CheckFenceCommand
  | ClearFenceCommand
  | ClearKillCommand
  | CompulsiveMoveCommand
  | ConfigureCommand
  | ControlCommand
  | DisarmCommand
  | HoldCommand
  | KillCommand
  | KillRequestCommand
  | LandCommand
  | MapResyncCommand
  | OperatorHeartbeatCommand
  | ResumeCommand
  | ReturnToLaunchCommand
  | RouteRequestCommand
  | SetFailsafesCommand
  | SetFenceCommand
  | TakeoffCommand;

/** Answer to one command, to the client that sent it. */
export interface Ack {
  Type: "Ack";
  Id: string | number | null;
  Accepted: boolean;
  Reason: string;
}

/** One preflight check: what was found, and for a failed one the consequence and the remedy. */
export interface CheckItem {
  Name: string;
  Passed: boolean;
  Value: string;
  Consequence: string;
  Remedy: string;
  RemedyCommand: "Set Failsafes" | "Clear Kill" | "Set Fence" | null;
}

/** Whether a command would be taken now, and why not. */
export interface CommandOption {
  Command: string;
  Possible: boolean;
  Reason: string;
}

/** What speaks against a fence, and what the drone would make of it. */
export interface FenceCheck {
  Type: "Fence Check";
  Id: string | number | null;
  Problem: string;
  Notes: string[];
  Inner: FenceCorner[];
  "North South": number | null;
  "East West": number | null;
  Area: number | null;
}

/** A corner of a fence, WGS-84 degrees. */
export interface FenceCorner {
  Latitude: number;
  Longitude: number;
}

/** Which fence the next Arm puts in force. */
export interface FenceSetup {
  Source: "drawn" | "file" | "circle";
  Corners: FenceCorner[];
  Inner: FenceCorner[];
  Radius: number | null;
  Ceiling: number;
  Margin: number;
  "Ceiling Margin": number;
  "Highest Ceiling": number;
  Problem: string;
}

/** Health of one part. Name: link, position, vision, mapper, planner, camera, recording or loop. */
export interface HealthItem {
  Name: string;
  Healthy: boolean;
  Reason: string;
}

/** What the drone tells at 5 Hz: the specification's keys (18.4.5), then ours. */
export interface Heartbeat {
  Type: "Heartbeat";
  State: string;
  "Ardupilot State": string | null;
  "Occupancy Map": MapUpdate | null;
  "Relative Altitude": number | null;
  Armed: boolean | null;
  Latitude: number | null;
  Longitude: number | null;
  "Local Position X": number | null;
  "Local Position Y": number | null;
  "Battery Percentage": number | null;
  "User Error": number;
  "Health Status": number;
  Sequence: number;
  Time: number;
  UTC: string;
  Detail: string;
  "User Error Text": string;
  Health: HealthItem[];
  Landed: string;
  Connected: boolean;
  North: number | null;
  East: number | null;
  Yaw: number | null;
  Roll: number | null;
  Pitch: number | null;
  Speed: number | null;
  Climb: number | null;
  "Pose Age": number | null;
  "Battery Age": number | null;
  "Link Age": number | null;
  Voltage: number | null;
  "Battery Time Left": number | null;
  Satellites: number | null;
  Home: Point | null;
  Datum: number[] | null;
  Target: Point | null;
  Route: Point[];
  Footprint: Point[];
  Fence: Point[];
  "Fence Limit": Point[];
  "Fence Setup": FenceSetup | null;
  Ceiling: number | null;
  Heights: number[];
  Explored: number | null;
  "Explore Done": boolean;
  Remaining: number | null;
  "Lot Area": number | null;
  "Park Lot Detected": boolean | null;
  Free: number;
  Taken: number;
  Unknown: number;
  "Vision Rate": number | null;
  "Camera Age": number | null;
  Options: CommandOption[];
  Checks: CheckItem[];
  Messages: LogEntry[];
  Controller: string | null;
  "In Control": boolean;
  Killed: boolean;
  "Kill State": "none" | "sending" | "confirmed" | "not confirmed";
  "Return In": number | null;
  Trail: Point[];
  "Trail Start": boolean;
  "Flight Time": number | null;
  Way: number | null;
}

/** One-use token for Kill, valid for ``ValidFor`` seconds. */
export interface KillToken {
  Type: "Kill Token";
  Id: string | number | null;
  Token: string;
  ValidFor: number;
}

/** A line of the message list. Level: info, ok, warning or error. Details: the autopilot's own words. */
export interface LogEntry {
  Number: number;
  Time: string;
  Level: "info" | "ok" | "warning" | "error";
  Text: string;
  Details: string;
}

/** The "Occupancy Map" of a heartbeat: what changed for this client, at most 64 kB, nearest first. */
export interface MapUpdate {
  MapId: string;
  Tiles: TileUpdate[];
  Stalls: StallUpdate[];
  Mosaic: MosaicVersion[];
  Backlog: number;
}

/** A changed mosaic tile; its picture is at /api/mosaic/{Row}/{Column}.jpg?v={Version}. */
export interface MosaicVersion {
  Row: number;
  Column: number;
  Version: number;
}

/** A place in the map frame, metres. */
export interface Point {
  North: number;
  East: number;
}

/** Answer to Route Request: the points of the way from the drone, its length in metres, or why there is none. */
export interface RouteAnswer {
  Type: "Route";
  Id: string | number | null;
  Points: Point[];
  Length: number | null;
  Refused: string | null;
}

/** A changed stall. ``Removed``: it is gone. Angle in radians clockwise from north of the long side. */
export interface StallUpdate {
  Id: number;
  Version: number;
  Removed: boolean;
  North: number | null;
  East: number | null;
  Angle: number | null;
  Width: number | null;
  Length: number | null;
  State: "free" | "taken" | "unknown" | null;
  Taken: number | null;
  Seen: number | null;
  LastSeen: number | null;
  Score: number | null;
}

/** A changed tile: base64 of zlib of TileCells² bytes of cell classes. */
export interface TileUpdate {
  Row: number;
  Column: number;
  Version: number;
  Data: string;
}

/** First message to a client: who it is, which server, and what never changes during the connection. */
export interface Welcome {
  Type: "Welcome";
  Session: string;
  Version: string;
  Simulation: boolean;
  CellSize: number;
  TileCells: number;
  OperatorTimeout: number;
  OperatorHold: number;
  Speed: number;
  CameraFov: number;
}

export type Incoming = Ack | FenceCheck | Heartbeat | KillToken | RouteAnswer | Welcome;
