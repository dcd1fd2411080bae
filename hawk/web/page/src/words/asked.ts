import type { Question } from "../state/operator.ts";
import * as format from "./format.ts";
import type { View } from "./view.ts";

/** What is asked for by its name alone. */
export type Simple = Exclude<Question["about"], "move">;

export interface AskedWords {
  question: string;
  /** What it means. */
  second: string;
  slide: string;
  /** How it is named when it is refused. */
  label: string;
}

/** Asked because a pilot would be overruled: sent as confirmed. */
export const OVERRULING = new Set<Simple>(["Return To Launch", "Land", "Resume"]);

const OVERRULES = "The remote control is overruled.";

const WORDS: Record<Simple, AskedWords> = {
  Arm: { question: "Start the motors?", second: "Keep clear of the propellers.", slide: "Slide to arm", label: "Arm" },
  Takeoff: { question: "Take off?", second: "Straight up from where it stands.", slide: "Slide to take off", label: "Take off" },
  "Autonomous Explore": {
    question: "Explore the whole lot?",
    second: "It flies by itself inside the fence. Hold stops it.",
    slide: "Slide to explore",
    label: "Explore",
  },
  "Return To Launch": { question: "Return home and land there?", second: OVERRULES, slide: "Slide to return", label: "Return home" },
  Land: { question: "Land straight down?", second: OVERRULES, slide: "Slide to land", label: "Land" },
  "New Survey": {
    question: "Begin a new survey?",
    second: "The map begins empty. The last survey stays stored on the drone.",
    slide: "Slide to begin",
    label: "New survey",
  },
  Resume: {
    question: "Resume, taking over from the remote control?",
    second: "It stops and stays where it is.",
    slide: "Slide to resume",
    label: "Resume",
  },
};

export function askedWords(view: View, about: Simple): AskedWords {
  const words = WORDS[about];
  const height = view.heartbeat?.Heights[1];
  return about === "Takeoff" && height !== undefined ? { ...words, question: `Take off to ${format.height(height, view.units)}?` } : words;
}
