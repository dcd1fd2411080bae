"""An address of the API: its method, path, parameters, answer and handler. Routes and OpenAPI follow from it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from aiohttp.typedefs import Handler
from pydantic import BaseModel

from hawk.web.v1.answering import JSON
from hawk.web.v1.asked import Query

PATTERNS: Final = {
    "id": "[0-9a-f-]{36}",
    "version": "[0-9]{1,9}",
    "seq": "[0-9]{1,9}",
    "name": r"[0-9TZ-]{16,24}\.mcap",
    "collection": "lots|stalls|surveys",
    "survey": "[0-9a-f-]{36}",
    "token": "[A-Za-z0-9_-]{8,64}",
    "preview": "[0-9a-f]{32}",
}
"""Patterns of the fields of paths."""


@dataclass(frozen=True, slots=True)
class Operation:
    """An address. ``path`` begins below `hawk.web.v1.answering.ROOT`; ``tag`` is its group in the documentation.

    ``takes_file``: the body is a file, whatever it holds. ``is_open``: a field of the path is a link's token, and no
    login is asked for.
    """

    method: str
    path: str
    name: str
    text: str
    tag: str
    handler: Handler
    answer: type[BaseModel] | None
    query: type[Query] = Query
    body: type[BaseModel] | None = None
    content_type: str = JSON
    takes_file: bool = False
    is_open: bool = False

    @property
    def is_change(self) -> bool:
        """True when only operators may do it."""
        return self.method != "GET"

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the path's fields."""
        return tuple(re.findall(r"\{(\w+)\}", self.path))

    @property
    def route(self) -> str:
        """The path as aiohttp's router takes it."""
        return re.sub(r"\{(\w+)\}", lambda found: f"{{{found[1]}:{PATTERNS[found[1]]}}}", self.path)
