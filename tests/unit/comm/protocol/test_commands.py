from __future__ import annotations

import json
import re
from typing import Any

import pytest

from hawk.comm.protocol.commands import Ack, BadMessageError, CheckFence, Hold, SetFence, SetOutline, parse_command


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('{"Type": "Fly", "Id": 7}', 7),
        ('{"Type": "Fly", "Id": "ü\\n"}', "ü\n"),
        ('{"Type": "Fly", "Id": true}', None),
        ('{"Type": "Fly", "Id": [1]}', None),
        ('{"Type": "Hold", "Id": "\\ud800"}', None),
        ('{"Type": "Hold", "Id": ' + "9" * 5000 + "}", None),
        ("{", None),
        ("[" * 5000, None),
    ],
)
def test_a_refusal_carries_the_id_if_it_can_be_sent_back(text: str, found: str | int | None) -> None:
    with pytest.raises(BadMessageError) as refused:
        parse_command(text)
    assert refused.value.message_id == found
    assert '"Accepted":false' in Ack(id=refused.value.message_id, accepted=False, reason=str(refused.value)).to_json()


def test_a_whole_pair_is_a_good_id() -> None:
    assert parse_command('{"Type": "Hold", "Id": "\\ud83d\\ude80"}') == Hold(id="\U0001f680")


CORNERS = [{"Latitude": 43.0 + k * 1e-3, "Longitude": -79.0 + k * k * 1e-3} for k in range(71)]


def fence(kind: str = "Set Fence", **changes: Any) -> str:
    return json.dumps({"Type": kind, "Corners": CORNERS[:4], "Ceiling": 80, **changes})


@pytest.mark.parametrize("count", [3, 69])
def test_a_fence_has_3_to_69_corners(count: int) -> None:
    taken = parse_command(fence(Corners=CORNERS[:count]))
    assert isinstance(taken, SetFence)
    assert len(taken.corners) == count
    assert isinstance(parse_command(fence("Check Fence")), CheckFence)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"Corners": CORNERS[:2]}, "Corners: a fence has 3 to 69 corners, this one has 2: add some"),
        ({"Corners": CORNERS}, "Corners: a fence has 3 to 69 corners, this one has 71"),
        ({"Corners": []}, "Corners: "),
        ({"Corners": None}, "Corners: "),
        ({"Corners": "all around"}, "Corners: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": 91, "Longitude": 0}]}, "Corners.3.Latitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": 9, "Longitude": -181}]}, "Corners.3.Longitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": float("nan"), "Longitude": 0}]}, "Corners.3.Latitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": float("inf"), "Longitude": 0}]}, "Corners.3.Latitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": "9", "Longitude": 0}]}, "Corners.3.Latitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": 9}]}, "Corners.3.Longitude: "),
        ({"Corners": [*CORNERS[:3], {"Latitude": 9, "Longitude": 0, "Height": 3}]}, "Corners.3.Height: "),
        ({"Ceiling": 0}, "Ceiling: "),
        ({"Ceiling": 1001}, "Ceiling: "),
        ({"Ceiling": float("nan")}, "Ceiling: "),
        ({"Ceiling": None}, "Ceiling: "),
        ({"Radius": 9}, "Radius: "),
    ],
)
@pytest.mark.parametrize("kind", ["Set Fence", "Check Fence"])
def test_a_bad_fence_is_refused_by_the_field(kind: str, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(BadMessageError) as refused:
        parse_command(fence(kind, **changes))
    assert str(refused.value).startswith(words)


TRIANGLE = CORNERS[:3]


@pytest.mark.parametrize("kind", ["Set Fence", "Check Fence"])
def test_a_fence_may_have_zones(kind: str) -> None:
    taken = parse_command(fence(kind, Corners=CORNERS[:30], Zones=[TRIANGLE] * 12))
    assert isinstance(taken, SetFence | CheckFence)
    assert [len(zone) for zone in taken.zones] == [3] * 12
    without = parse_command(fence(kind))
    assert isinstance(without, SetFence | CheckFence)
    assert without.zones == []


@pytest.mark.fault("a fence that fills the autopilot's memory, which ends ArduCopter's program")
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"Zones": [TRIANGLE] * 13}, "Zones: a fence has at most 12 zones, this one has 13: draw one around"),
        ({"Corners": CORNERS[:31], "Zones": [TRIANGLE] * 12}, "Zones: a fence and its zones have at most 66 corners"),
        ({"Corners": CORNERS[:64], "Zones": [TRIANGLE]}, "Zones: a fence and its zones have at most 66 corners"),
        ({"Zones": [TRIANGLE, TRIANGLE[:2]]}, "Zones: zone 2 has 2 corners: add some, 3 at least"),
        ({"Zones": [[*TRIANGLE, {"Latitude": 91, "Longitude": 0}]]}, "Zones.0.3.Latitude: "),
        ({"Zones": None}, "Zones: "),
        ({"Zones": TRIANGLE}, "Zones.0: "),
        ({"Zones": [[1, 2, 3]]}, "Zones.0.0: "),
    ],
)
@pytest.mark.parametrize("kind", ["Set Fence", "Check Fence"])
def test_bad_zones_are_refused_by_the_field(kind: str, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(BadMessageError) as refused:
        parse_command(fence(kind, **changes))
    assert str(refused.value).startswith(words)


def test_the_largest_fence_fits_into_a_message() -> None:
    corners = [{"Latitude": -43.123456789012345, "Longitude": -179.12345678901234}] * 69
    assert isinstance(parse_command(fence(Corners=corners)), SetFence)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"Type": "Hold", "id": 4}', "id: is no key of a Hold; leave it out"),
        ('{"Type": "Compulsive Move", "x": 1, "Y": 2}', "X: missing; send it with a Compulsive Move"),
        ('{"Type": "Compulsive Move", "X": 1}', "Y: missing; send it with a Compulsive Move"),
        ('{"Type": "Fly"}', "Type: 'Fly' is no command; send a Type of /api/schema.json"),
        ('{"Type": "Hold", "Id": "' + "x" * 65 + '"}', "Id: is neither a text of 64 characters at most"),
        ('{"Type": "Hold", "Id": 1.5}', "Id: is neither a text of 64 characters at most"),
        ('{"Type": ["' + "x" * 9000 + '"]}', "Type: ['xxx"),
        ('{"Type": "Hold", "' + "x" * 9000 + '": 1}', "xxx"),
    ],
)
def test_a_refusal_names_the_key_and_what_to_do(text: str, words: str) -> None:
    with pytest.raises(BadMessageError) as refused:
        parse_command(text)
    assert str(refused.value).startswith(words)
    assert len(str(refused.value)) < 200


