"""Travel heights, kept over restarts in one small file."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hawk.model.plans import HeightParameters
from hawk.model.sentences import say, words_of
from hawk.runtime.files import set_aside, write_atomically

PARAMETER_FILE = "params.json"


class ParameterError(ValueError):
    """Heights that cannot be used, or a file that cannot be written; the text names the field and the remedy."""


class _StoredHeights(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
    minimum: float = Field(alias="Min", gt=0)
    desired: float = Field(alias="Des", gt=0)
    maximum: float = Field(alias="Max", gt=0)


def check_heights(heights: HeightParameters, ceiling: float, floor: float = 0.0) -> None:
    """Check 0 < Min, floor <= Min <= Des <= Max <= ceiling (metres above the arm place). Raises ParameterError."""
    if not heights.minimum > 0:
        raise ParameterError(say("Min: must be above 0 m, not {minimum:g} m.", minimum=heights.minimum))
    if heights.minimum < floor:
        raise ParameterError(
            say(
                "Min: {minimum:g} m is too low over the highest obstacle: raise Min to {floor:g} m.",
                minimum=heights.minimum,
                floor=floor,
            )
        )
    if not heights.desired >= heights.minimum:
        raise ParameterError(
            say(
                "Des: {desired:g} m is below Min, {minimum:g} m: raise Des or lower Min.",
                desired=heights.desired,
                minimum=heights.minimum,
            )
        )
    if not heights.maximum >= heights.desired:
        raise ParameterError(
            say(
                "Max: {maximum:g} m is below Des, {desired:g} m: raise Max or lower Des.",
                maximum=heights.maximum,
                desired=heights.desired,
            )
        )
    if not heights.maximum <= ceiling:
        raise ParameterError(
            say(
                "Max: {maximum:g} m is above the ceiling, {ceiling:g} m: lower Max.",
                maximum=heights.maximum,
                ceiling=ceiling,
            )
        )


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
            heights = HeightParameters(stored.minimum, stored.desired, stored.maximum)
            check_heights(heights, self._ceiling, self._floor)
        except ValidationError as error:
            problem = error.errors(include_url=False)[0]
            return self._defaults, self._set_aside(f"{'.'.join(map(str, problem['loc']))}: {problem['msg']}")
        except ParameterError as error:
            return self._defaults, self._set_aside(words_of(error))
        return heights, ""

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
