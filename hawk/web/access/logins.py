"""The table of logins: begun by a token, ended by log-out, by a new token, by idleness or by age.

The cookie holds a random value, the table and its file only the hash of it.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import secrets
from base64 import urlsafe_b64encode
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from hawk.comm.protocol.authority import Role
from hawk.config.sections import WebSettings
from hawk.web.access.tokens import Tokens

LOGIN_LIMIT: Final = 200
"""Logins of one role, or of one person; beyond it the one that was used longest ago ends."""
HOUR_S: Final = 3600.0


@dataclass(slots=True, eq=False)
class Login:
    """One login. Times are real seconds of this process; they may be negative after a restart."""

    key: str
    """SHA-256 of the cookie's value."""
    role: Role
    proof: str
    """Name of the token by which it began."""
    begun: float
    used: float
    person: str = ""
    """Name of the person whose token it is."""
    open: int = 0
    """Connections that are open by it: it is in use."""


class Logins:
    """Logins by the hash of their cookies.

    The login that has control is not ended by time: the drone would lose its operator in the air.
    """

    def __init__(self, settings: WebSettings, monotonic: Callable[[], float], secret: bytes) -> None:
        """``secret``: key of `control_secret`."""
        self._idle_s = settings.session_idle_h * HOUR_S
        self._limit_s = settings.session_limit_h * HOUR_S
        self._monotonic = monotonic
        self._secret = secret
        self._logins: dict[str, Login] = {}
        self.has_control: Callable[[Login], bool] = lambda _: False
        """Returns True for a login whose session is in control of the drone."""
        self.changes = 0
        """Rises with each login that begins or ends."""

    def __len__(self) -> int:
        return len(self._logins)

    def begin(self, role: Role, proof: str, person: str = "") -> str:
        """Begin a login; return the value of its cookie, always a new one."""
        same = [each for each in self._logins.values() if (each.role, each.person) == (role, person)]
        if len(same) >= LOGIN_LIMIT:
            self.end(min(same, key=lambda each: (self.has_control(each), each.open > 0, each.used)))
        value = secrets.token_urlsafe(32)  # 256 random bits
        now = self._monotonic()
        login = Login(_key(value), role, proof, now, now, person)
        self._logins[login.key] = login
        self.changes += 1
        return value

    def find(self, value: str | None, tokens: Tokens) -> Login | None:
        """Return the login of a cookie, and note that it is used; None when there is none, or it has ended."""
        login = None if not value else self._logins.get(_key(value))
        if login is None or not self.is_live(login, tokens):
            return None
        login.used = self._monotonic()
        return login

    def is_live(self, login: Login, tokens: Tokens) -> bool:
        """Return True until the login has ended: then it is forgotten."""
        if self._logins.get(login.key) is not login:
            return False
        is_proved = login.proof == tokens.proof(login.role, login.person)
        if is_proved and (not self._is_over(login) or self.has_control(login)):
            return True
        self.end(login)
        return False

    def end(self, login: Login) -> None:
        """End a login."""
        if self._logins.pop(login.key, None) is not None:
            self.changes += 1

    def sweep(self, tokens: Tokens) -> None:
        """End what is over."""
        now = self._monotonic()
        for login in tuple(self._logins.values()):
            if login.open:
                login.used = now
            self.is_live(login, tokens)

    def control_secret(self, login: Login) -> str:
        """Return the key of the session of control that belongs to a login: a cookie cannot choose it."""
        made = hmac.new(self._secret, f"control {login.key}".encode(), hashlib.sha256).digest()
        return urlsafe_b64encode(made).decode().rstrip("=")

    def _is_over(self, login: Login) -> bool:
        now = self._monotonic()
        is_idle = not login.open and now - login.used > self._idle_s
        return is_idle or now - login.begun > self._limit_s

    # -- over a restart -----------------------------------------------------------------------------------------------

    def to_json(self, wall: float) -> str:
        """Return the table for a file: hashes and ages, no cookie. ``wall``: seconds since 1970."""
        now = self._monotonic()
        kept = [
            {
                "key": each.key,
                "role": each.role.value,
                "proof": each.proof,
                "person": each.person,
                "age_s": round(now - each.begun, 1),
                "idle_s": 0.0 if each.open else round(now - each.used, 1),
            }
            for each in self._logins.values()
        ]
        return json.dumps({"version": 1, "written": wall, "logins": kept}, allow_nan=False)

    def restore(self, text: str, wall: float) -> None:
        """Take the table of an earlier run. Raises ValueError; nothing is taken then.

        A wall clock that was set back in the meantime makes nothing younger.
        """
        try:
            kept = json.loads(text)
            away = max(0.0, wall - float(kept["written"]))
            now = self._monotonic()
            found = [
                Login(
                    str(each["key"]),
                    Role(each["role"]),
                    str(each["proof"]),
                    now - away - max(0.0, float(each["age_s"])),
                    now - away - max(0.0, float(each["idle_s"])),
                    str(each.get("person", "")),
                )
                for each in kept["logins"]
            ]
        except (KeyError, TypeError, AttributeError, RecursionError) as error:
            raise ValueError(f"damaged: {error}") from error
        self._logins.update((each.key, each) for each in found)


def _key(value: str) -> str:
    return hashlib.sha256(value.encode("utf-8", "surrogatepass")).hexdigest()
