"""Writing a small file so that a crash leaves the old one or the new one, whole."""

from __future__ import annotations

import logging
import os
import secrets
from pathlib import Path
from typing import Final


def write_atomically(path: Path, text: str) -> None:
    """Write the file durably; its folder is made when there is none. Blocks on the disk. Raises OSError."""
    temporary = path.with_name(f".{path.name}.new")
    path.parent.mkdir(parents=True, exist_ok=True)
    with temporary.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
    _sync_folder(path.parent)


def set_aside(path: Path, suffix: str) -> None:
    """Rename the file durably, so that nothing of it is lost; a file that is not there is no error. Raises OSError."""
    try:
        path.replace(path.with_name(f"{path.name}.{suffix}"))
    except FileNotFoundError:
        return
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


LOG = logging.getLogger(__name__)

ADDRESS_FILE: Final = "page-address"
SECRET_FILE: Final = "page-secret"  # noqa: S105 - the file's name
_SECRET_BYTES: Final = 32


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


def cookie_secret(folder: Path) -> bytes:
    """Return the secret kept in this folder; made when there is none. Pages stay known after a restart by it."""
    path = folder / SECRET_FILE
    try:
        kept = path.read_bytes()
    except OSError:
        kept = b""
    if len(kept) == _SECRET_BYTES:
        return kept
    made = secrets.token_bytes(_SECRET_BYTES)
    try:
        write_private(path, made)
    except OSError as error:
        LOG.warning("%s: %s; pages have to send the token again after a restart", path, error)
    return made


def shown_address(url: str, page_url: str, folder: Path, *, on_terminal: bool) -> str:
    """Return what may be printed for the one who opens the page.

    An address with the token goes to a terminal, or into a file that only this user may read: a journal keeps what is
    printed, and others may read it.
    """
    if page_url == url or on_terminal:
        return page_url
    path = folder / ADDRESS_FILE
    try:
        write_private(path, f"{page_url}\n".encode())
    except OSError as error:
        return f"{url} with ?token= and web.token; {path} cannot be written: {error}"
    return f"the address in {path} ({url} with the token)"
