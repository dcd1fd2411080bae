from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.protocol.commands import Arm, Configure
from hawk.config.sections import FenceSettings
from hawk.ddc.parameters.heights import ParameterError, ParameterStore, heights_problem
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import StateName
from hawk.model.plans import HeightParameters
from tests.unit.ddc.fakes import Rig

DEFAULTS = HeightParameters(15, 35, 60)


def store(tmp_path: Path, ceiling: float = 97) -> ParameterStore:
    return ParameterStore(tmp_path / "var", DEFAULTS, ceiling)


def put(tmp_path: Path, content: bytes) -> Path:
    path = tmp_path / "var" / "params.json"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize(
    ("heights", "field"),
    [
        ((0, 20, 30), "Min"),
        ((-1, 20, 30), "Min"),
        ((20, 19, 30), "Des"),
        ((10, 20, 19), "Max"),
        ((10, 20, 98), "Max"),
        ((float("nan"), 20, 30), "Min"),
        ((10, float("nan"), 30), "Des"),
        ((10, 20, float("nan")), "Max"),
    ],
)
def test_heights_that_do_not_rise_are_refused_by_the_fields_name(
    heights: tuple[float, float, float], field: str
) -> None:
    assert heights_problem(HeightParameters(*heights), 97).startswith(f"{field}: ")


def test_min_stays_clear_of_the_highest_obstacle() -> None:
    problem = heights_problem(HeightParameters(16, 20, 30), 97, 17)
    assert problem.startswith("Min: 16 m is too low over the highest obstacle: raise Min to 17 m")
    assert heights_problem(HeightParameters(17, 20, 30), 97, 17) == ""


def test_equal_heights_are_good() -> None:
    assert heights_problem(HeightParameters(97, 97, 97), 97) == ""


def test_no_file_means_the_defaults_without_a_word(tmp_path: Path) -> None:
    assert store(tmp_path).read() == (DEFAULTS, "")


@pytest.mark.slow
@given(st.tuples(*[st.floats(0.5, 97)] * 3).map(sorted))
def test_what_is_written_is_read_again(tmp_path_factory: pytest.TempPathFactory, heights: list[float]) -> None:
    folder = tmp_path_factory.mktemp("heights")
    wanted = HeightParameters(*heights)
    store(folder).write(wanted)
    assert store(folder).read() == (wanted, "")


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b"[]",
        b'{"Min": 15, "Des": 35}',
        b'{"Min": 15, "Des": 35, "Max": 60, "Mean": 1}',
        b'{"Min": "15", "Des": 35, "Max": 60}',
        b'{"Min": 15, "Des": NaN, "Max": 60}',
        b'{"Min": 40, "Des": 35, "Max": 60}',
        b'{"Min": 15, "Des": 35, "Max": 99}',
    ],
)
def test_a_file_that_cannot_be_used_is_kept_aside(tmp_path: Path, content: bytes) -> None:
    path = put(tmp_path, content)
    heights, problem = store(tmp_path).read()
    assert heights == DEFAULTS
    assert problem
    assert not path.exists()
    assert path.with_name("params.json.bad").read_bytes() == content


def test_a_write_that_fails_leaves_the_old_file_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = store(tmp_path)
    kept.write(HeightParameters(10, 20, 30))

    def fail(_: int) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(ParameterError, match="disk full"):
        kept.write(HeightParameters(11, 21, 31))
    assert kept.read() == (HeightParameters(10, 20, 30), "")


# -- the Configure state ----------------------------------------------------------------------------------------------


async def configured(rig: Rig) -> None:
    while rig.state is StateName.CONFIGURE:
        await rig.manager.requests.finish()
        await rig.tick()


async def test_configure_stores_sets_the_return_height_and_reads_it_back(rig: Rig, tmp_path: Path) -> None:
    rig.order(Configure(min=12, des=25, max=48))
    rig.expect(StateName.CONFIGURE)
    await configured(rig)
    rig.expect(StateName.IDLE)
    assert json.loads((tmp_path / "params.json").read_text()) == {"Min": 12, "Des": 25, "Max": 48}
    assert rig.autopilot.asked("set_rtl_altitude") == [48]
    assert rig.topics.get_heights() == HeightParameters(12, 25, 48)
    assert rig.log[-1] == "Flies at 25 m, never below 12 m or above 48 m."


@pytest.mark.parametrize(("heights", "field"), [((20, 10, 30), "Des"), ((10, 20, 15), "Max"), ((10, 20, 97.1), "Max")])
async def test_bad_heights_are_refused_and_nothing_changes(
    rig: Rig, heights: tuple[float, float, float], field: str
) -> None:
    low, travel, high = heights
    answer = rig.command(Configure(min=low, des=travel, max=high))
    assert not answer.accepted
    assert answer.reason.startswith(f"{field}: ")
    rig.expect(StateName.IDLE)
    assert rig.topics.get_heights() == DEFAULTS


async def test_a_return_height_that_is_refused_is_reported_in_the_autopilots_words(rig: Rig) -> None:
    rig.autopilot.refuse["set_rtl_altitude"] = "parameter is locked"
    rig.order(Configure(min=12, des=25, max=48))
    await configured(rig)
    rig.expect(StateName.IDLE)
    entry = rig.manager.log.entries[-1]
    assert entry.level == "error"
    assert entry.details == "parameter is locked"


@pytest.mark.nightly
async def test_a_silent_autopilot_does_not_keep_it_in_configure(rig: Rig) -> None:
    rig.autopilot.silent.add("set_rtl_altitude")
    rig.order(Configure(min=12, des=25, max=48))
    await rig.manager.requests.finish()
    await rig.run(41)
    rig.expect(StateName.IDLE)
    assert "too long" in rig.log[-1]


async def test_heights_that_cannot_be_stored_are_not_flown(rig: Rig, tmp_path: Path) -> None:
    (tmp_path / "params.json").mkdir()
    rig.order(Configure(min=12, des=25, max=48))
    await configured(rig)
    assert rig.topics.get_heights() == DEFAULTS
    assert rig.log[-1] == "The heights were not saved."
    assert rig.command(Arm()).accepted


def test_the_ceiling_of_a_configured_fence_bounds_what_can_be_configured() -> None:
    assert DdcSettings(fence=FenceSettings(ceiling_margin_m=3)).ceiling == 97
