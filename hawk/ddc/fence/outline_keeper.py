"""Keeps the outline of the survey: the one that an operator set in this survey, else the settings' file, else none."""

from __future__ import annotations

from pathlib import Path

from hawk.comm.protocol.heartbeat import OutlineSetup
from hawk.ddc.fence.outline import OutlineError, OutlineFacts, area_words, check_rings, corners_of, ground_of
from hawk.ddc.fence.outline_geojson import read_survey_outline
from hawk.ddc.survey_memory import SurveyMemory
from hawk.model.limits import AskedGround, Fence, Outline
from hawk.model.operation import Level
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of


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

    def ground(self, datum: GlobalPose | None, fence: Fence | None) -> AskedGround | None:
        """Return the part inside a fence on the map of a datum; None without an outline, or before there are both."""
        outline = self.outline
        return None if outline is None or datum is None or fence is None else ground_of(outline, datum, fence)

    def facts(self, datum: GlobalPose | None, fence: Fence | None) -> OutlineFacts | None:
        """Return the sizes of `ground`; of the whole outline before there are a datum and a fence."""
        if self.outline is None:
            return None
        ground = self.ground(datum, fence)
        return OutlineFacts(self.setup.area, 0.0) if ground is None else OutlineFacts(ground.area, ground.outside)

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
    )
