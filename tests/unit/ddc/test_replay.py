"""Recorded flights are decided again: the same memory, facts and commands give the same decisions."""

from __future__ import annotations

import ast
import hashlib
import inspect
import json
import textwrap
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from hawk.cli import main
from hawk.comm.protocol.commands import (
    Arm,
    AutonomousExplore,
    AutonomousMove,
    ClearKill,
    CompulsiveMove,
    Configure,
    Hold,
    Kill,
    KillRequest,
    KillToken,
    Land,
    ReturnToLaunch,
    RouteRequest,
    SetFailsafes,
    Takeoff,
)
from hawk.config.sections import Config, HeightSettings, StoreSettings
from hawk.ddc import memory, recorder
from hawk.ddc.memory import FORMAT, MemoryFormatError, remember, restore
from hawk.ddc.recorder import COMMAND, DECISION, LEAVE, MEMORY, TICK, plain
from hawk.ddc.replay import Comparison, Moment, ReplayError, compare, compare_recording, decide_again, moments
from hawk.ddc.rules.kill import KillTokens
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.plans import Inbound
from hawk.model.poses import GlobalPose
from hawk.model.vehicle import CopterMode
from hawk.store.frame_codec import to_json
from hawk.store.recording import Recording
from tests.unit.ddc.fakes import DEFAULT_PARAMETERS, PLACE, TICK_S, Rig
from tests.unit.ddc.test_operations_manager_properties import Flight


async def survey(rig: Rig) -> None:
    """A whole survey: failsafes set, heights saved, explored, moved, home."""
    await rig.run(2)
    rig.order(SetFailsafes())
    await rig.run(3)
    rig.order(Configure(min=12, des=25, max=48))
    await rig.until(StateName.IDLE)  # a thread writes them
    await rig.run(2)
    rig.order(Arm())
    await rig.run(1)
    rig.order(Takeoff())
    await rig.until(StateName.HOVER)
    rig.target_plan(20, 10)
    rig.order(AutonomousExplore())
    await rig.run(8)
    rig.finish_plan()
    await rig.until(StateName.HOVER)
    rig.manager.handle("eve", RouteRequest(x=10, y=10))
    rig.manager.handle("ana", AutonomousMove(x=10, y=0))
    await rig.run(8)
    assert not rig.command(CompulsiveMove(x=500, y=0)).accepted
    rig.order(ReturnToLaunch())
    await rig.until(StateName.IDLE)


async def troubles(rig: Rig) -> None:
    """A start in the air, an operator lost, a breach, a jump, a lost link, a pilot."""
    rig.autopilot.put_in_air()
    await rig.run(1)
    rig.desk.present = False
    await rig.run(3)
    rig.desk.present = True
    await rig.run(1)
    rig.order(CompulsiveMove(x=60, y=0))
    await rig.run(2)
    rig.autopilot.topics.frame_jump.publish(4.0)
    rig.autopilot.topics.estimate_jump.publish(9.0)
    rig.autopilot.move_home(GlobalPose(PLACE.latitude + 0.003, PLACE.longitude, PLACE.altitude))
    await rig.run(1)
    rig.autopilot.north = 148.0
    await rig.run(3)
    rig.autopilot.connected = False
    await rig.run(5)
    rig.autopilot.connected = True
    await rig.run(2)
    rig.autopilot.change_mode(CopterMode.LOITER)
    await rig.run(4)
    rig.order(Land(confirmed=True))
    await rig.until(StateName.IDLE)


async def refusals(rig: Rig) -> None:
    """Refused by the autopilot, by the planner and by the judge; then the motors are cut."""
    await rig.run(2)
    rig.autopilot.refuse["arm"] = "Arm: Throttle too high"
    rig.order(Arm())
    await rig.run(2)
    rig.autopilot.refuse.clear()
    rig.order(Arm())
    await rig.run(1)
    rig.order(Takeoff())
    await rig.until(StateName.HOVER)
    rig.sight.inbound = Inbound.OUTSIDE
    rig.manager.handle("ana", AutonomousMove(x=20, y=0))
    await rig.run(2)
    rig.autopilot.refuse["set_mode"] = "EKF variance"
    rig.order(ReturnToLaunch())
    await rig.run(5)
    rig.autopilot.refuse.clear()
    assert rig.command(Hold(), client="eve").reason
    token = rig.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    assert not rig.command(Kill(token="a guess that is wrong")).accepted
    token = rig.manager.handle_now("ana", KillRequest())
    assert isinstance(token, KillToken)
    rig.order(Kill(token=token.token))
    await rig.run(3)
    rig.order(ClearKill())
    await rig.run(1)


