"""Travel heights, kept over restarts in one small file."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.formats.validation import first_wrong
from hawk.model.plans import HeightParameters
from hawk.model.sentences import say, words_of
from hawk.runtime.files import set_aside, write_atomically

PARAMETER_FILE = "params.json"


class ParameterError(ValueError):
    """A file that cannot be written; the text names it and the fault."""


class _StoredHeights(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
    minimum: float = Field(alias="Min", gt=0)
    desired: float = Field(alias="Des", gt=0)
    maximum: float = Field(alias="Max", gt=0)


def heights_problem(heights: HeightParameters, ceiling: float, floor: float = 0.0) -> str:
    """Return why it is not 0 < Min, floor <= Min <= Des <= Max <= ceiling (metres above the arm place); else empty."""
    low, travel, high = heights.minimum, heights.desired, heights.maximum
    if not low > 0:
        return say("Min: must be above 0 m, not {minimum:g} m.", minimum=low)
    if low < floor:
        return say(
            "Min: {minimum:g} m is too low over the highest obstacle: raise Min to {floor:g} m.",
            minimum=low,
            floor=floor,
        )
    if not travel >= low:
        return say(
            "Des: {desired:g} m is below Min, {minimum:g} m: raise Des or lower Min.", desired=travel, minimum=low
        )
    if not high >= travel:
        return say(
            "Max: {maximum:g} m is below Des, {desired:g} m: raise Max or lower Des.", maximum=high, desired=travel
        )
    if not high <= ceiling:
        return say("Max: {maximum:g} m is above the ceiling, {ceiling:g} m: lower Max.", maximum=high, ceiling=ceiling)
    return ""


class ParameterStore:
    """Reads and writes the parameter file. A write is atomic: a crash leaves the old file or the new one, whole."""

    def __init__(self, directory: Path, defaults: HeightParameters, ceiling: float, floor: float = 0.0) -> None:
        """``floor`` and ``ceiling``: limits of stored heights, metres above the arm place."""
        self._path = directory / PARAMETER_FILE
        self._defaults = defaults
        self._ceiling = ceiling
        self._floor = floor

    def read(self) -> tuple[HeightParameters, str]:
        """Return the stored heights, else the defaults, with a message when the file had to be renamed.

        A file that cannot be used is renamed to ``params.json.bad`` so that nothing is lost.
        """
        try:
            text = self._path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return self._defaults, ""
        except (OSError, UnicodeDecodeError) as error:
            return self._defaults, self._set_aside(words_of(error))
        try:
            stored = _StoredHeights.model_validate_json(text)
        except ValidationError as error:
            return self._defaults, self._set_aside(first_wrong(error, _StoredHeights))
        heights = HeightParameters(stored.minimum, stored.desired, stored.maximum)
        problem = heights_problem(heights, self._ceiling, self._floor)
        return (self._defaults, self._set_aside(problem)) if problem else (heights, "")

    def write(self, heights: HeightParameters) -> None:
        """Store the heights durably. Blocks on the disk: call it off the loop. Raises ParameterError."""
        content: dict[str, Any] = {"Min": heights.minimum, "Des": heights.desired, "Max": heights.maximum}
        try:
            write_atomically(self._path, json.dumps(content))
        except OSError as error:
            raise ParameterError(
                say("The heights could not be stored in {path}: {error}", path=str(self._path), error=words_of(error))
            ) from error

    def _set_aside(self, reason: str) -> str:
        with suppress(OSError):
            set_aside(self._path, "bad")
        return say("The stored heights cannot be used, the configured ones are used: {reason}", reason=reason)
