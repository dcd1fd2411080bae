"""The commands ``hawk-drone tokens rotate`` and ``hawk-drone make-certificate``."""

from __future__ import annotations

import argparse
import sys
from typing import Any, Final
from urllib.parse import quote

from hawk.comm.protocol.authority import Role, cleaned
from hawk.config import options as values
from hawk.config.loader import config_of
from hawk.config.sections import Config, ConfigError
from hawk.web.access.tls import (
    LONGEST_DAYS,
    CertificateError,
    CertificatePlan,
    clock_doubt,
    make_certificate,
    usual_names,
)
from hawk.web.access.tokens import TOKEN_FILE, TokensError, read_tokens, remove_drone, rotate, rotate_drone

COMMANDS: Final = frozenset({"tokens", "make-certificate"})
DRONE: Final = "drone"


def add_access_commands(commands: Any) -> None:
    """Add both commands to the subparsers of the command line."""
    tokens = commands.add_parser(
        "tokens", help="make a new token for a role or a drone: the old one and its logins end"
    )
    tokens.add_argument(
        "work", choices=("rotate", "remove"), help="make a new token and print it once, or remove that of a drone"
    )
    tokens.add_argument("role", choices=[*(role.value for role in Role), DRONE], help="who proves itself by it")
    tokens.add_argument(
        "--name", type=_drone_name, metavar="NAME", help="name of the drone that sends its surveys to this store"
    )
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


def _drone_name(text: str) -> str:
    try:
        return cleaned(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _tokens(options: argparse.Namespace, config: Config) -> int:
    if options.role == DRONE and options.name is None:
        raise ConfigError('--name: is missing: a drone has a name, as "Drone 2"')
    if options.role != DRONE and (options.name is not None or options.work == "remove"):
        raise ConfigError("tokens: roles have no name, and keep a token: rotate it")
    return _rotate_drone(options, config) if options.role == DRONE else _rotate(options, config)


def _rotate_drone(options: argparse.Namespace, config: Config) -> int:
    """Print the token of a drone on standard output, and what it is good for on standard error."""
    path = config.store.directory / TOKEN_FILE
    if options.work == "remove":
        remove_drone(path, options.name)
        _say(f"The token of {options.name} opens nothing any more; its surveys stay.")
        return 0
    if config.web.token is None and Role.OPERATOR not in read_tokens(path).by_role:
        remedy = f"make it first: hawk-drone tokens rotate operator --store {config.store.directory}"
        raise ConfigError(f"tokens: {path} has no operator's token; {remedy}")
    print(rotate_drone(path, options.name))
    _say(f"This is the token of {options.name}. It is shown once; {path} holds its hash only.")
    _say("It sends surveys and pictures to hawk-drone desk, and reads lots there: nothing else.")
    return 0


def _rotate(options: argparse.Namespace, config: Config) -> int:
    """Print the token on standard output, and what it is good for on standard error."""
    path = config.store.directory / TOKEN_FILE
    role = Role(options.role)
    if role is Role.VIEWER and config.web.token is None and Role.OPERATOR not in read_tokens(path).by_role:
        remedy = f"make it first: hawk-drone tokens rotate operator --store {config.store.directory}"
        raise ConfigError(f"tokens: {path} has no operator's token; {remedy}")
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
