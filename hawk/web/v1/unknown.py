"""Refusal of a value in an address: the field of the path that is meant, and where a client finds those that there are.

An address whose id has not the form of one matches no route; the form of its template finds the field.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple

from hawk.exports.formats import CONTENT_TYPES, FEEDS

ROOT: Final = "/api/v1"
"""Address below which every address of this API lies."""
NOTHING: Final = f"there is nothing at this address; GET {ROOT}/openapi.json lists the addresses"
"""Words for an address that this API does not have."""
_FILES: Final = tuple(each.removeprefix(".") for each in CONTENT_TYPES)
PATTERNS: Final = {
    "id": "[0-9a-f-]{36}",
    "version": "[0-9]{1,9}",
    "seq": "[0-9]{1,9}",
    "name": r"[0-9TZ-]{16,24}\.mcap",
    "collection": "lots|stalls|sections|surveys",
    "survey": "[0-9a-f-]{36}",
    "token": "[A-Za-z0-9_-]{8,64}",
    "preview": "[0-9a-f]{32}",
    "number": "[0-9]{1,7}",
    "row": "-?[0-9]{1,6}",
    "column": "-?[0-9]{1,6}",
    "kind": "|".join(map(re.escape, _FILES)),
    "feed": "|".join(FEEDS),
    "file": "[^/]{1,200}",
}
"""Patterns of the fields of paths."""
_FIELD: Final = re.compile(r"\{(\w+)\}")
_NUMBER: Final = "the recording has none of this number"
_SURVEY: Final = "there is no survey of this lot with this id"
WORDS: Final[Mapping[str, str]] = {
    "/lots": f"there is no lot with this id; GET {ROOT}/lots lists them",
    "/surveys": f"there is no survey with this id; GET {ROOT}/surveys lists them",
    "/lots/{id}/surveys": f"{_SURVEY}; GET {ROOT}/lots/{{id}}/surveys lists them",
    "/shared/{token}/surveys": f"{_SURVEY}; GET {ROOT}/shared/{{token}}/statistics/surveys lists them",
    "/stalls": f"there is no stall with this id; GET {ROOT}/lots/{{id}}/stalls lists those of a lot",
    "/lots/{id}/layouts": f"there is no layout with this number; GET {ROOT}/lots/{{id}}/layouts lists them",
    "/changes": f"there is no change with this number; GET {ROOT}/changes lists them",
    "/shares": f"there is no link with this id; GET {ROOT}/lots/{{id}}/shares lists those of a lot",
    "/shared": "this link has ended, or was taken back; ask for another one",
    "/recordings": f"there is no recording with this name; GET {ROOT}/recordings lists them",
    "/surveys/{id}/recordings": "must be the name of a recording, as 20260504T103000Z.mcap",
    "/recordings/{name}/film/pictures": f"{_NUMBER}; GET {ROOT}/recordings/{{name}}/film lists the pictures",
    "/recordings/{name}/film/maps": f"{_NUMBER}; GET {ROOT}/recordings/{{name}}/film lists the maps",
    "/lots/import": f"there is no preview with this id; POST {ROOT}/lots/import makes one",
    "/lots/{id}/plan/import": f"there is no preview with this id; POST {ROOT}/lots/{{id}}/plan/import makes one",
    "/lots/{id}/feeds": f"there is no feed with this name; there are {', '.join(FEEDS)}",
    "/surveys/{id}/ground": f"there is no tile at this place; GET {ROOT}/surveys/{{id}}/ground lists the tiles",
    "/surveys/{id}/ground/{row}": f"there is no tile at this place; GET {ROOT}/surveys/{{id}}/ground lists the tiles",
    "/surveys/{id}/files": f"there is no file of this kind; there are {', '.join(_FILES)}",
    "/inbox": "must be the name of a file, 200 characters at most, without a folder",
    "/features/collections": f"there is no collection with this name; GET {ROOT}/features/collections lists them",
    "/features/collections/{collection}/items": (
        f"there is no feature with this id; GET {ROOT}/features/collections/{{collection}}/items lists them"
    ),
}
"""Template of an address before a field of the path -> what is wrong with the field, and the remedy."""
_KINDS: Final[Mapping[str, tuple[str, ...]]] = {
    "lot": ("/lots",),
    "survey": ("/surveys",),
    "stall": ("/stalls",),
    "layout": ("/layouts",),
    "change": ("/changes",),
    "share": ("/shares", "/shared"),
    "recording": ("/recordings",),
    "feed": ("/feeds",),
    "feature": ("/items",),
    "row": ("/ground",),
    "number": ("/pictures", "/maps"),
}
"""Field of an error of the store -> ends of the templates before the field of the path that is meant."""


class Wrong(NamedTuple):
    """A field of a path, and what is wrong with it."""

    field: str
    reason: str


def wrong_form(path: str, templates: Iterable[str]) -> Wrong | None:
    """Return the first field of a path that has not the form of its values; None where the path fits no template.

    Args:
        path: The address that was asked for, with `ROOT`.
        templates: Those of all addresses of this API, with `ROOT`.
    """
    given = path.split("/")
    fitting = [each for each in templates if _fits(given, each.split("/"))]
    for template in sorted(fitting, key=lambda each: len(_FIELD.findall(each))):
        for part, value in zip(template.split("/"), given, strict=True):
            field = _FIELD.fullmatch(part)
            if field is not None and not re.fullmatch(PATTERNS[field[1]], value):
                return Wrong(field[1], WORDS[_before(template, field[1])])
    return None


def not_there(template: str, kind: str, reason: str) -> Wrong:
    """Return the field of a template that an error of the store means; of another one field and reason stay.

    Args:
        template: That of the address, with `ROOT`.
        kind: Field of the error, as "lot".
        reason: What the error says.
    """
    for field in _FIELD.findall(template):
        before = _before(template, field)
        if before.endswith(_KINDS.get(kind, ())):
            return Wrong(field, WORDS[before] if reason.startswith("there is no") else reason)
    return Wrong(kind, reason)


def _before(template: str, field: str) -> str:
    return template.removeprefix(ROOT).partition(f"/{{{field}}}")[0]


def _fits(given: list[str], template: list[str]) -> bool:
    return len(given) == len(template) and all(
        part == value or (bool(value) and _FIELD.fullmatch(part) is not None)
        for part, value in zip(template, given, strict=True)
    )