FLIGHTS: list[Callable[[Rig], Awaitable[None]]] = [survey, troubles, refusals]
Records = list[tuple[str, dict[str, Any]]]


def recorded(rig: Rig) -> Records:
    """Return the records as a file would give them back."""
    return [(kind, json.loads(to_json(payload))) for kind, payload in rig.records]


def as_recorded(decision: Any) -> Any:
    return json.loads(to_json(plain(decision)))


async def flown(fly: Callable[[Rig], Awaitable[None]], folder: Path) -> tuple[Rig, Records]:
    rig = Rig(folder, parameters=DEFAULT_PARAMETERS if fly is survey else None)
    await fly(rig)
    await rig.close()
    return rig, recorded(rig)


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Record the memory every second."""
    monkeypatch.setattr(recorder, "MEMORY_S", 0.999)


@pytest.mark.slow
@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("fly", FLIGHTS, ids=lambda fly: fly.__name__)
async def test_the_facts_of_a_flight_give_every_decision_again(
    fly: Callable[[Rig], Awaitable[None]], tmp_path: Path
) -> None:
    """Entered at every memory, at the first one alone, and in a file whose beginning is lost."""
    rig, records = await flown(fly, tmp_path)
    flight = list(moments(records))
    assert len([moment for moment in flight if moment.command is None]) == rig.manager.ticks
    assert sum(bool(moment.decision["acts"]) for moment in flight) > 30
    starts = [place for place, (kind, _) in enumerate(records) if kind == MEMORY]
    assert len(starts) > 20
    first = [record for place, record in enumerate(records) if place not in starts[1:]]
    later = records[starts[-5] :]
    for given, entered, decided in ((records, len(starts), flight), (first, 1, flight), (later, 5, moments(later))):
        found = compare(given, rig.settings)
        assert (found.decided, found.entered, found.left_out) == (len(list(decided)), entered, 0)
        assert found.differences == ()
    if fly is troubles:
        changed = [_without_operator(moment) for moment in moments(first)]
        again = [as_recorded(decision) for _, decision in decide_again(changed, rig.settings)]
        assert len(again) == len(flight)
        assert again != [moment.decision for moment in flight], "other facts give other decisions"


@pytest.mark.slow
async def test_a_decision_that_differs_is_shown_with_its_time(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    changed = next(payload for kind, payload in records if kind == "decision")
    changed["fault"] = "another one"
    (difference,) = compare(records, rig.settings).differences
    assert difference.recorded["fault"] == "another one"
    assert difference.again["fault"] == ""
    assert difference.at == next(iter(moments(records))).facts.now


@pytest.mark.slow
async def test_a_memory_that_differs_is_shown(tmp_path: Path, often: None) -> None:
    rig, records = await flown(_wait, tmp_path)
    memories = [payload for kind, payload in records if kind == MEMORY]
    memories[2]["decider"][3]["_fault"] = "never happened"
    first = compare(records, rig.settings).differences[0]
    assert first.command == MEMORY
    assert first.again["decider"][3]["_fault"] == ""


@pytest.mark.slow
@pytest.mark.usefixtures("often")
async def test_moments_after_lost_records_wait_for_the_next_memory(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    ticks = [place for place, (kind, _) in enumerate(records) if kind == TICK]
    del records[ticks[23]]
    found = compare(records, rig.settings)
    assert found.left_out == 16  # of the twenty ticks of that second: 20, 21 and 22 came before
    assert found.differences == ()


@pytest.mark.slow
async def test_the_end_of_the_program_in_the_air_is_decided_again(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.autopilot.put_in_air()
    await rig.run(1)
    assert await rig.manager.shutdown_in_air()
    await rig.run(1)
    await rig.close()
    records = recorded(rig)
    assert [kind for kind, _ in records].count(LEAVE) == 1
    assert rig.state is StateName.RETURN_TO_LAUNCH
    assert compare(records, rig.settings).differences == ()


@pytest.mark.slow
async def test_a_file_is_decided_again_by_the_settings_in_it(tmp_path: Path) -> None:
    config = Config(heights=HeightSettings(minimum_m=14.0))
    rig = Rig(tmp_path, settings=DdcSettings.from_config(config))
    await troubles(rig)
    await rig.close()
    path = await _file(tmp_path, rig, config.model_dump_json())
    found = compare_recording(path)
    assert (found.entered, found.left_out, found.differences) == (1, 0, ())
    assert found.decided == sum(kind in (TICK, COMMAND) for kind, _ in rig.records)


@pytest.mark.slow
async def test_facts_whose_decision_a_crash_may_have_lost_are_not_compared(tmp_path: Path) -> None:
    config = Config(heights=HeightSettings(minimum_m=15.0))
    rig = Rig(tmp_path, settings=DdcSettings.from_config(config))
    await _wait(rig)
    await rig.close()
    while rig.records[-1][0] != DECISION:
        rig.records.pop()
    rig.records.pop()  # the disk never got it
    path = await _file(tmp_path, rig, config.model_dump_json())
    (difference,) = compare_recording(path).differences
    assert difference.recorded["acts"] == []
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - len(b"\x89MCAP0\r\n")])
    assert compare_recording(path).differences == ()


@pytest.mark.slow
async def test_the_command_prints_how_much_differs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = Config(heights=HeightSettings(minimum_m=15.0))
    rig = Rig(tmp_path, settings=DdcSettings.from_config(config))
    await _wait(rig)
    await rig.close()
    same = await _file(tmp_path / "same", rig, config.model_dump_json())
    assert main(["replay", str(same), "--check"]) == 0
    assert f"{same}: " in (said := capsys.readouterr().out)
    assert " decisions made again, 0 differ" in said
    number = next(n for n, (kind, _) in enumerate(rig.records) if kind == DECISION)
    rig.records[number] = (DECISION, {"acts": [], "fault": "of another version"})
    other = await _file(tmp_path / "other", rig, config.model_dump_json())
    assert main(["replay", str(other), "--check", "--json", str(tmp_path / "found.json")]) == 1
    assert "'fault': 'of another version'} before, {'acts': [{" in capsys.readouterr().out
    (difference,) = json.loads((tmp_path / "found.json").read_text())["differences"]
    assert difference["recorded"]["fault"] == "of another version"


@pytest.mark.slow
async def test_the_command_names_the_damage_of_a_file_that_was_cut(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = Rig(tmp_path)
    await _wait(rig)
    await rig.close()
    path = await _file(tmp_path, rig, Config().model_dump_json())
    assert main(["replay", str(path), "--check"]) == 0
    assert "damage" not in capsys.readouterr().out
    whole = compare_recording(path)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) - len(b"\x89MCAP0\r\n")])
    assert main(["replay", str(path), "--check", "--json", str(tmp_path / "found.json")]) == 0
    words = "the file has no end: a crash or a copy cut it off"
    assert f"  decided up to the damage at {whole.seconds:.1f} s: {words}\n" in capsys.readouterr().out
    assert json.loads((tmp_path / "found.json").read_text())["damage"] == words
    assert whole.seconds > 1.0


async def test_the_command_refuses_what_is_no_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "notes.mcap").write_text("notes of a flight\n" * 9)
    assert main(["replay", str(tmp_path / "notes.mcap"), "--check"]) == 1
    assert "notes.mcap: is no recording, or damaged" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("configuration", "words"),
    [
        ('{"wings": {"count": 2}}', "its settings cannot be used: 1 validation error"),
        ("not JSON", "its settings cannot be used: Expecting value"),
        ("{}", "holds no memory of the decider"),
    ],
)
async def test_a_file_whose_settings_or_memory_are_of_no_use_is_refused(
    configuration: str, words: str, tmp_path: Path
) -> None:
    path = await _file(tmp_path, Rig(tmp_path), configuration)
    with pytest.raises(ReplayError, match=words) as caught:
        compare_recording(path)
    assert str(caught.value).startswith(str(path))
    assert str(caught.value).endswith("use hawk-drone of an earlier version, which recorded it")


async def _file(folder: Path, rig: Rig, configuration: str) -> Path:
    """Return a recording of a rig's records."""
    store = StoreSettings(directory=folder, minimum_free_mb=1)
    recording = Recording(store, rig.clock, {"configuration": configuration})
    recording.begin()
    for kind, payload in [("vehicle", {"event": "FOUND"}), *rig.records]:
        recording.record(kind, payload)
        rig.clock.advance(0.01)
    await recording.close()
    assert recording.path is not None
    return recording.path


