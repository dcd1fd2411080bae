import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { CountsCard } from "../src/ui/counts-card.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

describe("a part of the page", () => {
  it("that left the page while it waited to be drawn is let go by the model", async () => {
    const rig = flying();
    const listeners = new Set<unknown>();
    const { operator } = rig;
    const add = operator.addEventListener.bind(operator);
    const remove = operator.removeEventListener.bind(operator);
    operator.addEventListener = (type: string, listener: EventListener | null) => {
      listeners.add(listener);
      add(type, listener);
    };
    operator.removeEventListener = (type: string, listener: EventListener | null) => {
      listeners.delete(listener);
      remove(type, listener);
    };
    const stage = new Stage(new CountsCard(), operator);
    await stage.drawn();
    assert.equal(listeners.size, 1);
    rig.hear({ Free: 3 });
    stage.part.remove();
    await stage.drawn();
    assert.equal(listeners.size, 0);
    document.body.replaceChildren(stage.part);
    await stage.drawn();
    assert.equal(listeners.size, 1, "back on the page it follows the model again");
  });
});
