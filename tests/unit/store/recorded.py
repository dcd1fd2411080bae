"""Recordings of surveys, as a drone writes them."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.ring_buffer import Item


def recorded(path: Path, journal: str, seconds: Iterable[int] = (20, 95), words: str = "", **more: str) -> bytes:
    """Write a recording of a survey's journal, with a tick of some words at each second; return its bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    head = start_metadata({"survey": journal, **more}, datetime(2026, 5, 1, 10, tzinfo=UTC), 10.0)
    file = RecordingFile(path.open("wb"), head, dict)
    for each in seconds:
        file.write(Item("tick", {"words": words, "number": each} if words else {}, "json", each * 1_000_000_000, 1))
    file.close()
    return path.read_bytes()
