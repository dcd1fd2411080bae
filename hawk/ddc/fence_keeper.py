"""Which fence counts: the one that an operator drew, else the configured file's, else a circle around the arm place."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from hawk.comm.fence_messages import FenceCorner, FenceSetup
from hawk.comm.topic import Topic
from hawk.ddc.fence_file import read_geojson
from hawk.ddc.fence_plan import FencePlan, check_plan
from hawk.ddc.fence_store import FenceStore
from hawk.ddc.flight_log import Level
from hawk.ddc.geofence import FenceError, Ring, circle, polygon_fence, to_map
from hawk.ddc.settings import DdcSettings
from hawk.model import Fence, GlobalPose, HeightParameters


class FenceKeeper:
    """Keeps the plan, which Arm lays on the map, and the fence in force.

    The drawn or configured polygon or circle is the autopilot's, the outermost; ours lies inside it by the margin.
    Raises FenceError at construction when the configured file cannot be used. A drawn fence that cannot be read again
    is a `problem`: it keeps the drone on the ground, because nobody knows what it would have forbidden.
    """

    def __init__(self, settings: DdcSettings, topic: Topic[Fence], directory: Path) -> None:
        self._settings = settings
        self._topic = topic
        self._store = FenceStore(directory, settings.heights.ceiling_m)
        self._standard = _standard(settings)
        self.plan = self._standard
        self.problem = ""
        """Why the drawn fence cannot be used; empty when it can, or when there is none."""
        self._read()
        self.setup = self._setup()
        """What operators are told; another object after each change."""

    @property
    def active(self) -> Fence | None:
        """The fence in force, None before the first arm."""
        return self._topic.value

    @property
    def ceiling(self) -> float:
        """Our own ceiling of the planned fence, metres above the arm place."""
        return self.plan.ceiling - self._settings.fence.ceiling_margin_m

    @property
    def is_drawn(self) -> bool:
        """Whether an operator drew one that is still kept, usable or not."""
        return self.plan.source == "drawn" or self.problem != ""

    def build(self, datum: GlobalPose, latitude: float, longitude: float) -> Fence:
        """Return the planned fence for a drone that is armed at this place (degrees). Raises FenceError."""
        settings = self._settings.fence
        if self.plan.ring:
            return self.plan.on_map(datum, settings)
        outer = circle(to_map(datum, latitude, longitude), settings.radius_m)
        return polygon_fence(outer, settings.margin_m, self.plan.ceiling, settings.ceiling_margin_m)

    def tell_source(self, tell: Callable[[Level, str, str], object]) -> None:
        """Tell the operator at the start what may surprise: a drawn fence that cannot be used, or outranks the file."""
        if self.problem:
            tell("warning", "The fence that was drawn cannot be used.", self.problem)
        elif self.plan.source == "drawn" and self._standard.source == "file":
            tell("info", "The drawn fence counts, not the settings' file.", f"{self._settings.fence.file}")

    def put_in_force(self, fence: Fence) -> None:
        """This fence holds from here on."""
        self._topic.publish(fence)

    def store(self, plan: FencePlan | None) -> None:
        """Write the file for a drawn fence (None: put it aside). Blocks on the disk. Raises FenceError."""
        if plan is None:
            self._store.put_aside()
        else:
            self._store.write(plan)

    def use(self, plan: FencePlan | None) -> None:
        """Plan with this fence from the next Arm on; None: with the configured one."""
        self.plan = plan or self._standard
        self.problem = ""
        self.setup = self._setup()

    def _read(self) -> None:
        try:
            self.plan = self._store.read() or self._standard
            if self.plan.source == "drawn":
                check_plan(self.plan, self._settings, HeightParameters(0.0, 0.0, 0.0))
        except FenceError as error:
            self.plan = self._standard
            self.problem = f"The drawn fence cannot be used: {error}"

    def _setup(self) -> FenceSetup:
        settings = self._settings.fence
        inner: Ring = ()
        if self.plan.ring:
            with suppress(FenceError):  # a configured file that is too narrow: the check before flight says so
                inner = check_plan(self.plan, self._settings, HeightParameters(0.0, 0.0, 0.0)).inner
        return FenceSetup(
            source=self.plan.source,
            corners=corners(self.plan.ring),
            inner=corners(inner),
            radius=settings.radius_m if self.plan.source == "circle" else None,
            ceiling=self.plan.ceiling,
            margin=settings.margin_m,
            ceiling_margin=settings.ceiling_margin_m,
            highest_ceiling=self._settings.heights.ceiling_m,
            problem=self.problem,
        )


def corners(ring: Ring) -> list[FenceCorner]:
    """Return (latitude, longitude) corners as the messages have them."""
    return [FenceCorner(latitude=latitude, longitude=longitude) for latitude, longitude in ring]


def _standard(settings: DdcSettings) -> FencePlan:
    if settings.fence.file is None:
        return FencePlan("circle", (), settings.heights.ceiling_m)
    return FencePlan("file", read_geojson(settings.fence.file), settings.heights.ceiling_m)
