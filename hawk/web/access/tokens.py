"""The tokens of roles, people and drones, hashed at rest, and the secret by which the page's cookies are known again.

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
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, TypeVar

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
LARGEST_BYTES: Final = 1024 * 1024
"""Of the file: 2,000 people with ten lots each."""


T = TypeVar("T")


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
class Person:
    """A person with a role for some lots, by their ids, and for nothing else."""

    role: Role
    lots: frozenset[str]
    token: HashedToken


@dataclass(frozen=True, slots=True)
class Tokens:
    """The token of each role that has one, and those of people and drones, by their names."""

    by_role: Mapping[Role, HashedToken] = field(default_factory=dict)
    drones: Mapping[str, HashedToken] = field(default_factory=dict)
    """They prove no role: such a drone sends documents of its surveys, and reads lots."""
    people: Mapping[str, Person] = field(default_factory=dict)
    former: tuple[HashedToken, ...] = ()
    """Those that others took the place of, the newest first: they prove nothing, and to send one is no guess."""

    def __bool__(self) -> bool:
        """Return True when a token is asked for."""
        return bool(self.by_role or self.drones or self.people)

    def role_of(self, given: str, only: Role | None = None) -> Role | None:
        """Return the role for all lots that a token proves. Every token is compared, whatever the first one says.

        Args:
            given: What was sent.
            only: The role that is to be proved; None: any.
        """
        same = [role for role, token in self.by_role.items() if token.is_same(given)]
        return next((role for role in same if only in (None, role)), None)

    def is_or_was_one(self, given: str) -> bool:
        """Return True for a token of anybody, valid or not any more. Every one is compared."""
        people = (person.token for person in self.people.values())
        every = (*self.by_role.values(), *self.drones.values(), *people, *self.former)
        return sum(token.is_same(given) for token in every) > 0

    def drone_of(self, given: str) -> str | None:
        """Return the name of the drone whose token this is. Every one is compared."""
        same = [name for name, token in self.drones.items() if token.is_same(given)]
        return same[0] if same else None

    def person_of(self, given: str, only: Role | None = None) -> str | None:
        """Return the name of the person whose token this is. Every one is compared; ``only``: as `role_of` says."""
        same = [name for name, person in self.people.items() if person.token.is_same(given)]
        return next((name for name in same if only in (None, self.people[name].role)), None)

    def proof(self, role: Role, person: str = "") -> str | None:
        """Return the name of the present token of a role, or of a person with this role."""
        if not person:
            token = self.by_role.get(role)
            return None if token is None else token.proof
        found = self.people.get(person)
        return None if found is None or found.role is not role else found.token.proof

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
        if len(data) > LARGEST_BYTES:
            raise ValueError("it is too large")
        held = json.loads(data)
        found = {Role(name): _read(value) for name, value in held["tokens"].items()}
        drones = {str(name): _read(value) for name, value in held.get("drones", {}).items()}
        people = {str(name): _read_person(value) for name, value in held.get("people", {}).items()}
        former = tuple(_read(value) for value in held.get("former", ()))[:FORMER]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise TokensError(
            f"{path} is damaged ({error}): remove it, then make new tokens with hawk-drone tokens rotate operator"
        ) from error
    return Tokens(found, drones, people, former)


def rotate(path: Path, role: Role) -> str:
    """Give a role a new token, keep its hash in the file, return the token. Raises TokensError, OSError."""
    tokens, (token, hashed) = read_tokens(path), _made()
    _write(path, replace(tokens, by_role={**tokens.by_role, role: hashed}), tokens.by_role.get(role))
    return token


def rotate_drone(path: Path, name: str) -> str:
    """Give a drone a new token as `rotate` does a role. Raises TokensError, for a person's name too, and OSError."""
    tokens, (token, hashed) = read_tokens(path), _made()
    _check_free(tokens.people, "person", name)
    _write(path, replace(tokens, drones={**tokens.drones, name: hashed}), tokens.drones.get(name))
    return token


def rotate_person(path: Path, name: str, role: Role, lots: Collection[str]) -> str:
    """Give a person a new token for these lots alone, as `rotate` does a role.

    Raises TokensError, for a drone's name too, and OSError.
    """
    tokens, (token, hashed) = read_tokens(path), _made()
    _check_free(tokens.drones, "drone", name)
    before, person = tokens.people.get(name), Person(role, frozenset(lots), hashed)
    _write(path, replace(tokens, people={**tokens.people, name: person}), None if before is None else before.token)
    return token


def _check_free(among: Mapping[str, object], kind: str, name: str) -> None:
    """Refuse the name of another one: what is stored names its maker. Raises TokensError."""
    if name in among:
        remedy = f"write another one, or end that first: hawk-drone tokens remove {kind} --name {name!r}"
        raise TokensError(f"--name: a {kind} is called {name!r}: {remedy}")


def remove_drone(path: Path, name: str) -> None:
    """Let the token of a drone open nothing from now on. Raises TokensError, OSError."""
    tokens = read_tokens(path)
    gone = _named(path, tokens.drones, "drone", name)
    _write(path, replace(tokens, drones={each: tokens.drones[each] for each in tokens.drones if each != name}), gone)


def remove_person(path: Path, name: str) -> None:
    """Let the token of a person open nothing from now on. Raises TokensError, OSError."""
    tokens = read_tokens(path)
    gone = _named(path, tokens.people, "person", name).token
    _write(path, replace(tokens, people={each: tokens.people[each] for each in tokens.people if each != name}), gone)


def _named(path: Path, among: Mapping[str, T], kind: str, name: str) -> T:
    """Return what a name has. Raises TokensError, which lists the names that there are."""
    if name not in among:
        names = ", ".join(sorted(among)) or "none"
        raise TokensError(f"--name: no {kind} is called {name!r} in {path}; there are {names}")
    return among[name]


def _made() -> tuple[str, HashedToken]:
    """Return a new token with its hash."""
    token = secrets.token_urlsafe(TOKEN_BYTES)
    made = datetime.now(UTC).isoformat(timespec="seconds")
    return token, HashedToken.of(token, secrets.token_bytes(_SALT_BYTES), made)


def _write(path: Path, tokens: Tokens, replaced: HashedToken | None) -> None:
    """Keep the hashes in the file; ``replaced``: one that proves nothing from now on. Raises TokensError, OSError."""
    gone = () if replaced is None else (replaced,)
    held = {
        "version": 1,
        "tokens": {role.value: _written(hashed) for role, hashed in tokens.by_role.items()},
        "drones": {name: _written(hashed) for name, hashed in tokens.drones.items()},
        "people": {name: _written_person(person) for name, person in tokens.people.items()},
        "former": [_written(each) for each in (*gone, *tokens.former)][:FORMER],
    }
    data = json.dumps(held, indent=2).encode()
    if len(data) > LARGEST_BYTES:
        raise TokensError(f"{path} has no room for more: remove people or drones whom nobody needs any more")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_private(path, data)
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


def _written_person(person: Person) -> dict[str, object]:
    return {"role": person.role.value, "lots": sorted(person.lots), **_written(person.token)}


def _read_person(value: Mapping[str, Any]) -> Person:
    lots = value["lots"]
    if not isinstance(lots, list) or not all(isinstance(each, str) for each in lots):
        raise ValueError("the lots of a person are no list of ids")
    return Person(Role(value["role"]), frozenset(lots), _read(value))


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
