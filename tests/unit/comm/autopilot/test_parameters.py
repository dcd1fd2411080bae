from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from hawk.comm.autopilot.parameters import TRIES, AutopilotParameters
from hawk.comm.autopilot.vehicle import AutopilotError
from tests.unit.comm.fakes import Memory

INT8, INT16, UINT8, REAL = 2, 4, 1, 9


class Rig:
    def __init__(self, answer_s: float = 0.01, **values: tuple[float, int]) -> None:
        self.memory = Memory(values)
        self.parameters = AutopilotParameters(self.send, answer_s)

    async def send(self, name: str, fields: Mapping[str, Any]) -> None:
        answer = self.memory.answer(name, fields)
        if answer is not None:
            asyncio.get_running_loop().call_soon(self.parameters.take, answer)


@pytest.fixture
def rig() -> Rig:
    return Rig(FS_GCS_ENABLE=(0, INT8), RTL_ALT=(1500, INT16), FENCE_ALT_MAX=(100.0, REAL), SMALL=(0.1, REAL))


async def test_a_value_has_the_autopilots_own_type(rig: Rig) -> None:
    assert await rig.parameters.get("RTL_ALT") == 1500
    assert isinstance(rig.parameters.values["RTL_ALT"], int)
    assert isinstance(await rig.parameters.get("FENCE_ALT_MAX"), float)


async def test_an_unknown_name_is_an_error_that_names_it(rig: Rig) -> None:
    with pytest.raises(AutopilotError, match="RTL_ALT_M: the autopilot does not answer"):
        await rig.parameters.get("RTL_ALT_M")
    assert len(rig.memory.asked) == TRIES


@pytest.mark.parametrize("name", ["", "A_NAME_OF_17_CHARS"])
async def test_a_name_that_cannot_be_one_is_not_sent(rig: Rig, name: str) -> None:
    with pytest.raises(AutopilotError, match="1 to 16 characters"):
        await rig.parameters.get(name)
    assert rig.memory.asked == []


@pytest.mark.parametrize(
    ("kind", "lowest", "highest"),
    [
        (UINT8, 0, 255),
        (INT8, -128, 127),
        (3, 0, 65_535),
        (INT16, -32_768, 32_767),
        (5, 0, 4_294_967_295),
        (6, -2_147_483_648, 2_147_483_647),
    ],
)
async def test_whole_numbers_are_set_within_the_range_of_their_type(kind: int, lowest: int, highest: int) -> None:
    rig = Rig(WHOLE=(1, kind))
    for value in (lowest, highest):
        await rig.parameters.set("WHOLE", value)
        assert rig.memory.values["WHOLE"] == (value, kind)
    for value in (lowest - 1, highest + 1):
        with pytest.raises(AutopilotError, match="WHOLE"):
            await rig.parameters.set("WHOLE", value)
    assert rig.memory.values["WHOLE"] == (highest, kind)


async def test_many_are_read_side_by_side_and_absent_ones_are_none(rig: Rig) -> None:
    found = await rig.parameters.read_many(["FS_GCS_ENABLE", "MAV_GCS_SYSID", "RTL_ALT", "RTL_ALT"])
    assert found == {"FS_GCS_ENABLE": 0, "MAV_GCS_SYSID": None, "RTL_ALT": 1500}


async def test_a_lost_datagram_is_asked_for_again(rig: Rig) -> None:
    rig.memory.deaf = TRIES - 1
    assert await rig.parameters.get("RTL_ALT") == 1500


async def test_a_set_is_sent_with_the_type_that_was_read_and_read_back(rig: Rig) -> None:
    await rig.parameters.set("RTL_ALT", 6000)
    assert rig.memory.values["RTL_ALT"] == (6000.0, INT16)
    read, put = ("PARAM_REQUEST_READ", "RTL_ALT"), ("PARAM_SET", "RTL_ALT")
    assert rig.memory.asked == [read, put, read]
    assert rig.parameters.values["RTL_ALT"] == 6000


