"""Shadows of vehicles on each other: under a low sun a car darkens its neighbour's flank and bonnet."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from hawk.worlds.canvas import Floats, Points
from hawk.worlds.cars import VehicleModel, outline
from hawk.worlds.light import Sun
from hawk.worlds.plan import Vehicle


class ShadowsAmong:
    """The vehicles of a place, as what stands between others and the sun."""

    def __init__(self, drawn: Sequence[tuple[Vehicle, VehicleModel]], sun: Sun) -> None:
        self._sun = sun
        self._blocks = [
            (vehicle, outline(vehicle.x, vehicle.y, vehicle.heading, model.length, model.width), model.height)
            for vehicle, model in (drawn if sun.is_low else ())
        ]
        self._places = np.array([(vehicle.x, vehicle.y) for vehicle, _, _ in self._blocks]).reshape(-1, 2)
        self._reaches = np.array([height * sun.reach + 8.0 for _, _, height in self._blocks])

    def gain(self, of: Vehicle, places: Points, height: float) -> Floats:
        """Return the gain (..., 3) that the other vehicles' shadows leave at places (..., 2), metres, at a height.

        It is 1 under a sun that is not low: there shadows fall on the ground between vehicles.
        """
        gain = np.ones((*places.shape[:-1], 3), np.float32)
        if not self._blocks:
            return gain
        left = np.array(self._sun.gain, np.float32)
        near = np.hypot(*(self._places - (of.x, of.y)).T) < self._reaches
        for k in np.flatnonzero(near).tolist():
            vehicle, footprint, top = self._blocks[k]
            if vehicle is not of and top > height:
                swept = np.concatenate([footprint, footprint + self._sun.cast(top - height)]).astype(np.float32)
                hull = np.asarray(cv2.convexHull(swept)[:, 0], np.float64)
                gain[_inside(hull, places)] = left
        return gain


def _inside(hull: Points, places: Points) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return True (...) for places (..., 2) inside a convex outline (N, 2)."""
    edges = np.roll(hull, -1, axis=0) - hull
    away = places[..., None, :] - hull
    sides = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]
    return np.asarray((sides >= 0).all(-1) | (sides <= 0).all(-1))
