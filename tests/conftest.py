"""What holds for tests of every kind."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# No test is timed: a machine that others share may stop for half a second anywhere.
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")
