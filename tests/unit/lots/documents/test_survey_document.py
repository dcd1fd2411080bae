from __future__ import annotations

import copy
import gzip
import json
import zlib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from hawk.lots.documents import parts, survey_document
from hawk.lots.values import LotInputError
from tests.examples import examples
from tests.unit.lots.documents.drones import Drone, days, tile

VERSION_1 = Path(__file__).with_name("version_1.json")
"""A document as version 1 writes it, read for ever."""
Json = dict[str, Any]


def golden() -> Json:
    found: Json = json.loads(VERSION_1.read_text("utf-8"))
    return found


def sent(content: object) -> bytes:
    return gzip.compress(json.dumps(content).encode())


def refusal(data: bytes) -> str:
    with pytest.raises(LotInputError) as refused:
        survey_document.unpacked(data)
    return str(refused.value)


def test_a_document_of_version_1_is_read_and_says_what_it_said() -> None:
    document = survey_document.unpacked(sent(golden()))
    found = json.loads(document.model_dump_json())
    assert [lot.pop("base") for lot in found["lots"]] == [None] * len(found["lots"]), "it is newer than this document"
    assert found == golden()
    assert (document.survey.state, document.survey.landing, document.survey.placed) == (9, 1, "first")
    assert len(document.stalls) == len(document.looks) == len(document.lots[0].stalls) == 3
    assert document.lots[0].sections[0].name == "Kerb"
    assert document.sections[0].parked == 2
    assert document.mosaic[0].jpeg == tile()


@pytest.mark.nightly
def test_what_a_store_says_is_read_as_it_was_packed(tmp_path: Path) -> None:
    drone = Drone.at(tmp_path / "lots.db")
    for _ in days(drone):
        documents = drone.documents()
        assert [survey_document.unpacked(parts.packed(each)) for each in documents] == documents
    assert parts.packed(documents[0]) == parts.packed(documents[0])
    drone.store.close()


@settings(max_examples=examples(100), deadline=None)
@given(share=st.floats(0, 1, exclude_max=True))
def test_a_document_that_was_cut_anywhere_is_refused(share: float) -> None:
    data = sent(golden())
    assert "document: " in refusal(data[: int(share * len(data))])


@settings(max_examples=examples(200), deadline=None)
@given(st.binary(max_size=300), st.integers(0, 10_000))
def test_wrong_bytes_are_refused_or_read_and_never_fail_otherwise(data: bytes, at: int) -> None:
    whole = sent(golden())
    at %= len(whole)
    for each in (data, whole[:at] + data + whole[at + len(data) :]):
        try:
            survey_document.unpacked(each)
        except LotInputError as refused:
            named = refused.field
        else:
            named = "none"
        assert named


@pytest.mark.slow
def test_a_document_that_unpacks_to_gigabytes_is_refused_and_not_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LARGEST_UNPACKED_BYTES", 1_000_000)
    packer = zlib.compressobj(9, wbits=31)
    bomb = b"".join(packer.compress(b" " * 1_000_000) for _ in range(64)) + packer.flush()
    assert len(bomb) < 100_000
    assert refusal(bomb) == "document: is too large: it unpacks to more than 1 MB"


def test_a_document_that_is_too_large_is_refused_before_it_is_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "LARGEST_BYTES", 2_000_000)
    assert refusal(b"\0" * 2_000_001) == "document: is too large: 2 MB are read at most"


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("stalls", [0] * 3000, "document: is too large: 3,000 values, and 500 lists and objects, are read at most"),
        ("stalls", [{}] * 500, "document: is too large"),
        ("survey/outline/polygons", [[]] * 500, "document: is too large"),
        ("survey", {"outline": [{}] * 200}, "survey.id: is missing: write it"),
        ("survey/place", {"north": [0] * 2000}, "survey.place.east: is missing: write it"),
        ("survey/more", {str(number): 0 for number in range(2000)}, "survey.more: is not known here"),
        ("lots/0/stalls/1", {"id": [0] * 2000}, "lots[0].stalls[1].label: is missing: write it"),
    ],
)
@pytest.mark.fault(
    "a document of some kilobytes would take gigabytes while it is read",
    "refused before pydantic reads it; the bytes are counted, and the names looked at",
)
def test_a_document_that_would_take_gigabytes_is_refused_before_it_is_read(
    monkeypatch: pytest.MonkeyPatch, path: str, value: object, words: str
) -> None:
    monkeypatch.setattr(parts, "MOST_VALUES", 3000)
    monkeypatch.setattr(parts, "MOST_GROUPS", 500)
    monkeypatch.setattr(survey_document.SurveyDocument, "model_validate_json", None)
    assert refusal(sent(changed(path, value))).startswith(words)


