"""Removes secrets from texts that leave the computer."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final
from urllib.parse import unquote

from hawk.config.reference import HIDDEN
from hawk.config.sections import Config

_LEAST: Final = 4
"""Characters of the shortest secret that is searched for by itself."""
_LEAST_OF_QUERY: Final = 8
"""The same for a value of a camera's query, which is often no secret."""
_PARAMETER: Final = re.compile(
    r"(?i)\b((?:[\w-]*(?:token|passw(?:or)?d|passphrase|pwd|user-pw|secret|cookie|api[_-]?key|authorization))[\"']?\s*[=:]\s*"
    r"(?:bearer\s+|basic\s+)?[\"']?)([^\s\"'&;,}]+)"
)
"""``token=...`` and the like: the value goes."""
_AFTER_TOKEN: Final = re.compile(r"(?i)(token\b.{0,60}?)(?<![A-Za-z0-9_-])([A-Za-z0-9_-]{20,})")
"""A word of 20 or more characters of base64url after "token"."""
_USER_IN_ADDRESS: Final = re.compile(r"://[^/\s@]+@")
_USER_WITH_SLASH: Final = re.compile(r"(://)[^\s\"']*:[^\s\"']*@")
_QUERY: Final = re.compile(r"(\b[a-z]{2,10}://[^\s\"'?]+\?)[^\s\"']+")
_KEY: Final = re.compile(r"-----BEGIN [^-]*(?:KEY|CERTIFICATE)-----.*?(?:-----END [^-]*-----|\Z)", re.DOTALL)


class SecretFilter:
    """Hides what looks like a secret, and what the settings say is one."""

    def __init__(self, known: Iterable[str] = ()) -> None:
        """``known``: secrets, hidden wherever they stand."""
        self._known = sorted({each for each in known if len(each) >= _LEAST}, key=len, reverse=True)

    def clean(self, text: str) -> str:
        """Return the text without secrets."""
        for each in self._known:
            text = text.replace(each, HIDDEN)
        text = _KEY.sub(HIDDEN, text)
        text = _USER_IN_ADDRESS.sub(f"://{HIDDEN}@", text)
        text = _USER_WITH_SLASH.sub(rf"\1{HIDDEN}@", text)
        text = _QUERY.sub(rf"\1{HIDDEN}", text)
        text = _PARAMETER.sub(rf"\1{HIDDEN}", text)
        previous = ""
        while previous != text:  # every word after "token", not the first alone
            previous, text = text, _AFTER_TOKEN.sub(rf"\1{HIDDEN}", text)
        return text


def known_secrets(config: Config) -> list[str]:
    """Return the secrets of the settings: the token, and user, password and query of the camera's address."""
    url = config.camera.url
    found = [] if config.web.token is None else [config.web.token]
    for user in re.findall(r"://([^\s\"']*)@", url):
        name, colon, password = user.partition(":")
        found += [user, password if colon else name]
    for query in re.findall(r"\?([^\s\"']+)", url):
        values = (part.partition("=")[2] for part in query.split("&"))
        found += [query, *(value for value in values if len(value) >= _LEAST_OF_QUERY)]
    found += [value for _, value in _PARAMETER.findall(url)]
    return [*found, *map(unquote, found)]
