"""Types of settings that hold a secret: what prints, dumps or logs one gets a mask, and the value is asked for."""

from __future__ import annotations

import re
import typing
from collections.abc import Iterable, Iterator
from typing import Any, Final
from urllib.parse import unquote

from pydantic import BaseModel, Secret, SecretStr

HIDDEN: Final = "***"
"""Stands for what is not shown."""
_LEAST: Final = 4
"""Characters of the shortest name or password that is searched for in other texts."""
_LEAST_OF_PATH: Final = 8
"""The same for a value of a query and for a path, which are often no secret."""
_LEAST_OF_PART: Final = 12
"""The same for a part of a path: a key that stands between two slashes."""
_NETWORK: Final = re.compile(r"([a-z][a-z0-9+.-]*://)(.*)", re.IGNORECASE | re.DOTALL)
_DEVICES: Final = ("file://", "v4l2://", "rpicam:")
"""Kinds of addresses that name something of this computer, by options that are known."""
_NO_HOST: Final = "hidden"
"""Stands for a host that may as well be part of a password."""
_PIPELINE: Final = "gst:"
_PROPERTY: Final = re.compile(
    r"(?i)\b([\w-]*(?:pw|passw(?:or)?d|passphrase|pwd|token|secret|key|location|uri)\s*=\s*)(\"[^\"]*\"|[^\s&]+)"
)
"""A property of GStreamer, or a value of a query, that is or may hold a secret."""
_IN_TEXT: Final = re.compile(r"(?i)\b(?:https?|rtsps?|rtmps?|srt)://[^\s'\"<>]+")


def shown_address(url: str) -> str:
    """Return kind, host and port of an address; `HIDDEN` for user, password, path and query.

    Cameras and receivers of reports have passwords in any of these. Of a pipeline its elements are shown, and none of
    their properties; a device or a film of this computer is shown whole.
    """
    if url.startswith(_DEVICES):
        return url
    if url.startswith(_PIPELINE):
        elements = (part.split(None, 1) for part in url.removeprefix(_PIPELINE).split("!"))
        return _PIPELINE + " ! ".join(f"{part[0]} {HIDDEN}" if part[1:] else "".join(part[:1]) for part in elements)
    found = _NETWORK.fullmatch(url)
    if found is None:
        return HIDDEN
    user, host, rest = _parts(found[2])
    return f"{found[1]}{HIDDEN + '@' if user else ''}{host}{'/' + HIDDEN if rest.strip('/') else rest}"


def _parts(place: str) -> tuple[str, str, str]:
    """Return user with password, host with port, and what is behind them.

    An @ behind a slash ends a password with a slash; where it may as well belong to the path, nothing is shown.
    """
    authority = re.split(r"[/?#]", place, maxsplit=1)[0]
    user, _, host = authority.rpartition("@")
    behind = place[len(authority) :]
    if user or "@" not in behind or ":" not in host:
        return user, host, behind
    if host.rpartition(":")[2].isdigit():
        return place, _NO_HOST, ""
    user, _, rest = place.rpartition("@")
    host = re.split(r"[/?#]", rest, maxsplit=1)[0]
    return user, host, rest[len(host) :]


class SecretUrl(Secret[str]):
    """An address that may hold a secret: `shown_address` stands for it, `get_secret_value` returns it."""

    def _display(self) -> str:
        return shown_address(self._secret_value)

    @property
    def host(self) -> str:
        """Host with port, without more; "" for an address that names none."""
        found = _NETWORK.fullmatch(self._secret_value)
        return "" if found is None else _parts(found[2])[1]

    def secrets(self) -> Iterator[str]:
        """Yield the parts that nobody else may read, as they are written and as they are meant."""
        url = self._secret_value
        found: list[str] = []
        if url.startswith(_PIPELINE):
            found = [value.strip('"') for _, value in _PROPERTY.findall(url)]
        for address in _IN_TEXT.findall(url):
            user, _, rest = _parts(address.partition("://")[2])
            path, _, query = rest.partition("?")
            values = [part.partition("=")[2] for part in query.split("&")]
            found += [user, user.partition(":")[2]]
            found += [each for each in (rest, path, query, *values) if len(each) >= _LEAST_OF_PATH]
            found += [each for each in path.split("/") if len(each) >= _LEAST_OF_PART]
        yield from (each for each in dict.fromkeys([*found, *map(unquote, found)]) if len(each) >= _LEAST)


def without(text: str, secrets: Iterable[str] = ()) -> str:
    """Return a program's or a library's words with `HIDDEN` for these secrets, and for those of the addresses in it."""
    text = _IN_TEXT.sub(lambda found: shown_address(found[0]), text)
    for each in sorted(secrets, key=len, reverse=True):
        text = text.replace(each, HIDDEN)
    return _PROPERTY.sub(rf"\1{HIDDEN}", text)


def secrets_of(settings: BaseModel) -> list[str]:
    """Return every secret that the settings hold, wherever a field of a secret type stands."""
    return list(dict.fromkeys(_secrets_in(settings)))


def _secrets_in(value: Any) -> Iterator[str]:
    if isinstance(value, SecretUrl):
        yield from value.secrets()
    elif isinstance(value, SecretStr):
        yield value.get_secret_value()
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield from _secrets_in(getattr(value, name))
    elif isinstance(value, list | tuple):
        for each in value:
            yield from _secrets_in(each)


def is_secret(annotation: Any) -> bool:
    """Return True for the type of a field that holds a secret, alone or in a list, an option or a section."""
    if isinstance(annotation, type) and issubclass(annotation, Secret | SecretStr):
        return True
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return any(is_secret(field.annotation) for field in annotation.model_fields.values())
    return any(is_secret(each) for each in typing.get_args(annotation))
