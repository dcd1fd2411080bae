"""The tokens of the roles and of drones, hashed at rest, and the secret by which the page's cookies are known again.

A token that hawk makes has 128 random bits: nobody can try 2**128 of them at any speed of the hash, so a salted SHA-256
is enough, and a guess costs the flight microseconds.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import logging
import secrets
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from pydantic import SecretStr

from hawk.comm.protocol.authority import Role
from hawk.runtime.files import leave_to_owner, write_private

LOG = logging.getLogger(__name__)

TOKEN_FILE: Final = "web-tokens.json"  # noqa: S105 - the file's name
SECRET_FILE: Final = "page-secret"  # noqa: S105 - the file's name
TOKEN_BYTES: Final = 16
FORMER: Final = 16
"""Former tokens that are known again."""
_SECRET_BYTES: Final = 32
_SALT_BYTES: Final = 16
_LARGEST_BYTES: Final = 64 * 1024


class TokensError(Exception):
    """The token file cannot be used; the text names it and the remedy."""


@dataclass(frozen=True, slots=True)
class HashedToken:
    """A token that can be compared and not read."""

    salt: bytes = field(repr=False)
    digest: bytes = field(repr=False)
    made: str = ""
    """Date and time, UTC."""

    @classmethod
    def of(cls, token: str, salt: bytes, made: str = "") -> HashedToken:
        """Return the hash of a token."""
        return cls(salt, _digest(salt, token), made)

    @property
    def proof(self) -> str:
        """Name of this token for what was begun by it; another token has another."""
        return self.digest.hex()

    def is_same(self, token: str) -> bool:
        """Compare in constant time."""
        return hmac.compare_digest(_digest(self.salt, token), self.digest)


@dataclass(frozen=True, slots=True)
class Tokens:
    """The token of each role that has one, and those of drones, by their names."""

    by_role: Mapping[Role, HashedToken] = field(default_factory=dict)
    drones: Mapping[str, HashedToken] = field(default_factory=dict)
    """They prove no role: such a drone sends documents of its surveys, and reads lots."""
    former: tuple[HashedToken, ...] = ()
    """Those that others took the place of, the newest first: they prove nothing, and to send one is no guess."""

    def __bool__(self) -> bool:
        """Return True when a token is asked for."""
        return bool(self.by_role or self.drones)

    def role_of(self, given: str, only: Role | None = None) -> Role | None:
        """Return the role that a token proves. Every token is compared, whatever the first comparison says.

        Args:
            given: What was sent.
            only: The role that is to be proved; None: any.
        """
        same = [role for role, token in self.by_role.items() if token.is_same(given)]
        return next((role for role in same if only in (None, role)), None)

    def is_or_was_one(self, given: str) -> bool:
        """Return True for a token of any role, valid or not any more. Every one is compared."""
        every = (*self.by_role.values(), *self.drones.values(), *self.former)
        return sum(token.is_same(given) for token in every) > 0

    def drone_of(self, given: str) -> str | None:
        """Return the name of the drone whose token this is. Every one is compared."""
        same = [name for name, token in self.drones.items() if token.is_same(given)]
        return same[0] if same else None

    def proof(self, role: Role) -> str | None:
        """Return the name of a role's present token."""
        token = self.by_role.get(role)
        return None if token is None else token.proof

    def drone_proof(self, name: str) -> str | None:
        """Return the name of a drone's present token."""
        token = self.drones.get(name)
        return None if token is None else token.proof


