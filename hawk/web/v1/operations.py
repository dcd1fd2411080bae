"""An address of the API: its method, path, parameters, answer and handler. Routes and OpenAPI follow from it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from typing import Any

from aiohttp.typedefs import Handler
from pydantic import BaseModel

from hawk.web.v1.answers import JSON
from hawk.web.v1.parameters import Query
from hawk.web.v1.unknown import PATTERNS


class Bound(Enum):
    """Bound of a role for some lots; the value is the kind of what the path names.

    ``LISTED``: the handler leaves out what is not theirs. ``LINK``: a link's token opens one lot to anybody.
    ``OPEN``: the answer is of no lot.
    """

    LOT = "lot"
    SURVEY = "survey"
    STALL = "stall"
    SHARE = "share"
    CHANGE = "change"
    LISTED = ""
    LINK = "link"
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class Operation:
    """An address. ``path`` begins below `hawk.web.v1.answers.ROOT`; ``tag`` is its group in the documentation.

    ``answer``: type of the answer; None for a file, which is of one of the ``content_types``. ``body_type``: that of
    the body. ``takes_file``: the body is a file, whatever it holds. ``has_tag``: the answer has an ETag.
    ``for_operators``: viewers may not read it. ``for_drones``: drones alone may do it. ``is_open``: a field of the
    path is a link's token, and no login is asked for. ``bound``: as `hawk.web.v1.bounds` keeps it;
    None: a role for some lots may not do it.
    """

    method: str
    path: str
    name: str
    text: str
    tag: str
    handler: Handler
    answer: type[Any] | None
    query: type[Query] = Query
    body: type[BaseModel] | None = None
    body_type: str = JSON
    content_types: tuple[str, ...] = (JSON,)
    takes_file: bool = False
    has_tag: bool = True
    for_operators: bool = False
    for_drones: bool = False
    is_open: bool = False
    bound: Bound | None = None

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
