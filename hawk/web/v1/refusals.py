"""Reasons why a request is refused, with status, field and remedy."""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus
from typing import Final

from aiohttp import web
from pydantic import ValidationError

from hawk.comm.protocol.authority import Role
from hawk.lots.values import (
    DAMAGED,
    BeingEditedError,
    ErasedError,
    LotInputError,
    LotStoreError,
    NotFoundError,
    OtherDroneError,
    StoreBusyError,
    StoreFullError,
    utc,
)
from hawk.store.recordings import NotThatRecordingError
from hawk.web.access.access import ACCESS


class RefusedError(Exception):
    """A request is refused: ``status`` of HTTP, the ``field`` that is meant, the ``reason`` with the remedy.

    ``more``: further values of the answer.
    """

    def __init__(self, status: int, field: str, reason: str, more: Mapping[str, str] | None = None) -> None:
        super().__init__(f"{field}: {reason}")
        self.status = status
        self.field = field
        self.reason = reason
        self.more = more or {}


REFUSALS: Final = (RefusedError, LotStoreError, NotThatRecordingError, ValidationError)
"""Errors that `refusal_of` explains, besides those of the disk."""


def refusal_of(error: Exception) -> RefusedError:
    """Return the refusal that one of `REFUSALS` or OSError means: 422 for a value, 404 for an id, 409 for a store.

    503 for one that is busy, 507 for one whose disk is full.
    """
    match error:
        case RefusedError():
            return error
        case LotInputError():
            return RefusedError(web.HTTPUnprocessableEntity.status_code, error.field, error.reason)
        case NotFoundError():
            return RefusedError(web.HTTPNotFound.status_code, *_named(error))
        case OtherDroneError():
            return RefusedError(web.HTTPForbidden.status_code, *_of(error))
        case ErasedError():
            return RefusedError(web.HTTPGone.status_code, *_of(error))
        case StoreBusyError():
            return RefusedError(web.HTTPServiceUnavailable.status_code, "", str(error))
        case StoreFullError():
            return RefusedError(HTTPStatus.INSUFFICIENT_STORAGE, "", str(error))
        case BeingEditedError():
            more = {"who": error.who, "since": utc(error.since)}
            return RefusedError(web.HTTPConflict.status_code, *_named(error), more)
        case NotThatRecordingError():
            is_gone = "there is no recording" in str(error)
            name, _, reason = str(error).partition(": ")
            return RefusedError((web.HTTPNotFound if is_gone else web.HTTPConflict).status_code, name, reason)
        case ValidationError():  # of an answer: bodies are refused by their fields before
            return RefusedError(web.HTTPConflict.status_code, "", DAMAGED)
        case OSError():
            words = f"{error.strerror or error}: look at the disk"
            return RefusedError(web.HTTPConflict.status_code, "recordings", words)
    return RefusedError(web.HTTPConflict.status_code, *_named(error))


def _named(error: Exception) -> tuple[str, str]:
    field, separator, reason = str(error).removeprefix("--").partition(": ")
    is_field = bool(separator) and field.isidentifier()
    return (field, reason) if is_field else ("", str(error))


def _of(error: Exception) -> tuple[str, str]:
    """Return the field of a document that an error names, and the reason."""
    field, _, reason = str(error).partition(": ")
    return field, reason


def check_operator(request: web.Request, words: str) -> None:
    """Refuse a viewer. Raises HTTPForbidden with the words."""
    access = request.get(ACCESS)
    if access is not None and access.role is not Role.OPERATOR:
        raise web.HTTPForbidden(text=words)
