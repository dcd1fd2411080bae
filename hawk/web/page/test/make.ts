import type { FenceSetup, Heartbeat, MapUpdate, StallUpdate, Welcome } from "../src/protocol.ts";
import type { View } from "../src/words/view.ts";

export function heartbeat(changes: Partial<Heartbeat> = {}): Heartbeat {
  return {
    Type: "Heartbeat",
    State: "Hover",
    "Ardupilot State": "GUIDED",
    "Occupancy Map": null,
    "Relative Altitude": 35,
    Armed: true,
    Latitude: 48,
    Longitude: 11,
    "Local Position X": 0,
    "Local Position Y": 0,
    "Battery Percentage": 89,
    "User Error": 0,
    "Health Status": 0,
    Sequence: 1,
    Time: 100,
    Utc: "2026-01-02T03:04:05Z",
    Detail: "At its place.",
    "User Error Text": "",
    Health: [],
    Landed: "IN_AIR",
    Connected: true,
    North: 0,
    East: 0,
    Yaw: 0,
    Roll: 0,
    Pitch: 0,
    Speed: 0,
    Climb: 0,
    "Pose Age": 0.05,
    "Height Above Ground": null,
    "Wind Speed": 3,
    "Wind From": 0,
    "Battery Age": 0.5,
    "Link Age": 0.1,
    Voltage: 16,
    "Battery Time Left": 800,
    "Time Home": null,
    "Battery Needed Home": 24,
    "Battery Needed Survey": 31,
    "Battery Left": 34,
    "Survey Basis": "planner",
    "Survey Share": 1,
    "Survey Time Left": null,
    Satellites: 16,
    Home: { North: 0, East: 0 },
    Datum: [48, 11],
    Target: null,
    Route: [],
    Footprint: [],
    Fence: [],
    "Fence Limit": [],
    "Fence Zones": [],
    "Fence Zone Limits": [],
    "Fence Setup": null,
    "Outline Setup": null,
    Sections: null,
    "Outline Area": null,
    "Outline Outside": null,
    "Plan Offer": null,
    "Again Distance": null,
    "Again Lots": [],
    "Survey Batteries": null,
    "Outline Unseen": null,
    "Left Out": null,
    Ceiling: 120,
    Heights: [15, 35, 60],
    Explored: null,
    "Explore Done": false,
    Remaining: null,
    "Lot Area": null,
    "Park Lot Detected": true,
    Free: 0,
    Taken: 0,
    Unknown: 0,
    Suggested: 0,
    "Free Range": null,
    "Vision Rate": 8,
    "Camera Age": 0.1,
    Options: [],
    Checks: [],
    Messages: [],
    Controller: "one",
    "Controller Lost": false,
    "In Control": true,
    "Control Taken By": null,
    "Own Name": "one",
    "Control Asked By": null,
    "Control Free In": null,
    "Control Kept": false,
    "Asked By": null,
    Killed: false,
    Fallen: false,
    "Kill State": "none",
    "Return In": null,
    Trail: [],
    "Trail Start": false,
    "Flight Time": null,
    "Distance Flown": null,
    ...changes,
  };
}

export function welcome(changes: Partial<Welcome> = {}): Welcome {
  return {
    Type: "Welcome",
    Session: "one",
    Role: "operator",
    Login: false,
    Version: "0.1.0",
    Simulation: false,
    "Cell Size": 0.1,
    "Tile Cells": 256,
    "Operator Timeout": 10,
    "Operator Hold": 30,
    Speed: 1,
    "Camera Fov": 70,
    "Travel Speed": 4,
    Desk: false,
    ...changes,
  };
}

/** A view at 12:00:00 local time, fresh and in control. */
export function view(changes: Partial<View> = {}): View {
  return {
    link: "open",
    attempts: 0,
    welcome: welcome(),
    heartbeat: heartbeat(),
    silence: 0.1,
    gap: 0.2,
    now: new Date(2026, 0, 2, 12, 0, 0).getTime(),
    landedAt: null,
    pictureAge: null,
    units: "metres",
    sections: [],
    ...changes,
  };
}

export function possible(...commands: string[]): Heartbeat["Options"] {
  return commands.map((Command) => ({ Command, Possible: true, Reason: "" }));
}

export function impossible(Command: string, Reason: string): Heartbeat["Options"][number] {
  return { Command, Possible: false, Reason };
}

export function stall(Id: number, changes: Partial<StallUpdate> = {}): StallUpdate {
  return {
    Id,
    Version: 1,
    Removed: false,
    North: 1,
    East: 2,
    Angle: 0,
    Width: 2.5,
    Length: 5,
    State: "free",
    Taken: 0.1,
    Seen: 4,
    "Last Seen": 90,
    Score: 0.9,
    Label: null,
    ...changes,
  };
}

export function mapUpdate(changes: Partial<MapUpdate> = {}): MapUpdate {
  return { "Map Id": "a", Tiles: [], Stalls: [], Mosaic: [], Backlog: 0, ...changes };
}

/** The standard fence. */
export const CIRCLE: FenceSetup = {
  Source: "circle",
  Corners: [],
  Zones: [],
  Inner: [],
  "Inner Zones": [],
  Radius: 150,
  Ceiling: 100,
  Margin: 5,
  "Ceiling Margin": 3,
  "Highest Ceiling": 100,
  Problem: "",
};
