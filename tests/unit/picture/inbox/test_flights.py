from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.inbox.flights import JOIN_S, LONGEST_NAME, FlightReader, Moment, Part, continues, plain_name
from hawk.picture.inbox.folder import LOOSE, Drop, FileFacts
from tests.unit.picture.photographs.photos import flight


def drop(root: Path, name: str = LOOSE) -> Drop:
    files = sorted(path for path in (root / name).rglob("*") if path.is_file())
    return Drop(name, tuple(FileFacts(str(path.relative_to(root)), path.stat().st_size, 0) for path in files))


def parts(root: Path, name: str = LOOSE) -> list[Part]:
    return FlightReader(root).parts(drop(root, name))


def names(part: Part) -> tuple[list[str], list[str]]:
    return [Path(one.file.path).name for one in part.pictures], [Path(one.path).name for one in part.others]


def test_photographs_over_folders_of_a_card_are_one_flight(tmp_path: Path) -> None:
    for number in range(2):
        (tmp_path / f"north/10{number}MEDIA").mkdir(parents=True)
        flight(tmp_path / f"north/10{number}MEDIA", 2, minute=number, north=1e-4 * number)
    (tmp_path / "north/flight.MRK").write_text("1")
    (part,) = parts(tmp_path, "north")
    assert part.title == "north"
    assert names(part) == (["DJI_0000.JPG", "DJI_0001.JPG"] * 2, ["flight.MRK"])
    assert part.datum == pytest.approx((46.8401, -91.99))


def test_the_id_is_of_the_pictures_alone(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    files = flight(tmp_path / "a", 3)
    (tmp_path / "b/inner").mkdir(parents=True)
    random.Random(1).shuffle(files)
    for number, file in enumerate(files):
        (tmp_path / f"b/inner/{number}.jpeg").write_bytes(file.read_bytes())
    assert parts(tmp_path, "a")[0].id == parts(tmp_path, "b")[0].id
    (tmp_path / "b/inner/0.jpeg").unlink()
    assert parts(tmp_path, "a")[0].id != parts(tmp_path, "b")[0].id


def test_two_cameras_and_two_flights_of_a_folder_are_apart(tmp_path: Path) -> None:
    (tmp_path / "day").mkdir()
    flight(tmp_path / "day", 4)
    flight(tmp_path / "day", 4, first=10, minute=90)
    flight(tmp_path / "day", 4, first=20, size=(160, 120))
    assert sorted(part.title for part in parts(tmp_path, "day")) == [
        "day-2024-05-01-100000", "day-2024-05-01-100000", "day-2024-05-01-113000",
    ]  # fmt: skip


def test_two_drones_of_one_model_over_one_lot_are_two_flights(tmp_path: Path) -> None:
    for number, tags in enumerate(({"drone-dji:DroneSerialNumber": "1581A"}, {"drone-dji:DroneSerialNumber": "1581B"})):
        flight(tmp_path, 3, first=10 * number, tags=tags)
    one, other = parts(tmp_path)
    assert [names(part)[0][0] for part in (one, other)] == ["DJI_0000.JPG", "DJI_0010.JPG"]
    assert continues(one.moments, one.moments)
    assert not continues(one.moments, other.moments)
    (tmp_path / "body").mkdir()
    flight(tmp_path / "body", 2, photo={0xA431: "A"})
    flight(tmp_path / "body", 2, first=10, photo={0xA431: "B"})
    assert len(parts(tmp_path, "body")) == 2


def test_what_is_no_photograph_stays_with_the_flight_which_says_why(tmp_path: Path) -> None:
    flight(tmp_path, 3)
    (tmp_path / "broken.jpg").write_bytes(b"\xff\xd8\xff")
    (part,) = parts(tmp_path)
    assert names(part)[0][-1] == "broken.jpg"
    assert part.title == "2024-05-01-100000"


def test_each_film_and_orthophoto_is_a_flight_with_what_has_its_name(tmp_path: Path) -> None:
    for name in ("DJI_1.MP4", "DJI_1.SRT", "DJI_2.MOV", "lot.tif", "lot.tfw", "yard.jpg", "yard.jgw"):
        (tmp_path / name).write_bytes(name.encode())
    found = {part.source: names(part) for part in parts(tmp_path)}
    assert found == {
        "DJI_1.MP4": (["DJI_1.MP4"], ["DJI_1.SRT"]),
        "DJI_2.MOV": (["DJI_2.MOV"], []),
        "lot.tif": (["lot.tif"], ["lot.tfw"]),
        "yard.jpg": (["yard.jpg"], ["yard.jgw"]),
    }


def test_tiles_go_with_their_vrt_and_a_tiff_beside_photographs_is_no_orthophoto(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        for name in ("1.tif", "2.tif"):
            (tmp_path / folder / name).write_bytes(name.encode())
    (tmp_path / "a/all.vrt").write_text("<VRTDataset>")
    flight(tmp_path / "b", 2)
    assert [(part.source, *names(part)) for part in parts(tmp_path, "a")] == [
        ("all.vrt", ["all.vrt"], ["1.tif", "2.tif"])
    ]
    (part,) = parts(tmp_path, "b")
    assert (part.source, names(part)[1]) == ("", ["1.tif", "2.tif"])


def test_what_is_nothing_of_it_is_a_flight_that_will_say_so(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("x")
    (part,) = parts(tmp_path)
    assert (part.title, part.source, names(part)) == ("letter", "", (["letter.txt"], []))


def test_a_file_that_breaks_its_reader_is_left_to_the_mapping(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RecursionError

    flight(tmp_path, 1)
    monkeypatch.setattr("hawk.picture.inbox.flights.read_photograph", broken)
    (part,) = parts(tmp_path)
    assert names(part) == (["DJI_0000.JPG"], [])


def test_a_file_that_vanishes_is_in_no_flight(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("x")
    found = drop(tmp_path)
    (tmp_path / "a.txt").unlink()
    assert FlightReader(tmp_path).parts(found) == []


@pytest.mark.parametrize(
    ("later", "east", "kind", "is_one"),
    [
        (JOIN_S, 0.0, "a", True),
        (JOIN_S + 1, 0.0, "a", False),
        (5, 0.003, "a", True),
        (5, 0.005, "a", False),
        (5, 0, "b", False),
    ],
)
def test_drops_are_one_flight_where_time_place_and_camera_go_on(
    later: float, east: float, kind: str, *, is_one: bool
) -> None:
    here = [Moment("a", 1000.0 + k, 46.84, -91.99) for k in range(3)]
    there = [Moment(kind, 1002.0 + later, 46.84, -91.99 + east)]
    assert continues(here, there) is is_one
    assert continues(there, here) is is_one


@given(name=st.text() | st.binary().map(lambda data: data.decode("utf-8", "surrogateescape")), count=st.integers(0, 3))
def test_a_plain_name_is_one_that_every_system_takes(name: str, count: int) -> None:
    taken: set[str] = set()
    for _ in range(count + 1):
        found = plain_name(name, taken.__contains__)
        taken.add(found)
    assert len(taken) == count + 1
    for each in taken:
        assert each.isprintable()
        assert not each.startswith((".", " "))
        assert not set(each) & set('/\\:*?"<>|')
        assert 0 < len(each) <= LONGEST_NAME + 4
        each.encode()