@pytest.mark.slow
@pytest.mark.fault(
    "a parameter is confirmed and reads as its old value",
    "set and read back until it holds, 3 s at most",
)
@pytest.mark.parametrize("late", [1, 2, 5])
async def test_a_value_that_is_confirmed_and_reads_as_the_old_one_is_set_until_it_holds(late: int) -> None:
    rig = Rig(1.0, FS_GCS_ENABLE=(0, INT8))
    rig.memory.late["FS_GCS_ENABLE"] = late
    await rig.parameters.set("FS_GCS_ENABLE", 1)
    assert rig.parameters.values["FS_GCS_ENABLE"] == 1
    assert rig.memory.late["FS_GCS_ENABLE"] == 0


async def test_a_value_that_never_holds_is_an_error_with_both_values(rig: Rig) -> None:
    rig.memory.late["FS_GCS_ENABLE"] = 10_000
    with pytest.raises(AutopilotError, match="FS_GCS_ENABLE: set to 1, but the autopilot says 0"):
        await rig.parameters.set("FS_GCS_ENABLE", 1)


async def test_a_real_number_comes_back_as_the_autopilots_single_precision(rig: Rig) -> None:
    rig.memory.stubborn.add("SMALL")
    rig.memory.values["SMALL"] = (0.30000001192092896, REAL)
    await rig.parameters.set("SMALL", 0.3)


async def test_a_value_that_is_not_taken_is_an_error_with_both_values(rig: Rig) -> None:
    rig.memory.stubborn.add("FS_GCS_ENABLE")
    with pytest.raises(AutopilotError, match="FS_GCS_ENABLE: set to 1, but the autopilot says 0"):
        await rig.parameters.set("FS_GCS_ENABLE", 1)


async def test_a_set_that_nobody_confirms_is_an_error(rig: Rig) -> None:
    await rig.parameters.get("RTL_ALT")
    rig.memory.deaf = 100
    with pytest.raises(AutopilotError, match="RTL_ALT: the autopilot did not confirm 3000"):
        await rig.parameters.set("RTL_ALT", 3000)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("RTL_ALT", 10.5, "not a whole number"),
        ("RTL_ALT", 40_000, "outside -32768 to 32767"),
        ("FS_GCS_ENABLE", 200, "outside -128 to 127"),
        ("FENCE_ALT_MAX", float("nan"), "not a finite number"),
        ("FENCE_ALT_MAX", float("inf"), "not a finite number"),
    ],
)
async def test_a_value_of_the_wrong_kind_is_never_sent(rig: Rig, name: str, value: float, words: str) -> None:
    with pytest.raises(AutopilotError, match=f"{name}.*{words}"):
        await rig.parameters.set(name, value)
    assert ("PARAM_SET", name) not in rig.memory.asked


async def test_what_another_station_changed_is_known_too(rig: Rig) -> None:
    rig.parameters.take({"param_id": "WPNAV_SPEED", "param_value": 500.0, "param_type": REAL})
    assert rig.parameters.values["WPNAV_SPEED"] == 500.0


async def test_after_a_boot_nothing_is_known(rig: Rig) -> None:
    await rig.parameters.get("RTL_ALT")
    rig.parameters.forget()
    assert dict(rig.parameters.values) == {}
    rig.memory.values["RTL_ALT"] = (1500.0, REAL)
    await rig.parameters.set("RTL_ALT", 10.5)  # the new firmware's type
    assert rig.memory.values["RTL_ALT"] == (10.5, REAL)


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"param_id": "A", "param_value": None, "param_type": 9},
        {"param_id": 5, "param_value": 1.0, "param_type": 9},
        {"param_id": "A", "param_value": float("nan"), "param_type": 9},
    ],
)
async def test_an_answer_that_cannot_be_read_is_none(rig: Rig, fields: dict[str, Any]) -> None:
    rig.parameters.take(fields)
    assert dict(rig.parameters.values) == {}


async def test_the_values_cannot_be_changed_from_outside(rig: Rig) -> None:
    await rig.parameters.get("RTL_ALT")
    with pytest.raises(TypeError):
        rig.parameters.values["RTL_ALT"] = 1  # type: ignore[index]
