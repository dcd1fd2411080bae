from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.lots.survey.landing import finished
from hawk.lots.survey.private_ground import ERROR_M
from hawk.lots.survey.source import Limit, SourceKind
from hawk.model.lot_map import TILE_M
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import decode_picture
from hawk.picture import checkpoints
from hawk.picture.photographs.flight import map_photos, survey_shots
from hawk.picture.photographs.folder import read_folder
from hawk.picture.photographs.shot_detections import Files
from hawk.picture.photographs.shot_poses import known_pose
from hawk.picture.values import FlightId, PictureError, PictureSurvey, Provenance, Shot, ShotSet
from hawk.results.survey_map import to_global
from hawk.sim.photos import PhotoOptions, write_photos
from hawk.sim.photos_tags import CAMERAS
from tests.drawn_worlds import drawn_world

OPTIONS = PhotoOptions(height=80.0, width=1200, overlap=(0.5, 0.3), camera=CAMERAS["FC6310"], noise_seed=3)
YARD = Provenance("yard", SourceKind.PHOTOGRAPHS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five of the photographs of a flight over a drawn lot of 130 stalls: of two strips over its middle."""
    path = tmp_path_factory.mktemp("flight") / "yard"
    write_photos(drawn_world(3), OPTIONS, path)
    for number in (1, 4, 5):
        (path / f"DJI_{number:04}.JPG").unlink()
    return path


def small(shots: Sequence[Shot]) -> tuple[Shot, ...]:
    """Return the shots from a quarter of their height with a quarter of their pixels: as sharp, and quick."""

    def by(shot: Shot) -> Shot:
        camera, height = shot.camera, shot.height
        assert height is not None
        fourth = dataclasses.replace(
            camera,
            width=camera.width // 4,
            height=camera.height // 4,
            **{name: getattr(camera, name) / 4 for name in ("fx", "fy", "cx", "cy")},
        )
        return dataclasses.replace(shot, camera=fourth, height=height / 4)

    return tuple(map(by, shots))


class Grey(Files):
    """Pictures that show nothing."""

    def picture(self, shot: Shot) -> np.ndarray:
        """Return a grey picture as large as the camera's."""
        return np.full((shot.camera.height, shot.camera.width, 3), 130, np.uint8)


@pytest.fixture(scope="module")
def torn(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same photographs, the last one cut."""
    path = tmp_path_factory.mktemp("torn") / "yard"
    shutil.copytree(folder, path)
    cut = max(path.glob("*.JPG"))
    cut.write_bytes(cut.read_bytes()[:-20_000])
    return path


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of each step: a second map of the folder is made of them, and features of its pictures are found once."""
    return tmp_path_factory.mktemp("work")


@pytest.fixture(scope="module")
def plain(torn: Path, work: Path) -> tuple[PictureSurvey, list[str]]:
    """The survey, and the steps of its work."""
    steps: list[str] = []
    return map_photos(torn, work=work, progress=lambda step, *_: steps.append(step)), list(dict.fromkeys(steps))


@pytest.mark.slow
def test_a_folder_becomes_a_survey(torn: Path, plain: tuple[PictureSurvey, list[str]]) -> None:
    names = sorted(path.name for path in torn.glob("*.JPG"))
    mapped, steps = plain
    whole = len(names) - 1
    assert len(mapped.survey.stalls) == pytest.approx(130, abs=10)
    assert mapped.survey.lot == "yard"
    assert all(stall.score for stall in mapped.survey.stalls)
    assert mapped.ground is not None
    assert mapped.area_m2 > 8000
    assert [each.name for each in mapped.left_out] == [names[-1]]
    assert any(note.startswith(f"{whole} of {whole} photographs were adjusted") for note in mapped.notes)
    pictures = mapped.survey.pictures
    assert pictures is not None
    assert (pictures.words, pictures.limits, mapped.survey.time_is_sure) == ("photographs yard", (), True)
    assert steps == ["read", "match", "match again", "map", "finish"]


@pytest.mark.slow
def test_private_ground_is_in_no_picture_and_nothing_is_counted_there(
    torn: Path, work: Path, plain: tuple[PictureSurvey, list[str]], tmp_path: Path
) -> None:
    whole, _ = plain
    datum = whole.landed.datum
    middle = float(np.median([stall.east for stall in whole.landed.current.stalls.values()]))
    ((_, longitude),) = to_global(datum, np.array([(0.0, middle)])).tolist()
    garden = json.loads(shapely.to_geojson(shapely.box(longitude, 0.0, longitude + 0.1, 80.0)))
    path = tmp_path / "gardens.geojson"
    path.write_text(json.dumps({"type": "Feature", "geometry": garden, "properties": {}}))
    own = tmp_path / "work"
    own.mkdir()
    for each in work.iterdir():  # all but what was found in pictures
        if not each.name.startswith("found"):
            shutil.copy(each, own)
    mapped = map_photos(torn, private=path, work=own).landed.current
    line = middle - ERROR_M
    kept = [checkpoints._found_of(each.read_bytes()[hashlib.sha256().digest_size :]) for each in own.glob("found-*")]
    assert sum(len(each.stalls) for each in kept) > 50
    assert [stall for each in kept for stall in each.stalls if stall.east > line] == [], "nor in the files of the work"
    assert [stall for stall in mapped.stalls.values() if stall.east > line] == []
    left = [sum(stall.east < line - 3.0 for stall in each.stalls.values()) for each in (whole.landed.current, mapped)]
    assert left[1] == pytest.approx(left[0], abs=3)
    shown = 0
    for (_, column), tile in mapped.mosaic.items():
        _, seen = decode_picture(tile.data)
        easts = column * TILE_M + (np.arange(seen.shape[1]) + 0.5) * TILE_M / seen.shape[1]
        assert not seen[:, easts > line + 0.5].any()
        shown += int(seen[:, easts < line].any())
    assert shown > 3


@pytest.mark.nightly
def test_the_same_pictures_in_another_folder_are_the_same_survey(folder: Path) -> None:
    shots = small(read_folder(folder).shots[:3])
    names = [
        survey_shots(Provenance(name, SourceKind.PHOTOGRAPHS), ShotSet(shots), Grey()).mapped.landed.name
        for name, shots in (("yard", shots[:2]), ("other", shots[:2]), ("yard", shots))
    ]
    assert names[0] == names[1] != names[2]


@pytest.mark.nightly
def test_more_pictures_of_one_flight_are_the_same_survey_about_the_same_datum(folder: Path) -> None:
    shots = small(read_folder(folder).shots[:3])
    flight = FlightId("0123", "yard", (shots[0].latitude, shots[0].longitude))
    provenance = Provenance("yard", SourceKind.PHOTOGRAPHS, flight=flight)
    surveys = [survey_shots(provenance, ShotSet(some), Grey()).mapped.landed for some in (shots[:2], shots)]
    assert {finished(landed).origin for landed in surveys} == {
        f"photographs 0123 {shots[0].latitude:.9f} {shots[0].longitude:.9f}"
    }


@pytest.mark.slow
def test_nothing_but_grey_is_mapped_without_stalls(folder: Path, tmp_path: Path) -> None:
    shots = small(read_folder(folder).shots[:2])
    survey = survey_shots(YARD, ShotSet(tuple(shots)), Grey())
    assert survey.mapped.survey.stalls == ()
    assert (survey.mapped.survey.lot_id, survey.mapped.survey.doubt) == ("", "it has no stalls")
    assert "share too few features" in survey.mapped.notes[0]
    assert survey.mapped.landed.pictures is not None
    assert survey.mapped.landed.pictures.limits == (Limit.BY_GPS,)
    assert (survey.mapped.landed.accuracy, survey.mapped.survey.accuracy) == (None, None)
    exact = [dataclasses.replace(shot, sigma=(0.02, 0.04), sigma_is_said=True) for shot in shots]
    by_rtk = survey_shots(YARD, ShotSet(tuple(exact)), Grey())
    assert by_rtk.mapped.landed.pictures == YARD.source()
    assert (by_rtk.mapped.landed.accuracy, by_rtk.mapped.survey.accuracy) == (0.02, 0.02)
    one_lost = [exact[0], dataclasses.replace(exact[1], sigma=(2.0, 3.0), sigma_is_said=False)]
    assert survey_shots(YARD, ShotSet(tuple(one_lost)), Grey()).mapped.landed.accuracy is None


@pytest.mark.slow
def test_a_flight_across_the_180th_meridian_lies_about_it(folder: Path) -> None:
    shots = [
        dataclasses.replace(shot, latitude=-16.8, longitude=longitude)
        for shot, longitude in zip(small(read_folder(folder).shots[:2]), (179.9999, -179.9998), strict=True)
    ]
    datum = survey_shots(YARD, ShotSet(tuple(shots)), Grey()).mapped.landed.datum
    assert (datum.latitude, datum.longitude) == pytest.approx((-16.8, -179.99995), abs=1e-7)


@pytest.mark.slow
def test_pictures_so_coarse_that_no_stall_shows_are_refused(folder: Path, work: Path) -> None:
    shots = [dataclasses.replace(shot, height=400.0) for shot in read_folder(folder).shots[:1]]
    with pytest.raises(PictureError, match=r"yard: a pixel covers .* fly lower"):
        survey_shots(YARD, ShotSet(tuple(shots)), Files(), work=work)


@pytest.mark.slow
@pytest.mark.parametrize("said_m", [112.0, *(pytest.param(said, marks=pytest.mark.nightly) for said in (56.0, None))])
def test_a_height_that_the_pictures_contradict_or_none_is_asked_about_with_the_one_that_fits(
    folder: Path, work: Path, said_m: float | None
) -> None:
    shots = [dataclasses.replace(shot, height=said_m) for shot in read_folder(folder).shots[:4]]
    with pytest.raises(PictureError, match=r"yard: .*places say (7[6-9]|8[0-4]) m.*--height (7[6-9]|8[0-4]) would fit"):
        survey_shots(YARD, ShotSet(tuple(shots)), Files(), work=work)


@pytest.mark.slow
def test_a_picture_of_another_size_than_its_tags_is_left_out(folder: Path) -> None:
    shots = small(read_folder(folder).shots[:2])

    class Small(Files):
        def picture(self, shot: object) -> np.ndarray:
            shape = (100, 100, 3) if shot is shots[0] else (shots[0].camera.height, shots[0].camera.width, 3)
            return np.full(shape, 90, np.uint8)

    survey = survey_shots(YARD, ShotSet(tuple(shots)), Small())
    assert [each.name for each in survey.mapped.left_out] == [shots[0].name]


def test_pictures_that_cannot_be_read_are_refused(folder: Path, tmp_path: Path) -> None:
    shots = [dataclasses.replace(shot, path=tmp_path / shot.name) for shot in read_folder(folder).shots]
    with pytest.raises(PictureError, match="no photograph can be read"):
        survey_shots(YARD, ShotSet(tuple(shots)), Files())


def test_a_height_must_be_known(folder: Path) -> None:
    shot = dataclasses.replace(read_folder(folder).shots[0], height=None)
    with pytest.raises(PictureError, match="--height"):
        known_pose(shot, GlobalPose(shot.latitude, shot.longitude, 0.0))


def test_a_yaw_that_is_not_sure_is_not_believed(folder: Path) -> None:
    shot = read_folder(folder).shots[0]
    datum = GlobalPose(shot.latitude, shot.longitude, 0.0)
    sure = known_pose(shot, datum).heading
    assert known_pose(dataclasses.replace(shot, yaw_is_sure=False), datum).heading > 10 * sure
    assert known_pose(dataclasses.replace(shot, attitude=None), datum).heading > 10 * sure
    assert known_pose(dataclasses.replace(shot, has_gimbal=False), datum).heading > sure
