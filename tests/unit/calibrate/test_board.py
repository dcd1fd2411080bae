from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from hawk.calibrate.board import MARKER_SHARE, PAPERS, SQUARES, board_pdf, make_board, ruler_rectangles
from hawk.cli import main
from tests.unit.calibrate.boards import sheet

PIXELS = 6


@pytest.mark.parametrize("name", ["A4", "A3"])
def test_the_print_is_the_board_that_opencv_draws(name: str) -> None:
    paper = PAPERS[name]
    square = round(paper.square * PIXELS)
    drawn = make_board().generateImage((SQUARES[0] * square, SQUARES[1] * square), marginSize=0)
    printed = sheet(name)
    left = round((paper.width - SQUARES[0] * paper.square) / 2 * PIXELS)
    top = round((paper.height - SQUARES[1] * paper.square) / 2 * PIXELS)
    cut = printed[top : top + drawn.shape[0], left : left + drawn.shape[1]]
    assert np.mean(np.abs(cut.astype(int) - drawn) > 100) < 0.01  # edges of modules fall between pixels


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A4", "A3"])
def test_every_corner_is_found_where_it_is_printed(name: str) -> None:
    paper = PAPERS[name]
    corners, ids, _, _ = cv2.aruco.CharucoDetector(make_board()).detectBoard(sheet(name))
    assert len(ids) == (SQUARES[0] - 1) * (SQUARES[1] - 1)
    expected = np.asarray(make_board(paper.square).getChessboardCorners())[np.ravel(ids), :2]
    border = np.array([paper.width - SQUARES[0] * paper.square, paper.height - SQUARES[1] * paper.square]) / 2
    found = (np.asarray(corners).reshape(-1, 2) + 0.5) / PIXELS - border
    assert np.abs(found - expected).max() < 0.1  # millimetres


def test_everything_lies_on_what_a_printer_prints() -> None:
    """Most printers leave 5 mm free."""
    for paper in PAPERS.values():
        page = 25.4 / 72
        for found in re.finditer(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", board_pdf(paper)):
            left, bottom, width, height = (float(value) * page for value in found.groups())
            assert left >= 5
            assert bottom >= 5
            assert left + width <= paper.width - 5
            assert bottom + height <= paper.height - 5


def test_the_rulers_are_100_mm_long_across_and_down_and_touch_no_square() -> None:
    for paper in PAPERS.values():
        across, down, *ticks = ruler_rectangles(paper)
        assert across[2] == down[3] == 100
        assert len(ticks) == 22
        border = np.array([paper.width - SQUARES[0] * paper.square, paper.height - SQUARES[1] * paper.square]) / 2
        assert across[1] - 3 > paper.height - border[1]
        assert down[0] + 3 < border[0]


def test_the_file_is_a_pdf_of_the_paper_s_size_that_is_not_to_be_scaled() -> None:
    file = board_pdf(PAPERS["A4"])
    assert file.startswith(b"%PDF-1.7\n")
    assert b"/PrintScaling /None" in file
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", file)
    assert box is not None
    assert [float(each) * 25.4 / 72 for each in box.groups()] == pytest.approx([210, 297], abs=1e-3)
    places = [int(each) for each in re.findall(rb"(\d{10}) 00000 n \n", file)]
    assert [file[place : place + 7] for place in places] == [b"%d 0 obj" % n for n in range(1, 6)]
    start = re.search(rb"startxref\n(\d+)\n%%EOF\n$", file)
    assert start is not None
    assert file[int(start[1]) :].startswith(b"xref\n")
    stream = re.search(rb"/Length (\d+) >>\nstream\n(.*)\nendstream", file, re.DOTALL)
    assert stream is not None
    assert len(stream[2]) == int(stream[1])


def test_both_papers_have_the_same_board() -> None:
    for paper in PAPERS.values():
        board = make_board(paper.square)
        assert board.getMarkerLength() / board.getSquareLength() == pytest.approx(MARKER_SHARE)


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "board.pdf"
    assert main(["calibrate", "board", "--out", str(path), "--paper", "A3"]) == 0
    assert path.read_bytes() == board_pdf(PAPERS["A3"])
    assert "both rulers are 100 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("board.svg", "must end in .pdf"),
        ("there.pdf", "exists already"),
        ("no/b.pdf", "cannot be"),
        (f"{'n' * 300}.pdf", "cannot be written: File name too long; name a folder that this user may write"),
    ],
)
def test_a_file_that_cannot_be_written_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, words: str
) -> None:
    (tmp_path / "there.pdf").touch()
    assert main(["calibrate", "board", "--out", str(tmp_path / name)]) == 2
    assert f"--out: {tmp_path / name} {words}" in capsys.readouterr().err
