"""The sun over the drone: from the autopilot's UTC, where that can be believed."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest

from hawk.model.poses import VehiclePose
from hawk.model.sun import SunPosition, sun_position
from tests.unit.comm.autopilot.telemetry_rig import Rig
from tests.unit.comm.fakes import LATITUDE, LONGITUDE

NOON = datetime(2027, 6, 1, 11, 30, tzinfo=UTC)


@pytest.fixture
def rig() -> Rig:
    """A drone that is armed and stands still."""
    rig = Rig()
    rig.arm_here()
    return rig


def heard(rig: Rig, utc: datetime | float) -> None:
    rig.take(rig.said.system_time(utc if isinstance(utc, float) else utc.timestamp()))


def sun(rig: Rig, later: float = 0.0) -> SunPosition | None:
    pose = rig.telemetry.pose_at(rig.clock())
    assert isinstance(pose, VehiclePose)
    return rig.telemetry.sun_at(rig.clock() + later, pose)


def test_it_stands_where_time_and_place_put_it(rig: Rig) -> None:
    heard(rig, NOON)
    found, true = sun(rig), sun_position(NOON, LATITUDE, LONGITUDE)
    assert found is not None
    assert found.azimuth == pytest.approx(true.azimuth, abs=0.01)
    assert found.elevation == pytest.approx(true.elevation, abs=0.01)


def test_it_moves_on_between_messages_and_is_that_of_the_picture_s_moment(rig: Rig) -> None:
    heard(rig, NOON)
    rig.fly(1.0)
    found, true = sun(rig, later=3599.0), sun_position(NOON + timedelta(hours=1), LATITUDE, LONGITUDE)
    assert found is not None
    assert found.azimuth == pytest.approx(true.azimuth, abs=0.01)


@pytest.mark.parametrize(
    "utc",
    [
        pytest.param(0.0, id="the autopilot has no time"),
        pytest.param(3600.0, id="1970"),
        pytest.param(datetime(2007, 10, 17, tzinfo=UTC), id="1024 weeks back"),
        pytest.param(datetime(2200, 1, 1, tzinfo=UTC), id="far ahead"),
    ],
)
def test_a_time_that_cannot_be_is_not_known_also_after_one_that_could(rig: Rig, utc: datetime | float) -> None:
    assert sun(rig) is None
    heard(rig, utc)
    assert sun(rig) is None
    rig.fly(0.5)
    heard(rig, NOON)
    assert sun(rig) is not None
    rig.fly(0.5)
    heard(rig, utc)
    assert sun(rig) is None


def test_the_computer_s_clock_has_no_part_in_it(rig: Rig) -> None:
    heard(rig, NOON)
    before = sun(rig)
    rig.pass_host(86_400.0)
    assert sun(rig) == before


def test_a_boot_of_the_autopilot_takes_its_time_with_it(rig: Rig) -> None:
    heard(rig, NOON)
    pose = rig.telemetry.pose_at(rig.clock())
    assert pose is not None
    rig.said.boot = 0.0
    rig.fly(2.0)
    assert rig.boots == 1
    assert rig.telemetry.sun_at(rig.clock(), pose) is None
