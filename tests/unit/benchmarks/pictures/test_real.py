"""The labels of the real lot that come with the benchmark."""

from __future__ import annotations

import json

import numpy as np

from benchmarks.pictures.real import PHOTO_LOT


def test_the_shipped_labels_name_every_stall_once() -> None:
    shipped = json.loads(PHOTO_LOT.read_text())
    corners = np.array(list(shipped["stalls"].values()))
    assert corners.shape == (73, 4, 2)
    assert ((corners > 0) & (corners < (4608, 3456))).all()
    assert {name for names in shipped["taken"].values() for name in names} <= set(shipped["stalls"])
    assert "CC0" in shipped["licence"]
