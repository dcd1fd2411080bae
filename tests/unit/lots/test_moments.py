from __future__ import annotations

from datetime import UTC, datetime

import pytest

from hawk.lots.moments import AHEAD_S, MomentSource, SurveyMoment, at_landing

NOW = 1_795_000_000.0


@pytest.mark.parametrize(
    ("source", "is_sure"),
    [
        (MomentSource.GNSS, True),
        (MomentSource.EXIF, True),
        (MomentSource.PERSON, True),
        (MomentSource.AUTOPILOT, True),
        (MomentSource.CAMERA, False),
        (MomentSource.TAG, False),
        (MomentSource.FILE, False),
        (MomentSource.COMPUTER, False),
    ],
)
def test_a_moment_is_sure_by_its_source_and_once_it_has_been(source: MomentSource, is_sure: bool) -> None:
    assert SurveyMoment.said(NOW - 60.0, source, NOW).is_sure is is_sure
    assert SurveyMoment.said(NOW + AHEAD_S, source, NOW).is_sure is is_sure
    assert not SurveyMoment.said(NOW + AHEAD_S + 1.0, source, NOW).is_sure
    assert not SurveyMoment.said(NOW + 86_400.0, source, NOW).is_possible(NOW)


def test_a_clock_without_a_zone_may_be_ahead_by_its_zone() -> None:
    for source in MomentSource:
        is_without = source in (MomentSource.CAMERA, MomentSource.TAG)
        assert SurveyMoment.said(NOW + 13 * 3600.0, source, NOW).is_possible(NOW) is is_without


@pytest.mark.parametrize(
    ("heard", "is_kept", "is_sure"),
    [
        (NOW + 2.0, True, True),
        (NOW + 2.0, False, True),
        (NOW + 40 * 365 * 86_400.0, True, False),  # GNSS is in 2062, a time server is not
        (NOW - 1024 * 7 * 86_400.0, True, False),  # a receiver after the roll-over of its weeks
        (NOW + 90 * 86_400.0, False, True),  # a computer without a clock of its own
        (None, True, True),
        (None, False, False),
    ],
)
def test_the_autopilots_time_and_a_clock_that_is_kept_witness_each_other(
    heard: float | None, is_kept: bool, is_sure: bool
) -> None:
    said = None if heard is None else datetime.fromtimestamp(heard, UTC)
    moment = at_landing(said, NOW, is_kept=is_kept)
    assert moment.is_sure is is_sure
    assert at_landing(said, NOW, is_kept=is_kept, is_simulated=True).is_sure is (is_sure if said is None else True)
    assert moment.value == (NOW if heard is None else heard)
