"""Features of a file with a plan, by their properties outlines of stalls, or sections."""

from __future__ import annotations

from typing import Final

from hawk.lots.plan_files.facts import kind_of, label_of
from hawk.lots.plan_files.section_facts import Roads, area_facts, is_area, line_facts
from hawk.lots.plan_files.values import Asked, Drawing, Drawn, DrawnSection, Facts, Floats, Notes

STALL: Final = "parking_space"
"""OpenStreetMap's ``amenity`` of a stall."""


class FeatureReader:
    """Collects the features of one file."""

    def __init__(self, asked: Asked, notes: Notes, *, is_of_sections: bool = False) -> None:
        """``is_of_sections``: every polygon is a section."""
        self.drawn: list[Drawn] = []
        self.sections: list[DrawnSection] = []
        self._asked = asked
        self._notes = notes
        self._is_of_sections = is_of_sections
        self._roads = Roads()

    def add(self, name: str, places: Floats, facts: Facts, *, is_line: bool = False, layer: str = "") -> None:
        """Add a feature: ``places`` (N, 2) are x and y of its outer ring or its line.

        ``name``: where it stands in the file, by which it is noted where it is neither stall nor section.
        """
        if is_line:
            said = line_facts(facts, name, self._notes, self._roads)
            self.sections += [DrawnSection(name, places, each) for each in said]
        elif self._is_of_sections or is_area(facts, layer):
            found = area_facts(facts, name, self._notes)
            self.sections += [] if found is None else [DrawnSection(name, places, found)]
        elif (amenity := facts.get("amenity")) not in (None, "", STALL):
            self._notes.add(name, f"amenity: is {str(amenity)[:40]}, no {STALL}")
        else:
            label = label_of(facts, self._asked.label, name, self._notes)
            self.drawn.append(Drawn(name, places, label, kind_of(facts, name, self._notes)))

    def drawing(self, form: str, crs: str, layers: tuple[tuple[str, int], ...] = ()) -> Drawing:
        """Return the drawing of all features; ``form``: the format's name."""
        if self._roads.without_width:
            self._notes.assumed.append(
                f"roads: width: is missing of {self._roads.without_width} sides, whose vehicles are taken to stand 1.5 "
                "or 2.4 m off the middle: compare the preview with the picture, or write the width from kerb to kerb"
            )
        return Drawing(form, tuple(self.drawn), crs=crs, layers=layers, sections=tuple(self.sections))
