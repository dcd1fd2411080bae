"""The command ``hawk-drone map --watch``: runs an inbox until it is stopped."""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import json
import os
import signal
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hawk.config.sections import ConfigError
from hawk.picture.inbox.app import Inbox, InboxNotice, Surroundings
from hawk.picture.inbox.flights import FlightReader
from hawk.picture.inbox.folder import SETTLE_S, Folder
from hawk.picture.inbox.journal import FILE, Journal
from hawk.picture.inbox.map_process import MapProcess
from hawk.picture.values import PictureError
from hawk.runtime.late import late

if TYPE_CHECKING:  # an inbox that has nothing to do keeps little memory
    from hawk.picture import ingest, sources
else:
    ingest = late("hawk.picture.ingest")
    sources = late("hawk.picture.sources")

LOOKS: Final = 6
"""Looks at the folder while a drop settles."""
MOST_LOOK_S: Final = 20.0
_LOCK: Final = "inbox.lock"


def watch(options: argparse.Namespace, passed_on: Mapping[str, str]) -> int:
    """Map what arrives until SIGTERM or Ctrl-C; return the exit status.

    ``passed_on``: options for the mapping of flights by name. Raises ConfigError where folder or store cannot be used.
    """
    stop = threading.Event()
    settle_s = SETTLE_S if options.settle is None else options.settle
    with _locked(options.store) as lock, _stopped_by_signals(stop):
        try:
            lens = None if options.calibration is None else sources.calibration_of(options.calibration)
            reader = FlightReader(options.watch, options.lenses, lens)
        except PictureError as error:
            raise ConfigError(str(error)) from error
        around = Surroundings(
            mapper=MapProcess(options.store, passed_on, stop, lock),
            has_survey=lambda survey: ingest.has_survey(options.store, survey),
            say=partial(_say, as_json=options.json),
            now=time.time,
        )
        try:
            with Journal(options.store) as journal:
                folder = Folder(options.watch, settle_s)
                inbox = Inbox(folder, options.store, journal, reader, around)
                _say(InboxNotice("", "watches", f"{options.watch} into {options.store}"), as_json=options.json)
                while not stop.is_set():
                    if not inbox.step(time.monotonic()):
                        stop.wait(min(settle_s / LOOKS, MOST_LOOK_S))
        except sqlite3.Error as error:
            words = f"{options.store / FILE} {error}; see that the disk is whole and has room"
            raise ConfigError(f"--store: {words}") from error
        except OSError as error:
            words = f"{error.filename or options.watch} {error.strerror or error}; let hawk write in {options.watch}"
            raise ConfigError(f"--watch: {words}") from error
    return 0


@contextlib.contextmanager
def _locked(store: Path) -> Iterator[int]:
    """Keep other inboxes off a store. A mapping that outlives its inbox keeps the lock. Raises ConfigError."""
    try:
        descriptor = os.open(store / _LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise ConfigError(f"--store: {store / _LOCK}: {error.strerror}; let hawk write in that folder") from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield descriptor
    except BlockingIOError:
        raise ConfigError(
            f"--store: another inbox, or a mapping that it began, works on {store}: end it, or name another store"
        ) from None
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def _stopped_by_signals(stop: threading.Event) -> Iterator[None]:
    """Have SIGTERM and SIGINT end the work: what is under way goes on at the next start."""
    former = {number: signal.signal(number, lambda *_: stop.set()) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


def _say(event: InboxNotice, *, as_json: bool) -> None:
    if as_json:
        print(
            json.dumps({"event": "inbox", "flight": event.flight, "outcome": event.outcome, "text": event.words}),
            flush=True,
        )
        return
    named = f"{event.flight}: " if event.flight else ""
    print(f"{named}{event.outcome}: {event.words}", flush=True)
