"""The commands ``hawk-drone tokens`` and ``hawk-drone make-certificate``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from hawk.comm.protocol.authority import Role, cleaned
from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.config.sections import Config, ConfigError
from hawk.lots.storage.commands import reading_there
from hawk.runtime.late import late
from hawk.web.access.tls import (
    LONGEST_DAYS,
    CertificateError,
    CertificatePlan,
    clock_doubt,
    make_certificate,
    usual_names,
)
from hawk.web.access.tokens import (
    TOKEN_FILE,
    Person,
    TokensError,
    read_tokens,
    remove_drone,
    remove_person,
    rotate,
    rotate_drone,
    rotate_person,
)

if TYPE_CHECKING:  # SQLAlchemy is loaded for the command that reads lots
    from hawk.lots import names, store
    from hawk.lots import values as lot_values
else:
    names, store, lot_values = (late(f"hawk.lots.{name}") for name in ("names", "store", "values"))

COMMANDS: Final = frozenset({"tokens", "make-certificate"})
DRONE: Final = "drone"
PERSON: Final = "person"
_NAMES: Final = {DRONE: "Drone 2", PERSON: "Ada"}
_LIST: Final = "list"
_WORKS: Final = ("rotate", "remove", _LIST)


def add_access_commands(commands: Any) -> None:
    """Add both commands to the subparsers of the command line."""
    tokens = commands.add_parser(
        "tokens", help="make a new token for a role, a person or a drone: the old one and its logins end"
    )
    tokens.add_argument(
        "work", choices=_WORKS, help="make a new token and print it once, remove that of a person or drone, or list all"
    )
    tokens.add_argument(
        "role", nargs="?", choices=[*(role.value for role in Role), PERSON, DRONE], help="who proves itself by it"
    )
    tokens.add_argument(
        "--name", type=_person_name, metavar="NAME",
        help="name of the person, or of the drone that sends its surveys to this store",
    )  # fmt: skip
    tokens.add_argument("--role", dest="of_role", choices=[role.value for role in Role], help="role of the person")
    tokens.add_argument(
        "--lot", action="append", type=values.some, metavar="LOT",
        help="name or id of a lot that the role is for, as often as needed",
    )  # fmt: skip
    tokens.set_defaults(action_of=_tokens)
    certificate = commands.add_parser("make-certificate", help="make a self-signed certificate for the page (HTTPS)")
    certificate.add_argument(
        "--name",
        action="append",
        type=values.some,
        metavar="NAME",
        help="host name or address of the page, as often as needed",
    )
    certificate.add_argument("--out", type=values.path, metavar="DIR", help="folder of both files (default: the store)")
    certificate.add_argument(
        "--days", type=values.whole(1, LONGEST_DAYS), default=LONGEST_DAYS, metavar="N", help=f"1 to {LONGEST_DAYS}"
    )
    certificate.add_argument("--replace", action="store_true", help="replace files that are there")
    certificate.set_defaults(action_of=_make_certificate)
    for parser in (tokens, certificate):
        parser.set_defaults(action=_run)
        values.add_settings(parser)


def _run(options: argparse.Namespace) -> int:
    config = config_of(options)
    try:
        return int(options.action_of(options, config))
    except (TokensError, CertificateError) as error:
        raise ConfigError(str(error)) from error
    except OSError as error:
        given = getattr(options, "out", None)
        field, folder = ("store.directory", config.store.directory) if given is None else ("--out", given)
        words = f"{error.filename or folder} cannot be used: {error.strerror or error}"
        raise ConfigError(f"{field}: {words}; name a folder that this user may write") from error


def _person_name(text: str) -> str:
    try:
        return cleaned(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _tokens(options: argparse.Namespace, config: Config) -> int:
    if options.work == _LIST:
        return _list(options, config)
    if options.role is None:
        raise ConfigError(f"tokens: say whose token: {', '.join([*(role.value for role in Role), PERSON, DRONE])}")
    if options.role in (PERSON, DRONE) and options.name is None:
        raise ConfigError(f"--name: is missing: a {options.role} has a name, as {_NAMES[options.role]!r}")
    if options.role not in (PERSON, DRONE) and (options.name is not None or options.work == "remove"):
        raise ConfigError("tokens: roles have no name, and keep a token: rotate it")
    for option, value in (("--role", options.of_role), ("--lot", options.lot)):
        is_asked = options.role == PERSON and options.work == "rotate"
        if value is None and is_asked:
            raise ConfigError(f"{option}: is missing: say the person's role, and each lot that it is for")
        if value is not None and not is_asked:
            raise ConfigError(f"{option}: only with tokens rotate person")
    work = {PERSON: _rotate_person, DRONE: _rotate_drone}.get(options.role, _rotate)
    return work(options, config)


def _check_operator(config: Config) -> Path:
    """Return the token file, in which the operator comes first. Raises ConfigError, TokensError."""
    path = config.store.directory / TOKEN_FILE
    if config.web.token is None and Role.OPERATOR not in read_tokens(path).by_role:
        remedy = f"make it first: hawk-drone tokens rotate operator --store {config.store.directory}"
        raise ConfigError(f"tokens: {path} has no operator's token; {remedy}")
    return path


def _rotate_person(options: argparse.Namespace, config: Config) -> int:
    """Print the token of a person on standard output, and what it is good for on standard error."""
    path = config.store.directory / TOKEN_FILE
    if options.work == "remove":
        remove_person(path, options.name)
        _say(f"The token of {options.name} opens nothing any more, and its logins end within seconds.")
        return 0
    path, lots = _check_operator(config), _lots_named(config, options.lot)
    before, role = read_tokens(path).people.get(options.name), Role(options.of_role)
    token = rotate_person(path, options.name, role, lots)
    print(token)
    _say(f"This is the token of {options.name}. It is shown once; {path} holds its hash only.")
    _say(f"It is that of the role {role.value} for {', '.join(sorted(lots.values()))}: for nothing else.")
    if before is not None and (before.role, before.lots) != (role, frozenset(lots)):
        _say(f"Before it was {before.role.value} for {_lots_of(_names_shown(config, sorted(before.lots)), before)}.")
    _say(f"Log in on {address(config)}, or open {address(config)}?token={quote(token, safe='')}")
    return 0


def _lots_named(config: Config, given: Sequence[str]) -> dict[str, str]:
    """Return ids and names of lots that a person wrote by name or id. Raises ConfigError."""
    try:
        with reading_there(_store_of(config)) as connection:
            return names.names_of(connection, [names.lot_named(connection, each) for each in given])
    except lot_values.LotStoreError as error:
        raise ConfigError(str(error).replace("LOT: ", "--lot: ")) from error


def _store_of(config: Config) -> Path:
    return store.lots_file(config.store.directory, config.store.lots)


def _list(options: argparse.Namespace, config: Config) -> int:
    """Print who has a token: a line each."""
    for name in ("role", "name", "of_role", "lot"):
        if getattr(options, name) is not None:
            raise ConfigError("tokens list: takes no more than --store or --config: it lists all tokens")
    tokens = read_tokens(config.store.directory / TOKEN_FILE)
    called = _names_shown(config, sorted({lot for person in tokens.people.values() for lot in person.lots}))
    lines = [f"{role.value}, made {token.made}" for role, token in tokens.by_role.items()]
    for name, person in sorted(tokens.people.items()):
        lines.append(f"{PERSON} {name}, {person.role.value} for {_lots_of(called, person)}, made {person.token.made}")
    lines += [f"{DRONE} {name}, made {token.made}" for name, token in sorted(tokens.drones.items())]
    if config.web.token is not None and Role.OPERATOR not in tokens.by_role:
        lines.insert(0, f"{Role.OPERATOR.value}, by web.token")
    print("\n".join(lines) or "no token")
    return 0


def _lots_of(called: Mapping[str, str], person: Person) -> str:
    """Return the names of a person's lots; ``called``: names by ids."""
    return ", ".join(sorted(called.get(lot, f"{lot} (not there)") for lot in person.lots)) or "no lot"


