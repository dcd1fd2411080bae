import { COMMAND_TABLE } from "../command-table.ts";
import type { Question } from "../state/question.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";
import type { View } from "./view.ts";

/** What is asked for by its name alone. */
export type AskedCommand = Exclude<Question["about"], "move">;

export interface ConfirmWords {
  question: string;
  /** What it means. */
  second: string;
  slide: string;
  /** How it is named when it is refused. */
  label: string;
}

/** Whether it is asked because a pilot would be overruled: it is sent as confirmed then. */
export function overrules(about: AskedCommand): boolean {
  return COMMAND_TABLE[about].confirm === "overruling";
}

export function confirmWords(view: View, about: AskedCommand): ConfirmWords {
  switch (about) {
    case "Arm":
      return { question: say("arm-question"), second: say("arm-meaning"), slide: say("arm-slide"), label: say("arm") };
    case "Takeoff":
      return { question: takeoff(view), second: say("takeoff-meaning"), slide: say("takeoff-slide"), label: say("takeoff") };
    case "Autonomous Explore":
      return { ...explore(view), slide: say("explore-slide"), label: say("explore") };
    case "Return To Launch":
      return { question: say("home-question"), second: say("overrules"), slide: say("home-slide"), label: say("home") };
    case "Land":
      return { question: say("land-question"), second: say("overrules"), slide: say("land-slide"), label: say("land") };
    case "New Survey":
      return {
        question: say("new-survey-question"),
        second: say("new-survey-meaning"),
        slide: say("new-survey-slide"),
        label: say("new-survey"),
      };
    case "Resume":
      return { question: say("resume-question"), second: say("resume-meaning"), slide: say("resume-slide"), label: say("resume") };
  }
}

/** Known lots are flown again by a tour whose length is known. */
function explore({ heartbeat, units }: View): Pick<ConfirmWords, "question" | "second"> {
  const metres = heartbeat?.["Again Distance"] ?? null;
  if (metres === null) return { question: say("explore-question"), second: say("explore-meaning") };
  return { question: say("explore-again-question", { lots: heartbeat?.["Again Lots"].length ?? 1 }), second: say("explore-again-meaning", { distance: format.distance(metres, units) }) };
}

function takeoff(view: View): string {
  const height = view.heartbeat?.Heights[1];
  return height === undefined ? say("takeoff-question") : say("takeoff-question-to", { height: format.height(height, view.units) });
}
