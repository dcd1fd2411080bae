"""Damaged and hostile files at every reader: a sample of `python -m proving.fuzz files`, and that it finds defects."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from urllib.request import urlopen

import pytest

from proving.fuzz import bases
from proving.fuzz.damage import Damage
from proving.fuzz.files import fuzz_reader
from proving.fuzz.readers import READERS, FileReader, Prepared


def _reader(read: Callable[[Path], object]) -> FileReader:
    def prepare() -> Prepared:
        return read, (KeyError,)

    return FileReader("made", bases.captions, prepare)


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS, ids=lambda each: each.name)
def test_a_sample_of_damaged_files_is_read_or_refused_in_words(reader: FileReader) -> None:
    result = fuzz_reader(reader, 50)
    assert result.findings == []
    assert result.read + result.refused == 50
    assert min(result.read, result.refused) > 0


def _takes_memory(path: Path) -> None:
    assert len(bytearray(b"x") * 1_200_000_000) > 0


def _refuses_without_words(path: Path) -> None:
    raise KeyError


def _refuses(path: Path) -> None:
    raise KeyError("no word of it")


def _ends(path: Path) -> None:
    os._exit(11)


def _asks(path: Path) -> None:
    text = path.read_text(errors="replace")
    at = text.find("http://127")
    if at >= 0:
        urlopen(text[at : text.index("/x", at)], timeout=0.2)  # noqa: S310 - our own server


@pytest.mark.slow
@pytest.mark.parametrize(
    ("read", "words"),
    [
        (_takes_memory, "took 1|MemoryError"),  # by how much its process has already
        (_refuses_without_words, "refused without words"),
        (_ends, "its process ended with 11"),
        (_asks, "a request went out"),
        (lambda path: [][1], "IndexError: list index out of range"),
        (_refuses, "a sound file is not read: 'no word of it'"),
    ],
)
def test_a_defect_of_a_reader_is_found(read: Callable[[Path], object], words: str) -> None:
    result = fuzz_reader(_reader(read), 1 if read is _takes_memory else 4)
    assert any(re.search(words, finding) for finding in result.findings), result.findings


def test_files_depend_on_seed_and_number_only(tmp_path: Path) -> None:
    sound = list(bases.captions(tmp_path))
    first, again, other = (Damage(seed, sound, []) for seed in (1, 1, 2))
    drawn = [first.at(number) for number in range(200)]
    assert [again.at(number) for number in reversed(range(200))] == drawn[::-1]
    assert [other.at(number) for number in range(200)] != drawn
