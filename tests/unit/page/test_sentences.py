"""The sentences of the program: every code has words in every language of the page."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.unit.docs.scripts import load

sentences = load("sentences")


@pytest.mark.slow
def test_every_sentence_has_words_in_every_language_with_the_same_values() -> None:
    assert sentences.translations().keys() == {"fr"}
    assert sentences.main(["--check"]) == 0


@pytest.mark.parametrize(
    ("translation", "problem"),
    [
        ("", "away: has no words"),
        ("away = loin\n", "away: takes ['by']"),
        ("away = { $by } m\nnear = près\n", "near: no such sentence"),
    ],
)
def test_a_language_that_lacks_a_code_or_a_value_is_found(translation: str, problem: str) -> None:
    texts = sentences.english(iter([sentences.Said("away", "{by:.1f} m away", "a.py:1")]))
    assert texts == {"away": "{ $by } m away"}
    assert sentences.problems(texts, translation) == [problem]
    assert sentences.problems(texts, "away =\n    { $by ->\n        [one] un\n       *[other] { $by }\n    }\n") == []


def test_two_texts_with_one_code_are_found() -> None:
    said = [sentences.Said("away", "away", "a.py:1"), sentences.Said("away", "Away!", "b.py:2")]
    with pytest.raises(ValueError, match=r"b\.py:2: away is another text elsewhere"):
        sentences.english(iter(said))


def test_a_call_with_words_made_elsewhere_is_found(tmp_path: Path) -> None:
    (tmp_path / "hawk").mkdir()
    source = "from hawk.model.sentences import say\nwords = 'x'\nsay(words)\n"
    (tmp_path / "hawk" / "part.py").write_text(source)
    with pytest.raises(ValueError, match=r"hawk/part\.py:3: write the template out"):
        list(sentences.calls(tmp_path))
