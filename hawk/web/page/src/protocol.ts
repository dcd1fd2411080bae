// Written by packaging/page_protocol.py from hawk/comm/protocol/commands.py: change that and run this again.

/** Start the motors. */
export interface ArmCommand {
  Type: "Arm";
  Id?: string | number | null;
}

/** Explore the whole lot. */
export interface AutonomousExploreCommand {
  Type: "Autonomous Explore";
  Id?: string | number | null;
}

/** Fly to a place inside the lot. */
export interface AutonomousMoveCommand {
  Type: "Autonomous Move";
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
}

/** Check this fence (answered by FenceCheck); changes nothing and needs no control. */
export interface CheckFenceCommand {
  Type: "Check Fence";
  Id?: string | number | null;
  Corners: FenceCorner[];
  Ceiling: number;
  Zones?: FenceCorner[][];
}

/** Delete the drawn fence: the configured file or circle is valid again. On the ground only. */
export interface ClearFenceCommand {
  Type: "Clear Fence";
  Id?: string | number | null;
}

/** On the ground after a kill: Arm may be asked for again. */
export interface ClearKillCommand {
  Type: "Clear Kill";
  Id?: string | number | null;
}

/** Drop the outline: the next Explore finds the lot by looking. Not while it explores. */
export interface ClearOutlineCommand {
  Type: "Clear Outline";
  Id?: string | number | null;
}

/** Fly to any place inside the fence. */
export interface CompulsiveMoveCommand {
  Type: "Compulsive Move";
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
  Height?: number | null;
}

/** Travel heights, metres above the arm place. */
export interface ConfigureCommand {
  Type: "Configure";
  Id?: string | number | null;
  Min: number;
  Des: number;
  Max: number;
}

/** Control: Request it, Release it; Ask the one who has it, Withdraw that; answer such a question by Give or Keep. */
export interface ControlCommand {
  Type: "Control";
  Id?: string | number | null;
  Action: "Request" | "Release" | "Ask" | "Withdraw" | "Give" | "Keep";
}

/** Stop the motors on the ground. */
export interface DisarmCommand {
  Type: "Disarm";
  Id?: string | number | null;
}

/** Fly the plan of the lot as somebody changed it since the motors are on. Without this the flight goes on with the plan that it began with, and the next one begins with the changed one. */
export interface FlyPlanCommand {
  Type: "Fly Plan";
  Id?: string | number | null;
  Plan: string;
}

/** Stop and stay. */
export interface HoldCommand {
  Type: "Hold";
  Id?: string | number | null;
}

/** Second step: cut the motors at once, with the token that was given for it. */
export interface KillCommand {
  Type: "Kill";
  Id?: string | number | null;
  Token: string;
}

/** First step of cutting the motors: ask for a one-use token (answered by KillToken). */
export interface KillRequestCommand {
  Type: "Kill Request";
  Id?: string | number | null;
}

/** Straight down. */
export interface LandCommand {
  Type: "Land";
  Id?: string | number | null;
  Confirmed?: boolean;
}

/** Send this client the whole map again. */
export interface MapResyncCommand {
  Type: "Map Resync";
  Id?: string | number | null;
}

/** Begin another survey with an empty map. The earlier one stays stored. On the ground only. */
export interface NewSurveyCommand {
  Type: "New Survey";
  Id?: string | number | null;
}

/** The operator's sign of life. */
export interface OperatorHeartbeatCommand {
  Type: "Heartbeat";
  Id?: string | number | null;
  Hidden?: boolean;
}

/** The name by which the others know the sender; null: none. It is shown, and proves nothing. */
export interface OperatorNameCommand {
  Type: "Name";
  Id?: string | number | null;
  Name: string | null;
}

/** Take the drone back from Manual. */
export interface ResumeCommand {
  Type: "Resume";
  Id?: string | number | null;
  Confirmed?: boolean;
}

/** Fly home and land. */
export interface ReturnToLaunchCommand {
  Type: "Return To Launch";
  Id?: string | number | null;
  Confirmed?: boolean;
}

/** Ask for the route that an Autonomous Move there would fly (answered by RouteAnswer); nothing is flown. */
export interface RouteRequestCommand {
  Type: "Route Request";
  Id?: string | number | null;
  X: number;
  Y: number;
  Frame?: "Relative" | "Map";
}

/** Set the autopilot's own failsafes that the preflight check found missing. */
export interface SetFailsafesCommand {
  Type: "Set Failsafes";
  Id?: string | number | null;
}

/** Store this fence: the next Arm uploads it and puts it in force. On the ground only. */
export interface SetFenceCommand {
  Type: "Set Fence";
  Id?: string | number | null;
  Corners: FenceCorner[];
  Ceiling: number;
  Zones?: FenceCorner[][];
}

/** Survey this area: the next Explore sees every place of it inside the fence, and nothing else. */
export interface SetOutlineCommand {
  Type: "Set Outline";
  Id?: string | number | null;
  Polygons: FenceCorner[][];
  Holes?: FenceCorner[][];
}