@pytest.mark.parametrize("path", ["survey/candidates", "survey/outline/polygons", "stalls", "lots/0/layouts", "mosaic"])
def test_of_a_list_of_wrong_values_the_first_one_is_refused_alone(path: str) -> None:
    content = json.dumps(changed(path, [7] * 50))
    with pytest.raises(ValidationError) as refused:
        survey_document.SurveyDocument.model_validate_json(content, strict=True)
    assert refused.value.error_count() == 1


def test_two_documents_behind_each_other_are_none() -> None:
    assert "document: is cut, or longer than one document" in refusal(sent(golden()) * 2)


def test_a_document_of_a_newer_version_is_refused_with_the_remedy() -> None:
    words = refusal(sent({**golden(), "version": 2, "news": 1}))
    assert words == "version: is 2, of a newer hawk-drone; who takes it in reads up to 1: upgrade that one"


def changed(path: str, value: object) -> Json:
    """Return the golden document with another value."""
    content = copy.deepcopy(golden())
    *places, last = path.split("/")
    part: Any = content
    for place in places:
        part = part[int(place) if place.isdecimal() else place]
    part[int(last) if last.isdecimal() else last] = value
    return content


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("format", "hawk plan", 'format: must be "hawk survey"'),
        ("version", 0, "version: must be a whole number from 1"),
        ("version", True, "version: must be a whole number from 1"),
        ("surveys", [], "surveys: is not known here: leave it out"),
        ("survey/id", "../../etc/passwd", "survey.id: must be a UUID in lower case"),
        ("survey/id", "a" * 36, "survey.id: must be a UUID in lower case"),
        ("survey/name", "../journal", "survey.name: must be a name without / and .."),
        ("survey/name", "..", "survey.name: must be a name without / and .."),
        ("survey/name", "a/b", "survey.name: must be a name without / and .."),
        ("survey/state", -1, "survey.state: must be 0 or more"),
        ("survey/state", 2**60, "survey.state: must be 9007199254740992 or less"),
        ("survey/latitude", 91, "survey.latitude: must be 90 or less"),
        ("survey/longitude", "5", "survey.longitude: must be a number"),
        ("survey/ended", 1e12, "survey.ended: must be 9999999999 or less"),
        ("survey/ended", 1, "survey.ended: is before survey.began"),
        ("survey/placed", "anywhere", "survey.placed: must be"),
        ("survey/source", "film", "survey.source: must name the kind of pictures"),
        ("survey/lot", "123e4567-e89b-42d3-a456-426614174000", "survey.lot: must be the id of one of the lots"),
        ("survey/accuracy", -1, "survey.accuracy: must be 0 or more"),
        ("stalls/0/north", 1e9, "stalls[0].north: must be 1000000 or less"),
        ("stalls/1/width", 0, "stalls[1].width: must be more than 0"),
        ("stalls/1/id", 1, "stalls: names one of them twice"),
        ("stalls/2/state", "gone", "stalls[2].state: must be"),
        ("stalls/2/taken_probability", 1.5, "stalls[2].taken_probability: must be 1 or less"),
        ("looks/0/stall", "B 12", "looks[0].stall: must be a UUID"),
        ("lots/0/name", "\u202eNorth", "lots[0].name: holds characters that cannot be shown"),
        ("lots/0/stalls/0/kind", "boat", "lots[0].stalls[0].kind: is no kind"),
        ("lots/0/stalls/0/begins", 0, "lots[0].stalls[0].begins: must be 1 or more"),
        ("lots/0/sections/0/outline", [[0, 0], [1, 1]], "lots[0].sections[0].outline: must be a list of 3 or more"),
        ("lots/0/merged_into", "123e4567-e89b-42d3-a456-426614174000", "lots[0].merged_into: must be the id of one"),
        ("mosaic/0/row", 10**7, "mosaic[0].row: must be 999999 or less"),
        ("mosaic/0/jpeg", "not base64!", "mosaic[0].jpeg: "),
        ("mosaic/0/jpeg", "bm8gcGljdHVyZQ==", "mosaic[0].jpeg: must be a JPEG of 256 x 256 pixels"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_its_field(path: str, value: object, words: str) -> None:
    assert refusal(sent(changed(path, value))).startswith(words)


@pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity"])
def test_what_is_no_number_is_refused(text: str) -> None:
    content = json.dumps(changed("stalls/0/score", 12345.5)).replace("12345.5", text)
    assert refusal(gzip.compress(content.encode())).startswith("document: is no JSON")