def outline(polygons: Any, **more: Any) -> str:
    return json.dumps({"Type": "Set Outline", "Polygons": polygons, **more})


def ring(count: int) -> list[dict[str, float]]:
    return [{"Latitude": 43.0 + number * 1e-4, "Longitude": -79.0} for number in range(count)]


def test_an_outline_has_polygons_and_may_have_holes() -> None:
    taken = parse_command(outline([ring(3), ring(69)], Holes=[ring(4)]))
    assert isinstance(taken, SetOutline)
    assert [len(each) for each in (*taken.polygons, *taken.holes)] == [3, 69, 4]
    assert len(outline([ring(50)] * 4).encode()) < 16 * 1024  # as many corners as there may be


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (outline([]), "Polygons: "),
        (outline([ring(2)]), "Polygons: polygon 1 has 2 corners: draw 3 to 69"),
        (outline([ring(3), ring(70)]), "Polygons: polygon 2 has 70 corners: draw 3 to 69"),
        (outline([ring(3)], Holes=[ring(1)]), "Holes: hole 1 has 1 corners: draw 3 to 69"),
        (outline([ring(3)] * 13), "an outline has at most 12 polygons, this one has 13"),
        (outline([ring(50)] * 5), "an outline has at most 200 corners, this one has 250"),
        (outline([[{"Latitude": 91, "Longitude": 0}] * 3]), "Polygons.0.0.Latitude: "),
        ('{"Type": "Set Outline", "Polygons": [[{"Latitude": NaN, "Longitude": 0}]]}', "Polygons"),
        ('{"Type": "Set Outline"}', "Polygons: missing"),
    ],
)
def test_an_outline_that_is_none_is_refused_with_its_field(text: str, fault: str) -> None:
    with pytest.raises(BadMessageError, match=re.escape(fault)):
        parse_command(text)