/** Survey known lots again: the next Explore looks at every stall of their plans once more, then at new ones at their rims. It sets the lots' ground as the outline; Clear Outline ends it. Not while it explores. */
export interface SurveyAgainCommand {
  Type: "Survey Again";
  Id?: string | number | null;
  Lots?: string[];
  Due?: boolean;
}

/** Climb to the desired height. */
export interface TakeoffCommand {
  Type: "Takeoff";
  Id?: string | number | null;
}

export type Command =
  | ArmCommand
  | AutonomousExploreCommand
  | AutonomousMoveCommand
  | CheckFenceCommand
  | ClearFenceCommand
  | ClearKillCommand
  | ClearOutlineCommand
  | CompulsiveMoveCommand
  | ConfigureCommand
  | ControlCommand
  | DisarmCommand
  | FlyPlanCommand
  | HoldCommand
  | KillCommand
  | KillRequestCommand
  | LandCommand
  | MapResyncCommand
  | NewSurveyCommand
  | OperatorHeartbeatCommand
  | OperatorNameCommand
  | ResumeCommand
  | ReturnToLaunchCommand
  | RouteRequestCommand
  | SetFailsafesCommand
  | SetFenceCommand
  | SetOutlineCommand
  | SurveyAgainCommand
  | TakeoffCommand;

/** Answer to one command, to the client that sent it. */
export interface Ack {
  Sentences?: SentenceItem[];
  Type: "Ack";
  Id: string | number | null;
  Accepted: boolean;
  Reason: string;
}

/** One preflight check: its value, and for a failed one the consequence and the remedy. */
export interface CheckItem {
  Name: string;
  Passed: boolean;
  Value: string;
  Consequence: string;
  Remedy: string;
  "Remedy Command": "Set Failsafes" | "Clear Kill" | "Set Fence" | null;
}

/** True when a command would be accepted now; otherwise the reason why not. */
export interface CommandOption {
  Command: string;
  Possible: boolean;
  Reason: string;
}

/** Result of checking a fence. */
export interface FenceCheck {
  Sentences?: SentenceItem[];
  Type: "Fence Check";
  Id: string | number | null;
  Problem: string;
  Notes: string[];
  Inner: FenceCorner[];
  "Inner Zones": FenceCorner[][];
  "North South": number | null;
  "East West": number | null;
  Area: number | null;
}

/** A corner of a fence, WGS-84 degrees: a fence outlives the map in which it was drawn. */
export interface FenceCorner {
  Latitude: number;
  Longitude: number;
}

/** The fence that the next Arm puts in force. */
export interface FenceSetup {
  Sentences?: SentenceItem[];
  Source: "drawn" | "file" | "circle";
  Corners: FenceCorner[];
  Zones: FenceCorner[][];
  Inner: FenceCorner[];
  "Inner Zones": FenceCorner[][];
  Radius: number | null;
  Ceiling: number;
  Margin: number;
  "Ceiling Margin": number;
  "Highest Ceiling": number;
  Problem: string;
}

/** Health of one part. Name: link, position, ground, camera, vision, mapper, planner, recording, requests, tasks, loop, home, remote control, remote id, or rangefinder where there is one. */
export interface HealthItem {
  Name: string;
  Healthy: boolean;
  Reason: string;
}

/** Heartbeat of the drone at 5 Hz: the specification's keys (18.4.5) and ours. */
export interface Heartbeat {
  "Occupancy Map": MapUpdate | null;
  Messages: LogEntry[];
  Trail: Point[];
  "Trail Start": boolean;
  "Fence Setup": FenceSetup | null;
  "Outline Setup": OutlineSetup | null;
  Sections: SectionsUpdate | null;
  Controller: string | null;
  "Controller Lost": boolean;
  "In Control": boolean;
  "Control Taken By": string | null;
  "Own Name": string;
  "Control Asked By": string | null;
  "Control Free In": number | null;
  "Control Kept": boolean;
  Sentences?: SentenceItem[];
  Sequence: number;
  Time: number;
  Utc: string;
  State: string;
  Detail: string;
  "Asked By": string | null;
  "User Error": number;
  "User Error Text": string;
  Options: CommandOption[];
  Checks: CheckItem[];
  Killed: boolean;
  Fallen: boolean;
  "Kill State": "none" | "sending" | "confirmed" | "not confirmed";
  "Return In": number | null;
  "Ardupilot State": string | null;
  Armed: boolean | null;
  Connected: boolean;
  Landed: string;
  "Link Age": number | null;
  "Battery Percentage": number | null;
  "Battery Age": number | null;
  Voltage: number | null;
  "Battery Time Left": number | null;
  "Time Home": number | null;
  "Battery Needed Home": number | null;
  "Battery Needed Survey": number | null;
  "Battery Left": number | null;
  "Survey Basis": "planner" | "map" | "outline" | "fence" | null;
  "Survey Share": number | null;
  "Survey Batteries": number | null;
  "Survey Time Left": number | null;
  Satellites: number | null;
  "Relative Altitude": number | null;
  Latitude: number | null;
  Longitude: number | null;
  "Local Position X": number | null;
  "Local Position Y": number | null;
  North: number | null;
  East: number | null;
  Yaw: number | null;
  Roll: number | null;
  Pitch: number | null;
  Speed: number | null;
  Climb: number | null;
  "Pose Age": number | null;
  "Height Above Ground": number | null;
  "Wind Speed": number | null;
  "Wind From": number | null;
  Home: Point | null;
  Datum: [number, number] | null;
  Fence: Point[];
  "Fence Limit": Point[];
  "Fence Zones": Point[][];
  "Fence Zone Limits": Point[][];
  Ceiling: number | null;
  Heights: [number, number, number];
  "Outline Area": number | null;
  "Outline Outside": number | null;
  "Again Distance": number | null;
  "Again Lots": RoundLotStatus[];
  "Plan Offer": PlanOfferStatus | null;
  Target: Point | null;
  Route: Point[];
  "Flight Time": number | null;
  "Distance Flown": number | null;
  "Vision Rate": number | null;
  "Camera Age": number | null;
  Footprint: Point[];
  "Park Lot Detected": boolean | null;
  "Lot Area": number | null;
  Free: number;
  Taken: number;
  Unknown: number;
  Suggested: number;
  "Free Range": [number, number] | null;
  Explored: number | null;
  "Explore Done": boolean;
  "Outline Unseen": number | null;
  "Left Out": LeftOutStatus | null;
  Remaining: number | null;
  Health: HealthItem[];
  "Health Status": number;
  Type: "Heartbeat";
}