def _names_shown(config: Config, lots: Sequence[str]) -> Mapping[str, str]:
    """Return the names of lots by their ids; of a store that cannot be read the ids stand for them."""
    try:
        with reading_there(_store_of(config)) as connection:
            return names.names_of(connection, lots)
    except lot_values.LotStoreError as error:
        if lots:
            _say(str(error))
        return {lot: lot for lot in lots}


def _rotate_drone(options: argparse.Namespace, config: Config) -> int:
    """Print the token of a drone on standard output, and what it is good for on standard error."""
    path = config.store.directory / TOKEN_FILE
    if options.work == "remove":
        remove_drone(path, options.name)
        _say(f"The token of {options.name} opens nothing any more; its surveys stay.")
        return 0
    path = _check_operator(config)
    print(rotate_drone(path, options.name))
    _say(f"This is the token of {options.name}. It is shown once; {path} holds its hash only.")
    _say("It sends surveys and pictures to hawk-drone desk, and reads lots there: nothing else.")
    return 0


def _rotate(options: argparse.Namespace, config: Config) -> int:
    """Print the token on standard output, and what it is good for on standard error."""
    path = config.store.directory / TOKEN_FILE
    role = Role(options.role)
    if role is Role.VIEWER:
        _check_operator(config)
    token = rotate(path, role)
    print(token)
    _say(f"This is the token of the role {role.value}. It is shown once; {path} holds its hash only.")
    _say("A daemon that runs takes it within seconds, and ends the logins of the old one.")
    _say(f"Log in on {address(config)}, or open {address(config)}?token={quote(token, safe='')}")
    if role is Role.OPERATOR and config.web.token is not None:
        _say("web.token is not in use any more: remove it from the settings.")
    return 0


def _make_certificate(options: argparse.Namespace, config: Config) -> int:
    folder = options.out or config.store.directory
    names = options.name or usual_names(config.web)
    made = make_certificate(CertificatePlan(folder, tuple(names), options.days, replace=options.replace))
    print(f"fingerprint (SHA-256): {made.fingerprint}")
    if doubt := clock_doubt():
        _say(doubt)
    _say(f"Names: {', '.join(names)}")
    _say("Write this into the settings, section [web], and start the daemon again:")
    _say(f'tls_certificate = "{made.certificate}"\ntls_key = "{made.key}"')
    _say("A browser warns of a self-signed certificate: compare the fingerprint that it shows with this one.")
    return 0


def address(config: Config) -> str:
    """Return the address of the page by the settings; of a daemon on all interfaces, that on this computer."""
    host = {"0.0.0.0": "127.0.0.1", "": "127.0.0.1", "::": "::1"}.get(config.web.host, config.web.host)  # noqa: S104
    shown = f"[{host}]" if ":" in host else host
    return f"{'http' if config.web.tls_certificate is None else 'https'}://{shown}:{config.web.port}/"


def _say(text: str) -> None:
    print(text, file=sys.stderr)
