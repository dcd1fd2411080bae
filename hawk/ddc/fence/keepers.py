"""The stored fence, a GeoJSON file that is kept over restarts, and the outline, kept with the survey."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from hawk.comm.protocol.heartbeat import FenceSetup, OutlineSetup
from hawk.ddc.fence.geojson import fence_feature, read_fence, read_survey_outline
from hawk.ddc.fence.geometry import FenceError, area
from hawk.ddc.fence.outline import OutlineError, OutlineFacts, area_words, check_rings, corners_of, ground_of, is_left
from hawk.ddc.fence.plan import FencePlan, check_plan, fence_setup
from hawk.ddc.settings import DdcSettings, SurveyMemory
from hawk.model.operation import Level
from hawk.model.plans import AskedGround, Fence, HeightParameters, Outline
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of
from hawk.runtime.files import set_aside, write_atomically

FENCE_FILE = "fence.geojson"


class FenceKeeper:
    """Keeps the planned fence: the one that an operator drew, else the configured file's, else a circle.

    A drawn fence that cannot be read again is a `problem`: it keeps the drone on the ground, because nobody knows
    where it would have forbidden to fly.
    """

    def __init__(self, settings: DdcSettings, directory: Path) -> None:
        """Read the files.

        Raises:
            FenceError: The configured file cannot be used.
        """
        self._settings = settings
        self._path = directory / FENCE_FILE
        self._standard = _standard(settings)
        self.plan = self._standard
        self.problem = ""
        """Reason why the drawn fence cannot be used; empty when it can, or when there is none."""
        self._read()
        self.setup: FenceSetup = fence_setup(self.plan, settings, self.problem)
        """The plan as operators see it; another object after each change."""

    @property
    def notice(self) -> tuple[Level, str, str] | None:
        """A message for the start: a drawn fence that cannot be used, or that outranks the configured file."""
        if self.problem:
            return "warning", say("The fence that was drawn cannot be used."), self.problem
        if self.plan.source == "drawn" and self._standard.source == "file":
            return "info", say("The drawn fence is used, not the settings' file."), f"{self._settings.fence.file}"
        return None

    def build(self, datum: GlobalPose, place: GlobalPose) -> Fence:
        """Return the planned fence in the map frame for a drone that is armed at a place.

        Raises:
            FenceError: Nothing whole is left inside the margin.
        """
        return self.plan.around(datum, place, self._settings.fence)

    def planned_area(self, datum: GlobalPose | None, place: GlobalPose) -> float | None:
        """Return the area inside our limit of the planned fence, square metres, for a drone at a place.

        None while it cannot be used. Without a datum the place is the datum.
        """
        if self.problem:
            return None
        try:
            return area(self.build(datum or place, place))
        except FenceError:
            return None

    def store(self, plan: FencePlan | None) -> None:
        """Write a drawn fence to its file; None renames the file. Blocks on the disk: call it off the loop.

        Raises:
            FenceError: The disk refused.
        """
        try:
            if plan is None:
                set_aside(self._path, "former")
            else:
                write_atomically(self._path, fence_feature(plan.ring, plan.zones, plan.ceiling))
        except OSError as error:
            raise FenceError(
                say("The fence could not be stored in {path}: {error}", path=str(self._path), error=str(error))
            ) from error

    def use(self, plan: FencePlan | None) -> None:
        """Plan with this fence from the next Arm on; None: with the configured one."""
        self.plan = plan or self._standard
        self.problem = ""
        self.setup = fence_setup(self.plan, self._settings, "")

    def _read(self) -> None:
        if not self._path.exists():
            return
        highest = self._settings.heights.ceiling_m
        try:
            found = read_fence(self._path)
            ceiling = highest if found.ceiling is None else min(found.ceiling, highest)
            plan = FencePlan("drawn", found.ring, ceiling, found.zones)
            check_plan(plan, self._settings, HeightParameters(0.0, 0.0, 0.0))
        except FenceError as error:
            self.problem = say("The drawn fence cannot be used: {error}", error=words_of(error))
        else:
            self.plan = plan


def _standard(settings: DdcSettings) -> FencePlan:
    if settings.fence.file is None:
        return FencePlan("circle", (), settings.heights.ceiling_m)
    try:
        found = read_fence(settings.fence.file)
    except FenceError as error:
        raise FenceError(say("fence.file: {error}", error=words_of(error))) from error
    return FencePlan("file", found.ring, settings.heights.ceiling_m, found.zones)


class OutlineKeeper:
    """The outline in force, journalled with the survey. An outline without polygons is one that was cleared."""

    def __init__(self, file: Path | None, memory: SurveyMemory) -> None:
        """Take the survey's outline, else read the settings' ``file``.

        Raises:
            OutlineError: The configured file cannot be used.
        """
        self._keep = memory.keep_outline
        self.notice: tuple[Level, str, str] | None = None
        """A message for the start: the outline that goes on, or why the journalled one cannot be used."""
        standard = None if file is None else _configured(file)
        kept = self._kept(memory.outline)
        self._outline = standard if kept is None else kept
        self.setup: OutlineSetup = _setup(self._outline, is_file=kept is None)
        """The outline as operators see it; another object after each change."""

    @property
    def outline(self) -> Outline | None:
        """The outline in force; None without one."""
        return self._outline if self._outline is not None and self._outline.polygons else None

    def use(self, outline: Outline | None) -> None:
        """Survey this outline from the next Explore on, and journal it; None: find the lot by looking."""
        self._outline = outline or Outline()
        self.setup = _setup(self._outline, is_file=False)
        self._keep(self._outline)

    def end_lots(self, lots: Sequence[str]) -> None:
        """Note, and journal, that a round has looked at these lots, by their ids."""
        if self._outline is not None:
            now = tuple(replace(lot, is_over=lot.is_over or lot.id in lots) for lot in self._outline.lots)
            self._outline = replace(self._outline, lots=now)
            self._keep(self._outline)

    def begin_survey(self) -> None:
        """Journal a set outline for another survey. Lots that the last one did not finish are first."""
        before = self.outline
        if before is not None and self.setup.source == "set":
            lots = (replace(lot, is_first=is_left(lot, before.lots), is_over=False) for lot in before.lots)
            self.use(replace(before, lots=tuple(lots)))

    def ground(self, datum: GlobalPose | None, fence: Fence | None) -> AskedGround | None:
        """Return the part inside a fence on the map of a datum; None without an outline, or before there are both."""
        outline = self.outline
        return None if outline is None or datum is None or fence is None else ground_of(outline, datum, fence)

    def facts(self, datum: GlobalPose | None, fence: Fence | None) -> OutlineFacts | None:
        """Return the sizes of `ground`; of the whole outline before there are a datum and a fence."""
        if self.outline is None:
            return None
        ground = self.ground(datum, fence)
        if ground is None:
            return OutlineFacts(self.setup.area, 0.0, self.outline.lots)
        return OutlineFacts(ground.area, ground.outside, self.outline.lots)

    def _kept(self, outline: Outline | None) -> Outline | None:
        """Return the journalled outline if it can be used."""
        if outline is None or not outline.polygons:
            return outline
        try:
            size = area_words(check_rings(outline))
        except (OutlineError, ValueError) as error:
            self.notice = ("warning", say("The outline of the survey cannot be used: set it again."), words_of(error))
            return None
        self.notice = ("info", say("The outline of the survey goes on: {size}.", size=size), "")
        return outline


def _configured(file: Path) -> Outline:
    try:
        return read_survey_outline(file)
    except OutlineError as error:
        raise OutlineError(say("flight.outline_file: {error}", error=words_of(error))) from error


def _setup(outline: Outline | None, *, is_file: bool) -> OutlineSetup:
    if outline is None or not outline.polygons:
        return OutlineSetup(source="none", polygons=[], holes=[], area=0.0)
    return OutlineSetup(
        source="file" if is_file else "set",
        polygons=corners_of(outline.polygons),
        holes=corners_of(outline.holes),
        area=round(check_rings(outline), 1),
        again=tuple(lot.id for lot in outline.lots),
    )
