from __future__ import annotations

from collections.abc import Iterator

import cv2
import pytest

from hawk.algo.vision.detector import one_thread


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    threads = cv2.getNumThreads()
    yield
    cv2.setNumThreads(threads)


def test_a_program_that_maps_pictures_has_its_own_number_of_threads_again() -> None:
    cv2.setNumThreads(2)
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 2


def test_after_an_error_too() -> None:
    cv2.setNumThreads(2)
    with pytest.raises(KeyError), one_thread():
        raise KeyError
    assert cv2.getNumThreads() == 2
