import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { SectionUpdate } from "../src/protocol.ts";
import { CountsCard } from "../src/ui/counts-card.ts";
import { StallsTab } from "../src/ui/stalls-tab.ts";
import { SurveyPanel } from "../src/ui/survey-panel.ts";
import { glanceValues } from "../src/words/glance.ts";
import { inFrench } from "./french.ts";
import { welcome } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const RING = [{ North: 0, East: 0 }, { North: 0, East: 44 }, { North: 2, East: 44 }, { North: 2, East: 0 }];
const ELM: SectionUpdate = { Id: "e", Name: "Elm", Outline: RING, Capacity: 8, Parked: 5, Least: 5, Most: 7, Room: 3, "Seen Share": 1, "Hidden Share": 0 };
const OAK: SectionUpdate = { ...ELM, Id: "o", Name: "Oak", Capacity: 12, Parked: 7, Most: 9, Room: 5 };
const NOT_SEEN = { Parked: null, Least: null, Most: null, Room: null, "Seen Share": null, "Hidden Share": null };

describe("the sections of the lot that is flown over", () => {
  it("are taken up as heartbeats bring them, and kept until one ends or the drone begins again", () => {
    const rig = flying({ Sections: { Changed: [OAK, ELM], Removed: [] } });
    const names = (): string[] => rig.operator.flight.sections.map(({ name, look }) => `${name} ${look?.parked ?? "-"}`);
    assert.deepEqual(names(), ["Elm 5", "Oak 7"]);
    assert.deepEqual(rig.operator.flight.sections[0]?.ring[1], [44, 0], "east and north, as the map has them");
    const before = rig.operator.flight.sections;
    rig.hear({ Sections: null });
    assert.equal(rig.operator.flight.sections, before);
    rig.hear({ Sections: { Changed: [{ ...ELM, ...NOT_SEEN }], Removed: ["o"] } });
    assert.deepEqual(names(), ["Elm -"]);
    rig.server.last.say(welcome());
    rig.hear({ Sections: null });
    assert.deepEqual(names(), []);
  });

  it("are counted on the card, of a lot without stalls", async () => {
    const rig = flying({ Sections: { Changed: [ELM, OAK], Removed: [] } });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /12 of 20 parked/);
    assert.match(stage.text, /Room for 8 more\./);
    assert.deepEqual(glanceValues(rig.operator.view())[0], { name: "free", value: "12/20", age: "", label: "parked", staleLabel: "", trouble: false });
    rig.hear({ Sections: { Changed: [{ ...OAK, ...NOT_SEEN }], Removed: [] } });
    await stage.drawn();
    assert.match(stage.text, /5 of 8 parked, 1 of 2 sections seen/);
    await inFrench(() => assert.equal(glanceValues(rig.operator.view())[0]?.label, "garés"));
    rig.server.last.break();
    rig.timers.advance(4000);
    assert.match(glanceValues(rig.operator.view())[0]?.label ?? "", /^parked, at /);
  });

  it("say no room where that of one is not known, and the number alone where nobody gives places", async () => {
    const rig = flying({ Sections: { Changed: [ELM, { ...OAK, Capacity: null, Room: null }], Removed: [] } });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /12 vehicles/);
    assert.doesNotMatch(stage.text, /[Rr]oom/);
    assert.equal(glanceValues(rig.operator.view())[0]?.value, "12");
  });

  it("stand beside the stalls where a lot has both", async () => {
    const rig = flying({ Free: 3, Taken: 1, Sections: { Changed: [ELM], Removed: [] } });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /4 stalls found/);
    assert.match(stage.text, /Sections: 5 of 8 parked\. Room for 3 more\./);
    assert.equal(glanceValues(rig.operator.view())[0]?.value, "3");
  });

  it("are listed one by one after the landing, and for those who do not see the map", async () => {
    const rig = flying({ State: "Idle", Armed: false, Landed: "ON_GROUND", Sections: { Changed: [ELM, OAK], Removed: [] } });
    for (const part of [new SurveyPanel(), new StallsTab()]) {
      const stage = new Stage(part, rig.operator);
      await stage.drawn();
      const rows = [...stage.part.querySelectorAll("table.sections tbody tr")].map((row) => [...row.children].map((cell) => cell.textContent.trim()));
      assert.deepEqual(rows, [["Elm", "5 of 8 parked", "5–7", "3"], ["Oak", "7 of 12 parked", "5–9", "5"]]);
      assert.doesNotMatch(stage.text, /0 free/);
    }
  });
});
