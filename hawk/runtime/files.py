"""Writing a small file: a crash leaves the old one or the new one, whole; a private one is its owner's alone."""

from __future__ import annotations

import os
from pathlib import Path


def write_atomically(path: Path, text: str) -> None:
    """Write the file durably; its folder is made when there is none. Blocks on the disk. Raises OSError."""
    temporary = path.with_name(f".{path.name}.new")
    path.parent.mkdir(parents=True, exist_ok=True)
    with temporary.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
    sync_folder(path.parent)


def replace_whole(path: Path, data: bytes) -> Path:
    """Write a file that a person can make again: whole, or the old one stays; return its path. Raises OSError."""
    unfinished = path.with_name(f".{path.name}.part")
    try:
        unfinished.write_bytes(data)
        unfinished.replace(path)
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise
    return path


def set_aside(path: Path, suffix: str) -> None:
    """Rename the file durably, so that nothing of it is lost; a file that is not there is no error. Raises OSError."""
    try:
        path.replace(path.with_name(f"{path.name}.{suffix}"))
    except FileNotFoundError:
        return
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Put the names of a folder's files on the disk. Raises OSError."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def write_private(path: Path, data: bytes) -> None:
    """Write the file with mode 0600, whole or not at all. Raises OSError."""
    partial = path.with_name(f".{path.name}.new")
    partial.unlink(missing_ok=True)
    with os.fdopen(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(data)
    partial.replace(path)


def leave_to_owner(path: Path) -> None:
    """Leave a file that root wrote to the user whose folder it is in: the daemon reads it. Raises OSError."""
    if os.geteuid() == 0:
        owner = path.parent.stat()
        os.chown(path, owner.st_uid, owner.st_gid)