@pytest.mark.slow
async def test_a_recording_of_a_version_without_memories_is_refused(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    without = [(kind, payload) for kind, payload in records if kind != MEMORY]
    with pytest.raises(ReplayError, match="holds no memory of the decider"):
        compare(without, rig.settings)


@pytest.mark.slow
async def test_a_file_that_was_cut_at_its_first_moment_holds_nothing_to_decide(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    first = next(number for number, (kind, _) in enumerate(records) if kind == TICK)
    assert compare(records[: first + 1], rig.settings, is_whole=False) == Comparison(0, 0, 0, ())


@pytest.mark.slow
async def test_facts_of_another_version_are_refused(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    next(payload for kind, payload in records if kind == TICK)["facts"]["vehicle"] = {"armed": "perhaps"}
    with pytest.raises(ReplayError, match="a record of tick is of another version"):
        compare(records, rig.settings)


@pytest.mark.slow
async def test_a_memory_of_another_format_is_refused(tmp_path: Path) -> None:
    rig, records = await flown(_wait, tmp_path)
    next(payload for kind, payload in records if kind == MEMORY)["format"] = FORMAT + 1
    with pytest.raises(ReplayError, match=f"has format {FORMAT + 1}, this program reads {FORMAT}: use the version"):
        compare(records, rig.settings)


@pytest.mark.parametrize(
    "coded",
    [
        ["object", "subprocess.Popen", 0, {}],
        ["value", "ddc.orders.ToIdle", {"wings": 2}],
        ["enum", "model.vehicle.CopterMode", "sideways"],
        ["model", "comm.protocol.commands.Arm", {"Type": "Land"}],
        ["same", 4],
        ["given", "password"],
        ["what"],
        [],
        ["tuple", 1],
        None,
    ],
    ids=str,
)
def test_what_is_no_memory_is_refused(coded: Any, tmp_path: Path) -> None:
    with pytest.raises(MemoryFormatError, match="memory"):
        restore({"format": FORMAT, "decider": coded}, Rig(tmp_path).settings, KillTokens())


def test_an_object_of_a_foreign_class_is_not_remembered(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    decider = rig.manager._decider
    decider._fault = Path("/")  # type: ignore[assignment]
    with pytest.raises(MemoryFormatError, match="Path is no class of the decider's memory"):
        remember(decider, rig.settings, decider._desk._tokens)


class RecordedFlight(Flight):
    """Whatever may happen in a flight, recorded and decided again: also in the long ticks of a busy computer."""

    async def _ticks(self, count: int) -> None:
        await self.rig.run(count * TICK_S)

    def teardown(self) -> None:
        if hasattr(self, "rig"):
            found = compare(recorded(self.rig), self.rig.settings)
            assert found.left_out == 0
            assert found.differences == ()
        super().teardown()


@pytest.mark.slow
@pytest.mark.usefixtures("often")
class TestRecordedFlight(RecordedFlight.TestCase):  # type: ignore[misc, valid-type]
    settings = settings(
        max_examples=3,
        stateful_step_count=25,
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    )


SHAPE = "b013aa139049771a"
"""Digest of the attributes of every class that a memory may hold, for `FORMAT`."""


@pytest.mark.slow
def test_a_memory_of_another_shape_has_another_number() -> None:
    """Write the new digest here when this fails; raise FORMAT in hawk.ddc.memory where an older memory cannot go on.

    With a new field that the class itself gives a default it can; one that `__init__` alone sets an older memory lacks.
    """
    kinds = memory._kinds().items()
    shape = {name: sorted(_attributes(kind)) for name, kind in kinds if kind.__module__.startswith("hawk.ddc.")}
    digest = hashlib.sha256(json.dumps(shape, sort_keys=True).encode()).hexdigest()[:16]
    assert (FORMAT, digest) == (1, SHAPE)


def test_each_class_of_a_memory_has_a_name_of_its_own_and_an_older_memory_may_name_its_module(tmp_path: Path) -> None:
    every = [
        value
        for module in memory._MODULES
        for value in vars(module).values()
        if isinstance(value, type) and value.__module__ == module.__name__
    ]
    assert len(every) == len(memory._kinds())
    rig = Rig(tmp_path)
    decider = rig.manager._decider
    tokens = decider._desk._tokens
    written = json.dumps(remember(decider, rig.settings, tokens))
    older = written.replace('["object", "Keeper"', '["object", "ddc.keeping.keeper.Keeper"')
    assert older != written
    assert json.dumps(remember(restore(json.loads(older), rig.settings, tokens), rig.settings, tokens)) == written
    assert memory.is_same(json.loads(older), json.loads(written))
    assert not memory.is_same(json.loads(older.replace("KeptHome", "KeptFence")), json.loads(written))


def _attributes(kind: type[Any]) -> Iterator[str]:
    """Give the attributes that the methods of a class set."""
    for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(kind)))):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr
    if hasattr(kind, "__dataclass_fields__"):
        yield from (item.name for item in fields(kind))


async def _wait(rig: Rig) -> None:
    await rig.tick(60)


def _without_operator(moment: Moment) -> Moment:
    operator = replace(moment.facts.operator, is_present=False)
    return replace(moment, facts=replace(moment.facts, operator=operator))
