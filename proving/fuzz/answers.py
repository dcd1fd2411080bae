"""Judges an answer: every refusal names the field, or the reason in the drone's state, and is a sentence."""

from __future__ import annotations

import json
import re
from typing import Any, Final

from hawk.comm.protocol.commands import BadMessageError, parse_command
from proving.fuzz.cases import Case

KINDS: Final = frozenset({"Ack", "Kill Token", "Fence Check", "Route"})
GENERAL: Final = frozenset({"not JSON", "Type", "message"})
"""Names in a refusal besides the fields of the message."""
FIELDS: Final = frozenset(
    {"X", "Y", "Min", "Des", "Max", "Token", "Action", "Corners", "Ceiling", "Latitude", "Longitude"}
)
_FIELD: Final = re.compile(r"(?P<path>[^:\n]{0,200}): (?P<reason>.{8,})", re.DOTALL)
_REMEDY: Final = re.compile(r"\b(should|must|send|leave|add)\b", re.IGNORECASE)
_TOO_LARGE: Final = re.compile(r"message of \d+ bytes is too large: send at most \d+")
LONGEST_REASON: Final = 600


def problem_with(case: Case, answer: dict[str, Any]) -> str:
    """Return what is wrong with an answer to a case, empty when it is as it should be."""
    if answer.get("Type") not in KINDS:
        return f"an answer of type {answer.get('Type')!r}"
    if answer["Type"] != "Ack" or answer["Accepted"]:
        return ""
    reason = str(answer["Reason"])
    if not 5 < len(reason) <= LONGEST_REASON:
        return f"a reason of {len(reason)} characters: {reason[:100]!r}"
    if isinstance(case.message, bytes):
        return "" if reason == "message: is binary; send JSON text" else f"binary was refused by {reason!r}"
    try:
        parse_command(case.message)
    except BadMessageError:
        return _problem_with_refusal(case, reason)
    return "" if reason[-1] in ".:;)" or ":" in reason else f"the reason is no sentence: {reason!r}"


def id_of(message: str | bytes) -> str | int | None:
    """Return the Id that the answer must carry; None where the message has none that can be sent back."""
    try:
        found = json.loads(message).get("Id")
        json.dumps(found, ensure_ascii=False).encode()
    except (ValueError, AttributeError, RecursionError):
        return None
    return found if isinstance(found, str | int) and not isinstance(found, bool) else None


def _problem_with_refusal(case: Case, reason: str) -> str:
    """Return what is wrong with the refusal of a message that is not valid."""
    if _TOO_LARGE.fullmatch(reason):
        return ""
    found = _FIELD.match(reason)
    if found is None:
        return f"the reason names no field: {reason!r}"
    if not _REMEDY.search(found["reason"]):
        return f"the reason names no remedy: {reason!r}"
    path = found["path"]
    names = {path, *path.split("."), path.strip()}
    if names & (GENERAL | case.blamed | _own_names(str(case.message))):
        return ""
    return f"the reason names {path!r}, which is not at fault: {reason!r}"


def _own_names(text: str) -> set[str]:
    """Return the keys of the message; for one of a known type also those that it lacks."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return set()
    if not isinstance(value, dict):
        return set()
    return set(value) | FIELDS
