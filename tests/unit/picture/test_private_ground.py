"""Private ground near a picture: none of it is passed over, however large it is and on whatever side of ±180°."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.model.pictures import CameraModel
from hawk.model.poses import GlobalPose
from hawk.picture.orthophoto.grid import PixelGrid, measure_grid, system
from hawk.picture.photographs.flight import private_ground
from hawk.picture.private_ground import continuous, near_shots, rings_in, wider
from hawk.picture.values import PictureError, Shot

DEGREE_M = 111_195.0
OVER = shapely.Polygon([(179.9998, -0.0002), (-179.9998, -0.0002), (-179.9998, 0.0002), (179.9998, 0.0002)])
"""44 m a side about the place where ±180° meets the equator."""


def grid(crs: str, x: float, y: float) -> PixelGrid:
    return measure_grid(PixelGrid(1000, 800, system(crs, "a.tif")[0], (0.1, 0.0, x, 0.0, -0.1, y)), "a.tif")


@pytest.mark.parametrize(
    "area",
    [shapely.box(-180, -90, 180, 90), shapely.box(-90, -89.99, 120, 89.99), shapely.box(4.9, -80, 5.1, 80)],
)
def test_an_area_beyond_the_picture_s_system_hides_all_of_the_picture(area: shapely.Polygon) -> None:
    rings = rings_in(grid("EPSG:32631", 640_000.0, 5_770_000.0), [area])
    assert shapely.union_all([shapely.Polygon(ring) for ring in rings]).covers(shapely.box(0, 0, 1000, 800))


def test_an_area_elsewhere_has_no_ring() -> None:
    assert rings_in(grid("EPSG:32631", 640_000.0, 5_770_000.0), [shapely.box(50, 10, 51, 11)]) == ()


@pytest.mark.parametrize(("crs", "x"), [("EPSG:32660", 833_928.0), ("EPSG:32601", 165_972.0)])
def test_stored_ground_over_180_degrees_is_wider_by_5_m_on_all_sides(crs: str, x: float) -> None:
    picture = grid(crs, x, 40.0)
    plain, wide = (
        np.ptp(np.array([corner for ring in rings_in(picture, [area]) for corner in ring]), axis=0) * 0.1
        for area in (OVER, wider(OVER))
    )
    assert plain == pytest.approx((44.5, 44.5), abs=1.0)
    assert wide - plain == pytest.approx((10.0, 10.0), abs=0.3)


@pytest.mark.parametrize("longitude", [179.9999, -179.9999])
def test_photographs_on_both_sides_of_180_degrees_lack_the_ground(longitude: float) -> None:
    hidden = private_ground([OVER], GlobalPose(0.0, longitude, 0.0))
    south, west, north, east = hidden.bounds
    assert (north - south, east - west) == pytest.approx((54.5, 54.5), abs=1.0)
    assert hidden.covers(shapely.Point(0.0, 0.0))


def test_an_area_over_the_seam_of_a_system_is_refused_with_its_number() -> None:
    seam = grid("EPSG:3857", 20_037_480.0, 40.0)
    with pytest.raises(PictureError, match=r"private area 2 has no place in the picture's .* gdalwarp"):
        rings_in(seam, [shapely.box(5, 52, 6, 53), OVER])


def test_an_area_round_the_earth_stays() -> None:
    assert continuous(shapely.box(-180, -90, 180, 90)).area == 360 * 180
    assert continuous(OVER).bounds == pytest.approx((179.9998, -0.0002, 180.0002, 0.0002))


@pytest.mark.parametrize(("longitude", "is_near"), [(179.9999, True), (-179.9999, True), (179.98, False)])
def test_ground_that_shots_may_show_is_near_one(longitude: float, is_near: bool) -> None:
    camera = CameraModel(100, 100, 100.0, 100.0, 50.0, 50.0)
    shot = Shot(Path("a.jpg"), camera, 0.0, longitude, None, 60.0, None, (2.0, 3.0), None)
    assert [*near_shots([OVER, shapely.box(5, 52, 6, 53)], [shot])] == ([OVER] if is_near else [])
