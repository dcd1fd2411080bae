"""The settings of this room, from the sections of the configuration, and everything outside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hawk.comm.cameras.calibration import load_calibration
from hawk.comm.protocol.authority import OperatorDesk
from hawk.config import sections
from hawk.model.moment import Moment, this_moment
from hawk.model.operation import Fall, FlightDrain, FlightSoFar, SurveyLeft
from hawk.model.plans import Outline


def _forget(_: object) -> None:
    """Keep nothing."""


@dataclass(frozen=True, slots=True)
class SurveyMemory:
    """Results of earlier flights, and where this one leaves its own: see `FlightJournal.set_left` and the like."""

    left: SurveyLeft | None = None
    drains: tuple[FlightDrain, ...] = ()
    keep_left: Callable[[SurveyLeft], None] = field(default=_forget)
    keep_drains: Callable[[tuple[FlightDrain, ...]], None] = field(default=_forget)
    outline: Outline | None = None
    """As an operator left it in this survey: without polygons when it was cleared, None when it was never set."""
    keep_outline: Callable[[Outline], None] = field(default=_forget)


@dataclass(frozen=True, slots=True)
class DdcSettings:
    """Settings of operations manager and states. ``system_id`` is our MAVLink id, which the autopilot must watch."""

    flight: sections.FlightSettings = field(default_factory=sections.FlightSettings)
    fence: sections.FenceSettings = field(default_factory=sections.FenceSettings)
    operator: sections.OperatorSettings = field(default_factory=sections.OperatorSettings)
    heights: sections.HeightSettings = field(default_factory=sections.HeightSettings)
    system_id: int = 245
    set_rtl_altitude: bool = True
    remote_control: sections.RemoteControlSettings = field(default_factory=sections.RemoteControlSettings)
    remote_id: sections.RemoteIdSettings = field(default_factory=sections.RemoteIdSettings)
    view: float = 2 * math.tan(math.radians(sections.CameraSettings().horizontal_fov_deg) / 2)
    """Width of the camera's picture on the ground, metres from a height of one metre."""

    @classmethod
    def from_config(cls, config: sections.Config) -> DdcSettings:
        """Take what concerns this room out of the whole configuration. Raises ConfigError for a bad calibration."""
        return cls(
            flight=config.flight,
            fence=config.fence,
            operator=config.operator,
            heights=config.heights,
            system_id=config.autopilot.system_id,
            set_rtl_altitude=config.autopilot.set_rtl_altitude,
            remote_control=config.remote_control,
            remote_id=config.remote_id,
            view=_view(config.camera),
        )

    @property
    def floor(self) -> float:
        """Lowest height of travel over the declared obstacle, metres above the arm place."""
        return self.heights.floor_m

    @property
    def ceiling(self) -> float:
        """Our own ceiling: it lies below the autopilot's by the margin, metres above the arm place."""
        return self.heights.ceiling_m - self.fence.ceiling_margin_m


def _view(camera: sections.CameraSettings) -> float:
    model = load_calibration(camera).for_size(1280, 720)  # the ratio is that of every size
    return model.width / model.fx


@dataclass(frozen=True, slots=True)
class ManagerSetup:
    """Everything outside the operations manager, passed in by the composition root."""

    clock: Callable[[], float]
    desk: OperatorDesk
    directory: Path
    """Folder of the parameter file and the fence file."""
    settings: DdcSettings = field(default_factory=DdcSettings)
    utc: Callable[[], datetime] = field(default=lambda: datetime.now(UTC))
    record: Callable[[str, dict[str, Any]], None] = field(default=lambda _kind, _payload: None)
    """Receives every tick's facts, every command, answer, request and decision."""
    wants_memory: Callable[[], bool] = field(default=lambda: False)
    """True while the recording cannot be entered: the decider's memory is recorded with the next tick."""
    count_start: Callable[[], int] = field(default=lambda: 1)
    """Journals a start in the air; returns the number of starts in the last 60 s, this one included."""
    new_token: Callable[[], str] | None = None
    continues_survey: bool = False
    """The map of an earlier run was restored."""
    begin_survey: Callable[[], None] = field(default=lambda: None)
    """Begins another survey: an empty map and a journal of its own."""
    moment: Callable[[], Moment] = this_moment
    """This computer's boot and the time since."""
    flight: FlightSoFar | None = None
    """The flight in which an earlier run ended."""
    keep_flight: Callable[[FlightSoFar | None], None] = field(default=lambda _flight: None)
    """Journals the flight under way; None after it."""
    fall: Fall | None = None
    """Motors that went off in the air in an earlier run, and nobody cleared it."""
    keep_fall: Callable[[Fall | None], None] = field(default=lambda _fall: None)
    """Journals that the motors went off in the air; None once it is cleared."""
    survey: SurveyMemory = field(default_factory=SurveyMemory)
    """Rest of the survey and drain of the battery, as earlier flights left them."""
    speed: float = 1.0
    """Seconds of ``clock`` per real second."""
