"""The ChArUco board to calibrate with, and its PDF in true size.

PDF, since its lengths are those of the paper and the file asks the print dialog not to scale it (`PrintScaling`); a
browser fits an SVG to its own margins. The file holds filled rectangles only, so that no library is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

SQUARES: Final = (7, 10)
"""Squares of the board across and down. Both papers have as many, so that a picture of either can be used: neither
focal length, centre nor distortion depend on the size of the board."""
MARKER_SHARE: Final = 0.72
"""Side of a marker by that of a square."""
DICTIONARY: Final = cv2.aruco.DICT_4X4_50
"""4 x 4 bits: the largest modules, seen from farthest. 35 of its 50 markers are on the board."""
_MODULES: Final = 6  # of a marker across: four bits and the border
_RULER_MM: Final = 100.0
_POINT_MM: Final = 25.4 / 72  # PDF's unit (ISO 32000-1, 8.3.2.3)

Rectangle = tuple[float, float, float, float]
"""Left, top, width, height in millimetres from the paper's upper left corner."""


@dataclass(frozen=True, slots=True)
class Paper:
    """A sheet (ISO 216), upright, and the side of the board's squares on it, millimetres."""

    name: str
    width: float
    height: float
    square: float


PAPERS: Final = {"A4": Paper("A4", 210.0, 297.0, 25.0), "A3": Paper("A3", 297.0, 420.0, 36.0)}


def make_board(square: float = 1.0) -> cv2.aruco.CharucoBoard:
    """Return the board; its lengths are in units of ``square``."""
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARY)
    return cv2.aruco.CharucoBoard(SQUARES, square, square * MARKER_SHARE, dictionary)


def board_rectangles(paper: Paper) -> list[Rectangle]:
    """Return the black rectangles of the board in the middle of the paper, as OpenCV draws it."""
    board = make_board(paper.square)
    left = (paper.width - SQUARES[0] * paper.square) / 2
    top = (paper.height - SQUARES[1] * paper.square) / 2
    black: list[Rectangle] = [
        (left + column * paper.square, top + row * paper.square, paper.square, paper.square)
        for row in range(SQUARES[1])
        for column in range(SQUARES[0])
        if (row + column) % 2 == 0
    ]
    module = paper.square * MARKER_SHARE / _MODULES
    for number, corners in zip(np.ravel(board.getIds()), board.getObjPoints(), strict=True):
        x, y, _ = (float(value) for value in np.asarray(corners).reshape(4, 3)[0])
        black += _modules(_bits(int(number)), left + x, top + y, module)
    return black


def _bits(number: int) -> NDArray[np.uint8]:
    """Return a marker's modules (6, 6): 0 is black."""
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARY)
    return np.asarray(cv2.aruco.generateImageMarker(dictionary, number, _MODULES, borderBits=1), np.uint8)


def _modules(bits: NDArray[np.uint8], left: float, top: float, module: float) -> list[Rectangle]:
    """Return the black runs of each row: neighbours in one rectangle, so that no printer leaves a line between them."""
    found: list[Rectangle] = []
    for row, values in enumerate(bits):
        edges = np.flatnonzero(np.diff(np.concatenate([[1], values > 0, [1]]).astype(int)))
        for first, last in edges.reshape(-1, 2):
            found.append((left + first * module, top + row * module, (last - first) * module, module))
    return found


def ruler_rectangles(paper: Paper) -> list[Rectangle]:
    """Return two rulers of 100 mm with ticks every 10 mm: one across below the board, one down at its left.

    A print that is scaled differently across and down would bend the focal lengths.
    """
    across, down = (paper.width - _RULER_MM) / 2, (paper.height - _RULER_MM) / 2
    bottom, left = paper.height - 12.0, 11.0
    line, ticks = 0.3, [10.0 * k for k in range(11)]
    found = [(across, bottom, _RULER_MM, line), (left, down, line, _RULER_MM)]
    found += [(across + at - line / 2, bottom - 3.0, line, 3.0) for at in ticks]
    found += [(left, down + at - line / 2, 3.0, line) for at in ticks]
    return found


def board_pdf(paper: Paper) -> bytes:
    """Return the file: one page with the board, both rulers and what to do."""
    drawn = ["0 g", *(_drawn(each, paper) for each in (*board_rectangles(paper), *ruler_rectangles(paper)))]
    drawn.append(
        _text(f"hawk calibration board, {paper.name}: print at 100 %. Both rulers must be 100 mm long.", 34.0, 6.0)
    )
    return _document("\n".join(drawn).encode("ascii"), paper)


def _drawn(rectangle: Rectangle, paper: Paper) -> str:
    left, top, width, height = rectangle
    values = (left, paper.height - top - height, width, height)
    return f"{' '.join(f'{value / _POINT_MM:.4f}' for value in values)} re f"


def _text(words: str, left: float, bottom: float) -> str:
    return f"BT /F1 9 Tf {left / _POINT_MM:.2f} {bottom / _POINT_MM:.2f} Td ({words}) Tj ET"


def _document(content: bytes, paper: Paper) -> bytes:
    """Return a PDF 1.7 of one page (ISO 32000-1, 7.5): objects, the table of their places, trailer."""
    box = f"[0 0 {paper.width / _POINT_MM:.4f} {paper.height / _POINT_MM:.4f}]"
    fonts = "<< /Font << /F1 5 0 R >> >>"
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R /Resources {fonts} >>".encode(),
        b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
    ]
    file, places = b"%PDF-1.7\n", []
    for number, each in enumerate(objects, start=1):
        places.append(len(file))
        file += b"%d 0 obj\n%s\nendobj\n" % (number, each)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    head = b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1)
    trailer = b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, len(file))
    return file + head + table + trailer
