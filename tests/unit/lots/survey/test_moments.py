from __future__ import annotations

import pytest

from hawk.lots.survey.moments import AHEAD_S, CaptureTime, MomentSource

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
    assert CaptureTime.said(NOW - 60.0, source, NOW).is_sure is is_sure
    assert CaptureTime.said(NOW + AHEAD_S, source, NOW).is_sure is is_sure
    assert not CaptureTime.said(NOW + AHEAD_S + 1.0, source, NOW).is_sure
    assert not CaptureTime.said(NOW + 86_400.0, source, NOW).is_possible(NOW)


def test_a_clock_without_a_zone_may_be_ahead_by_its_zone() -> None:
    assert CaptureTime.said(NOW + AHEAD_S, MomentSource.GNSS, NOW).is_possible(NOW)
    assert not CaptureTime.said(NOW + AHEAD_S + 1.0, MomentSource.GNSS, NOW).is_possible(NOW)
    for source in MomentSource:
        is_without = source in (MomentSource.CAMERA, MomentSource.TAG)
        assert CaptureTime.said(NOW + 13 * 3600.0, source, NOW).is_possible(NOW) is is_without
