"""Words in pictures keep their accents, in any language."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.results.letters import width_of, write


def drawn(text: str, **how: object) -> NDArray[np.uint8]:
    picture = np.full((60, 400, 3), 250, np.uint8)
    write(picture, text, (200, 30), 20, (0, 0, 0), **how)  # type: ignore[arg-type]
    return picture


@pytest.mark.parametrize(("text", "plain"), [("Müller", "Muller"), ("Łódź", "Lodz"), ("Élan", "Elan"), ("Ø", "O")])
def test_an_accent_is_drawn_and_is_no_question_mark(text: str, plain: str) -> None:
    assert (drawn(text) != drawn(plain)).any()
    marks = "".join("?" if one != other else one for one, other in zip(text, plain, strict=True))
    assert (drawn(text) != drawn(marks)).any()


@pytest.mark.parametrize("text", ["Улица", "Οδός", "駐車場"])
def test_each_letter_of_other_languages_is_one_of_its_own(text: str) -> None:
    assert len({drawn(each).tobytes() for each in (*set(text), "?", "\uffff")}) >= len(set(text)) + 1


def test_a_line_stands_at_its_anchor_and_is_not_wrapped() -> None:
    for anchor, left, right in (("left", 200, 200 + width_of("Hall", 20)), ("right", 200 - width_of("Hall", 20), 200)):
        columns = np.flatnonzero((drawn("Hall", anchor=anchor) != 250).any(axis=(0, 2)))
        assert columns.min() >= left - 1
        assert columns.max() <= right + 1
    middle = np.flatnonzero((drawn("HOH", anchor="middle") != 250).any(axis=(0, 2)))
    assert middle.mean() == pytest.approx(200, abs=1.5)
    assert (drawn("long words " * 20)[36:] == 250).all()


def test_a_halo_is_around_the_letters() -> None:
    with_halo = drawn("Hall", halo=(0, 0, 255))
    red = (with_halo == (0, 0, 255)).all(axis=2)
    assert red.sum() > (drawn("Hall") != 250).any(axis=2).sum() / 2
    assert (with_halo == 0).all(axis=2).any()
