"""Values of options, read for argparse: each refusal names what is allowed. Both programs read by these."""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from hawk.config.addresses import usable_path


def path(text: str) -> Path:
    """Return a path, ``~`` replaced by the home folder."""
    try:
        return usable_path(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def file(text: str) -> Path:
    """Return the path of a file that is there."""
    return _there(text, "file", Path.is_file)


def folder(text: str) -> Path:
    """Return the path of a folder that is there."""
    return _there(text, "folder", Path.is_dir)


def _there(text: str, kind: str, is_kind: Callable[[Path], bool]) -> Path:
    found = path(text)
    try:
        found.stat()
    except OSError as error:
        words = f"{text} cannot be read: {error.strerror or error}; name a {kind} that is there"
        raise argparse.ArgumentTypeError(words) from None
    if not is_kind(found):
        raise argparse.ArgumentTypeError(f"{text} is not a {kind}: name a {kind}")
    return found


def new(*suffixes: str) -> Callable[[str], Path]:
    """Return the reader of a file to write: its name ends in one of these, its folder is there."""

    def read(text: str) -> Path:
        found = path(text)
        if suffixes and not found.name.lower().endswith(suffixes):
            raise argparse.ArgumentTypeError(f"{text} must end in {' or '.join(suffixes)}")
        try:
            is_folder = found.exists() and found.is_dir()
            reason = "" if found.parent.is_dir() else f"{found.parent} is no folder"
        except OSError as error:  # a name that is too long, a folder that is closed
            is_folder, reason = False, error.strerror or str(error)
        if is_folder:
            raise argparse.ArgumentTypeError(f"{text} is a folder: name a file")
        if reason:
            words = f"{text} cannot be written: {reason}; name a folder that this user may write"
            raise argparse.ArgumentTypeError(words)
        return found

    return read


def new_folder(text: str) -> Path:
    """Return the path of a folder to write: it is not there yet, or empty."""
    found = path(text)
    try:
        is_free = not found.exists() or (found.is_dir() and not any(found.iterdir()))
    except OSError as error:
        words = f"{text} cannot be read: {error.strerror or error}; name a folder that this user may write"
        raise argparse.ArgumentTypeError(words) from None
    if not is_free and not found.is_dir():
        raise argparse.ArgumentTypeError(f"{text} is a file: name a new folder")
    if not is_free:
        raise argparse.ArgumentTypeError(f"{text} is there and not empty: name a new folder")
    return found


def some(text: str) -> str:
    """Return a text that is not empty."""
    if not text.strip():
        raise argparse.ArgumentTypeError("is empty: write its value, or leave the option out")
    return text


def number(low: float, high: float = math.inf) -> Callable[[str], float]:
    """Return the reader of a finite number within these bounds, both allowed."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (low <= value <= high and math.isfinite(value)):
            top = "" if high == math.inf else f" to {high:g}"
            raise argparse.ArgumentTypeError(f"must be a number from {low:g}{top}, not {text!r}")
        return value

    return read


def whole(low: int = 0, high: int | None = None) -> Callable[[str], int]:
    """Return the reader of a whole number within these bounds, both allowed."""

    def read(text: str) -> int:
        digits = text.removeprefix("-")
        value = int(text) if digits.isascii() and digits.isdigit() and len(digits) < 20 else None
        if value is None or value < low or (high is not None and value > high):
            top = "" if high is None else f" to {high}"
            raise argparse.ArgumentTypeError(f"must be a whole number from {low}{top}, not {text!r}")
        return value

    return read


def past(text: str) -> float:
    """Return a moment that has been, Unix seconds, of ISO 8601 with an offset from UTC."""
    moment = None
    with contextlib.suppress(ValueError):
        moment = datetime.fromisoformat(text.strip())
    if moment is None or moment.utcoffset() is None:
        raise argparse.ArgumentTypeError(
            f"must be a date and time with its offset, 2026-05-04T10:30+02:00, not {text!r}"
        )
    if moment > datetime.now(UTC):
        raise argparse.ArgumentTypeError(f"{text} has not been yet: give the time of the last picture")
    return moment.timestamp()


def pid(text: str) -> int:
    """Return the number of a process, which the kernel keeps in 31 bits."""
    return whole(1, 2**31 - 1)(text)


def as_text(read: Callable[[str], object]) -> Callable[[str], str]:
    """Return a reader that checks a text and leaves it as it is, for the program that it is passed on to."""

    def checked(text: str) -> str:
        read(text)
        return text

    return checked


def pair(names: str) -> Callable[[str], tuple[float, float]]:
    """Return the reader of two numbers in metres, with these names."""

    def read(text: str) -> tuple[float, float]:
        try:
            first, second = (float(part) for part in text.split(","))
        except ValueError:
            first = second = math.nan
        if not (math.isfinite(first) and math.isfinite(second)):
            raise argparse.ArgumentTypeError(f"must be {names} in metres, not {text!r}")
        return first, second

    return read


place = pair("X,Y")


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Add the options that say whose settings and files a command works with."""
    parser.add_argument("--config", type=path, metavar="FILE", help="settings (TOML); without it every default")
    parser.add_argument("--store", type=path, metavar="DIR", help="folder of the daemon's files")