def read_tokens(path: Path) -> Tokens:
    """Return the tokens of a file, none when there is no file. Raises TokensError."""
    try:
        mode = path.stat().st_mode
        data = path.read_bytes()
    except FileNotFoundError:
        return Tokens()
    except OSError as error:
        raise TokensError(f"{path} cannot be read: {error.strerror}; the daemon's user must own it") from error
    if mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise TokensError(f"{path} can be written by others: chmod 600 {path}")
    try:
        if len(data) > _LARGEST_BYTES:
            raise ValueError("it is too large")
        held = json.loads(data)
        found = {Role(name): _read(value) for name, value in held["tokens"].items()}
        drones = {str(name): _read(value) for name, value in held.get("drones", {}).items()}
        former = tuple(_read(value) for value in held.get("former", ()))[:FORMER]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise TokensError(
            f"{path} is damaged ({error}): remove it, then make new tokens with hawk-drone tokens rotate operator"
        ) from error
    return Tokens(found, drones, former)


def rotate(path: Path, role: Role) -> str:
    """Give a role a new token, keep its hash in the file, return the token. Raises TokensError, OSError."""
    tokens, (token, hashed) = read_tokens(path), _made()
    _write(path, replace(tokens, by_role={**tokens.by_role, role: hashed}), tokens.by_role.get(role))
    return token


def rotate_drone(path: Path, name: str) -> str:
    """Give a drone a new token as `rotate` does a role. Raises TokensError, OSError."""
    tokens, (token, hashed) = read_tokens(path), _made()
    _write(path, replace(tokens, drones={**tokens.drones, name: hashed}), tokens.drones.get(name))
    return token


def remove_drone(path: Path, name: str) -> None:
    """Let the token of a drone open nothing from now on. Raises TokensError, OSError."""
    tokens = read_tokens(path)
    if name not in tokens.drones:
        names = ", ".join(sorted(tokens.drones)) or "none"
        raise TokensError(f"--name: no drone is called {name!r} in {path}; there are {names}")
    left = {each: token for each, token in tokens.drones.items() if each != name}
    _write(path, replace(tokens, drones=left), tokens.drones[name])


def _made() -> tuple[str, HashedToken]:
    """Return a new token with its hash."""
    token = secrets.token_urlsafe(TOKEN_BYTES)
    made = datetime.now(UTC).isoformat(timespec="seconds")
    return token, HashedToken.of(token, secrets.token_bytes(_SALT_BYTES), made)


def _write(path: Path, tokens: Tokens, replaced: HashedToken | None) -> None:
    """Keep the hashes in the file; ``replaced``: one that proves nothing from now on."""
    gone = () if replaced is None else (replaced,)
    held = {
        "version": 1,
        "tokens": {role.value: _written(hashed) for role, hashed in tokens.by_role.items()},
        "drones": {name: _written(hashed) for name, hashed in tokens.drones.items()},
        "former": [_written(each) for each in (*gone, *tokens.former)][:FORMER],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    write_private(path, json.dumps(held, indent=2).encode())
    leave_to_owner(path)


def with_configured(kept: Tokens, configured: SecretStr | None, salt: bytes) -> Tokens:
    """Return the tokens of the file; without an operator's token there, `web.token` is that one.

    Args:
        kept: Tokens of the file.
        configured: `web.token`.
        salt: A secret of this installation, so that logins outlive a restart.
    """
    if configured is None:
        return kept
    ours = HashedToken.of(configured.get_secret_value(), salt)
    if Role.OPERATOR in kept.by_role:
        LOG.warning("web.token is not in use: the token file has an operator's token; remove web.token")
        return replace(kept, former=(*kept.former, ours))
    return replace(kept, by_role={**kept.by_role, Role.OPERATOR: ours})


def _digest(salt: bytes, token: str) -> bytes:
    return hashlib.sha256(salt + token.encode("utf-8", "surrogatepass")).digest()


def _written(token: HashedToken) -> dict[str, str]:
    return {"salt": token.salt.hex(), "sha256": token.digest.hex(), "made": token.made}


def _read(value: Mapping[str, str]) -> HashedToken:
    digest = bytes.fromhex(value["sha256"])
    if len(digest) != hashlib.sha256().digest_size:
        raise ValueError("a hash is cut off")
    return HashedToken(bytes.fromhex(value["salt"]), digest, str(value.get("made", "")))


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