/** One-use token for Kill, valid for ``Valid For`` seconds. */
export interface KillToken {
  Type: "Kill Token";
  Id: string | number | null;
  Token: string;
  "Valid For": number;
}

/** Ground that an exploration did not look at, and why. Square metres. */
export interface LeftOutStatus {
  Outside: number;
  Hidden: number;
  "Given Up": number;
  Beside: number;
}

/** A line of the message list. Level: info, ok, warning or error. Details: the autopilot's own words. */
export interface LogEntry {
  Sentences?: SentenceItem[];
  Number: number;
  Time: string;
  Level: "info" | "ok" | "warning" | "error";
  Text: string;
  Details: string;
}

/** The "Occupancy Map" of a heartbeat: map changes for this client, at most 64 kB, nearest first. */
export interface MapUpdate {
  "Map Id": string;
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

/** The area that Explore is to survey. */
export interface OutlineSetup {
  Sentences?: SentenceItem[];
  Source: "none" | "set" | "file";
  Polygons: FenceCorner[][];
  Holes: FenceCorner[][];
  Area: number;
  Again: string[];
}

/** The plan of the lot that is flown over, as somebody changed it since the motors are on; Fly Plan takes it. */
export interface PlanOfferStatus {
  Plan: string;
  Lot: string;
  By: string | null;
  Stalls: number;
  Before: number;
}

/** A place in the map frame, metres. */
export interface Point {
  North: number;
  East: number;
}

/** A known lot that is surveyed again. */
export interface RoundLotStatus {
  Lot: string;
  Name: string;
  Seen: number;
  "Is Over": boolean;
}

/** Answer to Route Request: points from the drone to the place and length in metres, or the reason for no route. */
export interface RouteAnswer {
  Sentences?: SentenceItem[];
  Type: "Route";
  Id: string | number | null;
  Points: Point[];
  Length: number | null;
  Refused: string | null;
}

/** A changed section of the known lot that is flown over, with the vehicles counted in it so far. */
export interface SectionUpdate {
  Id: string;
  Name: string;
  Outline: Point[];
  Capacity: number | null;
  Parked: number | null;
  Least: number | null;
  Most: number | null;
  Room: number | null;
  "Seen Share": number | null;
  "Hidden Share": number | null;
}

/** Changes of the sections for one client; the rest comes with later heartbeats. */
export interface SectionsUpdate {
  Changed: SectionUpdate[];
  Removed: string[];
}

/** A sentence among the texts of a message: a program that has words of its own for the code shows those. */
export interface SentenceItem {
  Text: string;
  Code: string;
  Values: Record<string, string | number>;
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
  State: "free" | "taken" | "unknown" | "suggested" | null;
  Taken: number | null;
  Seen: number | null;
  "Last Seen": number | null;
  Score: number | null;
  Label: string | null;
}

/** A changed tile of the map. Its north-west corner lies -Row tiles north and Column tiles east of the datum. */
export interface TileUpdate {
  Row: number;
  Column: number;
  Version: number;
  Data: string;
}

/** First message to a client: its session, the server, and the values that stay during the connection. */
export interface Welcome {
  Type: "Welcome";
  Session: string;
  Role: "viewer" | "operator";
  Login: boolean;
  Version: string;
  Simulation: boolean;
  "Cell Size": number;
  "Tile Cells": number;
  "Operator Timeout": number;
  "Operator Hold": number;
  Speed: number;
  "Camera Fov": number;
  "Travel Speed": number;
  Desk: boolean;
}

export type Incoming = Ack | FenceCheck | Heartbeat | KillToken | RouteAnswer | Welcome;
