"""The settings that this room needs, taken together from the sections of the configuration."""

from __future__ import annotations

from dataclasses import dataclass, field

from hawk.config import Config, FenceSettings, FlightSettings, HeightSettings, OperatorSettings


@dataclass(frozen=True, slots=True)
class DdcSettings:
    """Settings of operations manager and states. ``system_id`` is our MAVLink id, which the autopilot must watch."""

    flight: FlightSettings = field(default_factory=FlightSettings)
    fence: FenceSettings = field(default_factory=FenceSettings)
    operator: OperatorSettings = field(default_factory=OperatorSettings)
    heights: HeightSettings = field(default_factory=HeightSettings)
    system_id: int = 245
    set_rtl_altitude: bool = True

    @classmethod
    def from_config(cls, config: Config) -> DdcSettings:
        """Take what concerns this room out of the whole configuration."""
        return cls(
            flight=config.flight,
            fence=config.fence,
            operator=config.operator,
            heights=config.heights,
            system_id=config.autopilot.system_id,
            set_rtl_altitude=config.autopilot.set_rtl_altitude,
        )

    @property
    def ceiling(self) -> float:
        """Our own ceiling: it lies below the autopilot's by the margin, metres above the arm place."""
        return self.heights.ceiling_m - self.fence.ceiling_margin_m
