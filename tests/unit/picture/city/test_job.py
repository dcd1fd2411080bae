"""A computer that does not see what the client sees is refused with the remedy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hawk.picture.city.job import fitting_detector
from hawk.picture.values import PictureError
from tests.unit.picture.city.fakes import SHA, job_of, windows


@pytest.mark.slow
def test_a_computer_that_sees_the_same_gets_the_eye(tmp_path: Path) -> None:
    source, _ = windows(tmp_path)
    job = job_of(tmp_path, source)
    assert fitting_detector(job).model == SHA
    assert (job.folder / "windows").is_dir()


@pytest.mark.slow
def test_another_folder_picture_or_network_is_refused(tmp_path: Path) -> None:
    source, _ = windows(tmp_path)
    job = job_of(tmp_path, source)
    for other, words in (
        (replace(job, mark=".run-2"), f"does not see the folder {job.folder}; share it"),
        (replace(job, source=replace(source, path=tmp_path / "gone.tif")), r"gone.tif: is no file.*share the picture"),
        (replace(job, source=replace(source, identity="[]")), "is another file here.*do not copy"),
        (replace(job, sha="6" * 64), "install the same version and name one model"),
        (replace(job, program="hawk 0"), "the client hawk 0; install the same version"),
    ):
        with pytest.raises(PictureError, match=words):
            fitting_detector(other)
