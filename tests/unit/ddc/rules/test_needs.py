"""Each need of each command: met, the command is accepted; unmet, it is refused with the reason of that need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import pytest

from hawk.comm.protocol.command_table import COMMAND_TABLE, Need
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.fence.outline import OutlineFacts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.orders import Cause, CauseKind, ToArm, ToHover, ToIdle, ToManual, ToReturn, Transition
from hawk.ddc.readings.home import HomeFacts
from hawk.ddc.rules.judge import options
from hawk.ddc.rules.needs import Interlocks, Situation, unmet
from hawk.ddc.states.factory import make_state
from hawk.ddc.witnesses.place import PlaceFacts
from hawk.model.known_lot import LotsAhead, PlanOffer
from hawk.model.operation import Fall
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.vehicle import CopterMode, LandedState
from tests.sweep import sweep
from tests.unit.ddc.fakes import SAFE_PARAMETERS
from tests.unit.ddc.written_facts import DATUM, SETTINGS, flying, on_ground

NOW = 100.0
DOUBTED = PlaceFacts(camera_age=0.1, doubted_s=9.0, off=(4.0, 0.0))
DOUBT = "The camera sees the drone move 4 m that the position does not show."


NO_LOCKS = Interlocks()


@dataclass(frozen=True)
class Scene:
    """A drone in a state."""

    facts: Facts
    transition: Transition
    locks: Interlocks = NO_LOCKS
    unread: frozenset[str] = frozenset()
    """Parameters of the autopilot that were not read."""

    def having(self, part: str, **changes: Any) -> Scene:
        """Return the scene with some facts of a part changed."""
        facts = replace(self.facts, **{part: replace(getattr(self.facts, part), **changes)})
        return replace(self, facts=facts)

    def locking(self, **changes: Any) -> Scene:
        """Return the scene with some interlocks changed."""
        return replace(self, locks=replace(self.locks, **changes))

    def situation(self) -> Situation:
        """Return what is judged."""
        values = {name: value for name, value in SAFE_PARAMETERS.items() if name not in self.unread}
        state = make_state(self.transition, flying(0.0), SETTINGS)[0]
        return Situation(self.facts, state, SETTINGS, values, self.locks)

    def reason(self, command: str) -> str:
        """Return the reason why a command is not possible; empty when it is."""
        (found,) = (option for option in options(self.situation()) if option.command == command)
        assert found.possible is (found.reason == "")
        return found.reason


def standing() -> Facts:
    facts = on_ground(flying(NOW))
    home = HomeFacts(place=DATUM, age=1.0)
    return replace(facts, position=replace(facts.position, autopilot_home=home))


GROUND = Scene(standing(), ToIdle())
ARMED = Scene(standing(), ToArm(armed=True)).having("vehicle", armed=True)
AIR = Scene(flying(NOW), ToHover())
AIR_OFFERED = replace(AIR, facts=replace(AIR.facts, lots=LotsAhead(offer=PlanOffer("lot-2-7", "Lot 1", "Ann", 52, 40))))
WELL = {
    "Configure": GROUND,
    "Arm": GROUND,
    "Takeoff": ARMED,
    "Disarm": ARMED,
    "Resume": Scene(flying(NOW, CopterMode.LOITER), ToManual()),
    "Clear Kill": GROUND.locking(is_killed=True),
    "Set Failsafes": GROUND,
    "Set Fence": GROUND,
    "Clear Fence": GROUND.having("limits", plan=FencePlan("drawn", (), 100.0)),
    "Clear Outline": GROUND.having("limits", outline=OutlineFacts(900.0, 0.0)),
    "Fly Plan": AIR_OFFERED,
    "New Survey": GROUND.having("sight", lot_area=12.0),
}
"""Scenes in which each command is possible; the others in the air."""


def moved_home(scene: Scene) -> Scene:
    home = HomeFacts(scene.facts.position.datum, 0.1, 3.1, None, is_inside=True)
    return scene.having("position", autopilot_home=home)


def heard_no_more(scene: Scene) -> Scene:
    """An armed drone that is not heard is sent home and down all the same."""
    return scene.having("vehicle", armed=False).having("link", is_up=False, age=5.0)


def spent(scene: Scene) -> Scene:
    return scene.having("sight", plan=PathPlan(explore=ExploreStatus(True, 1.0, is_spent=True)))


UNMET: dict[Need, tuple[Callable[[Scene], Scene], str]] = {
    Need.LINK: (heard_no_more, "No link to the autopilot: wait until it is found."),
    Need.NO_FALL: (
        lambda scene: scene.locking(fall=Fall(1.0)),
        "The motors went off in the air: look at the drone, then clear it.",
    ),
    Need.NOT_CUT: (lambda scene: scene.locking(is_killed=True), "The motors were cut: clear it first."),
    Need.CHECKS: (
        lambda scene: scene.having("link", second_sender="10.0.0.6 sends, too."),
        "Link: 10.0.0.6 sends, too. Find out who sends there; name the autopilot in autopilot.vehicle_address.",
    ),
    Need.ARMED: (lambda scene: replace(scene, transition=ToArm()), "Arming: wait until it is armed."),
    Need.KEPT: (
        lambda scene: replace(scene, facts=replace(scene.facts, kept=KeptFacts(lost="its home"))),
        "Somebody changes the autopilot, and it cannot be put back: its home.",
    ),
    Need.HOME: (moved_home, "Home is 3 m from the arm place. It is being set back: wait."),
    Need.FAILSAFES: (
        lambda scene: replace(scene, unread=frozenset({"FS_GCS_ENABLE"})),
        "Ground-station failsafe: not read yet. Wait a moment.",
    ),
    Need.FENCE: (lambda scene: scene.locking(fence_problem="Another fence is there."), "Another fence is there."),
    Need.POSITION: (
        lambda scene: scene.having("position", age=0.6),
        "The position is not known well enough: wait for it.",
    ),
    Need.NO_DOUBT: (lambda scene: scene.having("witness", place=DOUBTED), DOUBT),
    Need.INSIDE: (
        lambda scene: scene.having("limits", breached_s=0.0),
        "Outside the fence: wait until it is back inside.",
    ),
    Need.PERCEPTION: (lambda scene: scene.having("sight", fault="Vision: dark.", fault_s=1.0), "Vision: dark."),
    Need.UNSEEN: (
        spent,
        "Explored already: the lot found is seen whole. Move to other ground first, or land for a new survey.",
    ),
    Need.LOT: (lambda scene: scene.having("sight", lot=False), "No lot in sight: move over the lot first."),
    Need.AIR: (lambda scene: scene.having("vehicle", landed=LandedState.ON_GROUND), "On the ground."),
    Need.GROUND: (
        lambda scene: scene.having("vehicle", landed=LandedState.IN_AIR),
        "In the air: wait until it is on the ground.",
    ),
    Need.NO_CAUSE: (
        lambda scene: replace(scene, transition=ToReturn(Cause("Low battery.", CauseKind.ALWAYS))),
        "Not while this lasts: Low battery.",
    ),
    Need.NOT_AUTOPILOTS: (
        lambda scene: replace(scene, transition=ToReturn(by_autopilot=True)),
        "The autopilot does this by itself.",
    ),
    Need.SWITCH_RESTS: (
        lambda scene: scene.having("link", mode_changed_at=NOW - 1.0),
        "The mode changed just now: wait 2 s.",
    ),
    Need.HOLDABLE: (
        lambda scene: scene.having("witness", place=DOUBTED),
        f"{DOUBT} It could not be held: land it, or fly by hand.",
    ),
    Need.OTHER_FAILSAFES: (
        lambda scene: replace(scene, unread=frozenset({"FS_GCS_ENABLE"})),
        "Ground-station failsafe: not read yet. Wait a moment.",
    ),
    Need.CUT: (lambda scene: scene.locking(is_killed=False), "The motors were not cut."),
    Need.NOT_SETTING: (lambda scene: scene.locking(is_setting=True), "Being set: wait a moment."),
    Need.DRAWN_FENCE: (
        lambda scene: scene.having("limits", plan=FencePlan("circle", (), 100.0)),
        "No fence is drawn: the standard one is used.",
    ),
    Need.OUTLINE: (lambda scene: scene.having("limits", outline=None), "No outline is set."),
    Need.DISARMED: (lambda scene: scene.having("vehicle", armed=True), "Armed: disarm first."),
    Need.OFFER: (
        lambda scene: scene.having("lots", offer=None),
        "No such changed plan waits: look at the newest one.",
    ),
    Need.MAP: (lambda scene: scene.having("sight", lot_area=0.0), "The map is empty: the next flight begins it."),
}
"""Need -> a change by which it is not met, and the reason of the refusal then."""

PAIRS = [(kind, need) for kind, row in COMMAND_TABLE.items() for need in row.needs]


def test_every_need_has_a_test_of_its_reason() -> None:
    assert set(UNMET) == set(Need)


@sweep("command", [kind for kind, row in COMMAND_TABLE.items() if row.states])
def test_a_command_whose_needs_are_met_is_possible(command: str) -> None:
    assert WELL.get(command, AIR).reason(command) == ""


@pytest.mark.slow
@sweep(("command", "need"), PAIRS)
def test_a_need_that_is_not_met_refuses_the_command_with_its_reason(command: str, need: Need) -> None:
    change, reason = UNMET[need]
    scene = change(WELL.get(command, AIR))
    assert scene.reason(command) == reason
    refused = unmet(need, scene.situation())
    assert refused is not None
    assert refused.reason == reason


def test_the_first_need_of_a_row_gives_the_reason() -> None:
    scene = AIR
    for need in (Need.KEPT, Need.INSIDE, Need.NO_DOUBT, Need.POSITION):  # from the last to the first
        scene = UNMET[need][0](scene)
        assert scene.reason("Compulsive Move") == UNMET[need][1]


@pytest.mark.parametrize("need", [Need.FAILSAFES, Need.OTHER_FAILSAFES])
def test_failsafes_that_fail_have_the_remedy_of_their_place(need: Need) -> None:
    def reason(scene: Scene, kept: KeptFacts) -> str:
        situation = replace(scene, facts=replace(scene.facts, kept=kept)).situation()
        situation.values = {**SAFE_PARAMETERS, "FS_GCS_ENABLE": 0.0}
        refused = unmet(need, situation)
        return "" if refused is None else refused.reason.removeprefix("Ground-station failsafe: ")

    assert reason(AIR, KeptFacts()).endswith("Return or land, then Set failsafes.")
    assert reason(ARMED, KeptFacts()).endswith("Disarm, then Set failsafes.")
    assert reason(AIR, KeptFacts(restored=("Ground-station failsafe",))).endswith("It is being put back: wait.")
    known = reason(AIR, KeptFacts(known=("Ground-station failsafe",)))
    assert (known == "") is (need is Need.OTHER_FAILSAFES)


def test_a_failsafe_that_no_parameter_mends_has_a_remedy_of_its_own() -> None:
    off = AIR.having("diagnostics", fence_on=False)
    remedy = "Switch it on at the remote control or the other station, or restart the autopilot."
    assert off.reason("Compulsive Move").endswith(f"switched off. {remedy}")


def test_hover_could_hold_a_drone_that_the_camera_follows() -> None:
    scene = WELL["Resume"].having("witness", place=replace(DOUBTED, is_followed=True))
    assert scene.reason("Resume") == ""
