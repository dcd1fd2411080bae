from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.frame import FrameInput
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import DesiredPose, Fence, HeightParameters
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sun import SunPosition
from hawk.store.frame_codec import FrameFormatError, decode_frame, encode_frame, to_plain, values_of

FRAME = FrameInput(
    sequence=7,
    captured=12.345678901234567,
    jpeg=b"\xff\xd8\x00\n{}\xff\xd9",
    camera=CameraModel(1280, 720, 914.1, 914.2, 640.0, 360.0, (0.1, -0.2), 0.01, 0.02, 0.03),
    pose=MapPose(1.0, 2.0, 35.0, 0.01, -0.02, 3.1),
    speed=3.9,
    state=StateName.AUTONOMOUS_EXPLORE,
    desired=DesiredPose(3, 10.0, -20.0),
    heights=HeightParameters(),
    fence=Fence(((0.0, 1.0), (2.0, 3.0), (4.0, 5.0)), ((0.0, 1.0), (2.0, 3.0), (4.0, 5.0)), 97.0, 100.0),
    home=MapPoint(0.5, -0.5),
    sun=SunPosition(181.25, 33.5),
)
finite = st.floats(allow_nan=False, allow_infinity=False)


def test_a_frame_comes_back_equal() -> None:
    assert decode_frame(encode_frame(FRAME), FrameInput) == FRAME


def test_the_fields_are_read_without_the_picture() -> None:
    values = values_of(encode_frame(FRAME))
    assert values["captured"] == FRAME.captured
    assert values["camera"]["fx"] == FRAME.camera.fx
    assert "jpeg" not in values


@pytest.mark.parametrize(
    ("data", "words"),
    [(b"\x05", "torn"), (b"\x09\0\0\0{}", "torn"), (b"\x02\0\0\0{x", "not JSON"), (b"\x02\0\0\0[]", "no object")],
)
def test_fields_that_cannot_be_read_are_refused(data: bytes, words: str) -> None:
    with pytest.raises(FrameFormatError, match=words):
        values_of(data)


def test_exclusion_zones_come_back_and_a_frame_from_before_them_is_read() -> None:
    assert FRAME.fence is not None
    zones = (((1.0, 1.0), (2.0, 1.0), (1.0, 2.0)), ((3.0, 3.0), (4.0, 3.0), (4.0, 4.0), (3.0, 4.0)))
    zoned = replace(FRAME, fence=replace(FRAME.fence, zones=zones, autopilot_zones=zones[:1]))
    assert decode_frame(encode_frame(zoned), FrameInput) == zoned
    head = json.loads(encode_frame(FRAME)[4:].split(b"\xff\xd8")[0])
    assert head["fence"].pop("zones") == head["fence"].pop("autopilot_zones") == []
    text = json.dumps(head).encode()
    old = len(text).to_bytes(4, "little") + text + FRAME.jpeg
    assert decode_frame(old, FrameInput) == FRAME


def test_a_frame_with_nothing_known_comes_back_equal() -> None:
    bare = replace(FRAME, pose=None, desired=None, fence=None, home=None, jpeg=b"")
    assert decode_frame(encode_frame(bare), FrameInput) == bare


@pytest.mark.slow
@given(finite, finite, finite, st.binary(max_size=200), st.sampled_from(StateName))
def test_no_digit_is_lost(captured: float, north: float, yaw: float, jpeg: bytes, state: StateName) -> None:
    frame = replace(FRAME, captured=captured, pose=MapPose(north, 0.1, 0.2, 0.3, 0.4, yaw), jpeg=jpeg, state=state)
    assert decode_frame(encode_frame(frame), FrameInput) == frame


def test_the_same_frame_makes_the_same_bytes() -> None:
    assert encode_frame(FRAME) == encode_frame(replace(FRAME))


@pytest.mark.parametrize("thing", [object(), {"jpeg": b""}, FrameInput, MapPoint(1.0, 2.0)])
def test_what_is_no_frame_is_refused(thing: object) -> None:
    with pytest.raises(TypeError, match="no dataclass with a jpeg field"):
        encode_frame(thing)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no header"),
        (b"\x01\x02", "no header"),
        (b"\xff\xff\x00\x00{}", "header has 65535 bytes"),
        (b"\x02\x00\x00\x00[]", "no FrameInput"),
        (b"\x03\x00\x00\x00{x}", "no FrameInput"),
        (b"\x02\x00\x00\x00{}", "no FrameInput"),
    ],
)
def test_bytes_that_are_no_frame_say_why(data: bytes, words: str) -> None:
    with pytest.raises(FrameFormatError, match=words):
        decode_frame(data, FrameInput)


@dataclass(frozen=True)
class Mixed:
    place: MapPoint
    data: bytes


def test_whatever_is_recorded_becomes_plain() -> None:
    value = {
        "m": Mixed(MapPoint(1.0, 2.0), b"12345"),
        "n": np.float64(1.5),
        "s": {3, 1, 2},
        "p": Path("x"),
        "e": StateName.LAND,
    }
    assert json.loads(json.dumps(value, default=to_plain)) == {
        "m": {"place": {"north": 1.0, "east": 2.0}, "data": "<5 bytes>"},
        "n": 1.5,
        "s": [1, 2, 3],
        "p": "x",
        "e": "Land",
    }
