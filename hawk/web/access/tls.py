"""Certificate and key of the web server: read, tried out, and judged before anything starts."""

from __future__ import annotations

import asyncio
import hashlib
import logging
import math
import ssl
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from hawk.config.sections import ConfigError, WebSettings
from hawk.model.sentences import say

LOG = logging.getLogger(__name__)

WARN_DAYS: Final = 30.0
"""Days before its end from which a certificate is reported."""
DAY_S: Final = 86_400.0
_EXPIRED: Final = 10
_NOT_YET_VALID: Final = 9
"""Codes of X509_verify_cert (openssl-verification-options(1))."""
_ROUNDS: Final = 8
"""Exchanges in which a handshake is done; TLS needs three."""


@dataclass(frozen=True, slots=True)
class Tls:
    """Context of the listener, and the facts of its certificate."""

    context: ssl.SSLContext
    fingerprint: str
    """SHA-256 of the certificate, as browsers show it."""
    ends: float | None
    """End of its validity, seconds since 1970; None while it is not valid yet."""
    is_self_signed: bool

    def days_left(self, wall: float) -> float:
        """Return the days until the certificate ends; infinite when its end is not known."""
        return math.inf if self.ends is None else (self.ends - wall) / DAY_S

    def warning(self, wall: float) -> str:
        """Return what is to be reported of the certificate; empty when nothing is."""
        if self.ends is None:
            return say("The certificate is not valid yet by this computer's clock: browsers may refuse it.")
        days = self.days_left(wall)
        if days > WARN_DAYS:
            return ""
        return say(
            "The certificate of the page ends in {days:.0f} days: replace web.tls_certificate.", days=max(0.0, days)
        )


def load_tls(settings: WebSettings, *, in_flight: bool = False) -> Tls | None:
    """Return the certificate and key of the settings, None when there are none.

    The server shakes hands with itself in memory, which proves the pair and reads the certificate.

    ``in_flight``: a certificate that has expired is reported and served: a clock that stepped lets nobody fly alone.

    Raises:
        ConfigError: A file cannot be used; the text names the setting and the remedy.
    """
    if settings.tls_certificate is None or settings.tls_key is None:
        return None
    certificate, key = settings.tls_certificate, settings.tls_key
    for name, path in (("tls_certificate", certificate), ("tls_key", key)):
        try:
            path.read_bytes()
        except OSError as error:
            raise ConfigError(f"web.{name}: {path} cannot be read: {error.strerror}") from error
    _refuse_open_key(key)
    context = _server_context(certificate, key)
    found = _tried(context, certificate, in_flight=in_flight)
    if found.ends is None:
        LOG.warning("web.tls_certificate: %s is not valid yet by this computer's clock", certificate)
    return found


async def watch_certificate(tls: Tls, wall: Callable[[], float], report: Callable[[str], None]) -> None:
    """Report a certificate that will end, at once and then once a day, until cancelled."""
    while True:
        if words := tls.warning(wall()):
            report(words)
        await asyncio.sleep(DAY_S)


def _refuse_open_key(key: Path) -> None:
    mode = key.stat().st_mode
    if mode & 0o007:
        raise ConfigError(f"web.tls_key: everybody may read or write {key}: chmod 600 {key}")


def _server_context(certificate: Path, key: Path) -> ssl.SSLContext:
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.options |= ssl.OP_NO_RENEGOTIATION
    context.set_alpn_protocols(["http/1.1"])
    try:
        context.load_cert_chain(certificate, key, password=_no_pass_phrase)
    except _PassPhraseError as error:
        raise ConfigError(f"web.tls_key: {key} has a pass phrase: write it without one (openssl pkey)") from error
    except ssl.SSLError as error:
        if "MISMATCH" in (error.reason or ""):
            raise ConfigError(f"web.tls_key: {key} is not the key of web.tls_certificate {certificate}") from error
        raise ConfigError(
            f"web.tls_certificate, web.tls_key: {certificate} and {key} cannot be used: {error.reason or error}; "
            "both must be PEM files"
        ) from error
    return context


class _PassPhraseError(Exception):
    """The key asks for a pass phrase."""


def _no_pass_phrase() -> str:
    raise _PassPhraseError


def _tried(context: ssl.SSLContext, certificate: Path, *, in_flight: bool) -> Tls:
    try:
        der, facts = _shake_hands(context, _trusting(certificate))
    except ssl.SSLCertVerificationError as error:
        is_over = error.verify_code == _EXPIRED
        if is_over:
            words = f"web.tls_certificate: {certificate} has expired by this computer's clock"
            remedy = "set the clock if it is wrong; else make another pair with hawk-drone make-certificate --replace"
            words += f" ({datetime.now(UTC):%Y-%m-%d}): {remedy}"
            if not in_flight:
                raise ConfigError(words) from error
            LOG.error("%s. A flight is under way: it is served all the same", words)
        elif error.verify_code != _NOT_YET_VALID:
            reason = error.verify_message
            raise ConfigError(f"web.tls_certificate: {certificate} is no server's certificate: {reason}") from error
        der, facts = _shake_hands(context, _anything())
        if is_over:
            return Tls(context, fingerprint_of(der), 0.0, is_self_signed=True)
    except ssl.SSLError as error:
        raise ConfigError(f"web.tls_certificate: {certificate}: no handshake succeeds: {error.reason}") from error
    ends = float(ssl.cert_time_to_seconds(str(facts["notAfter"]))) if "notAfter" in facts else None
    is_self_signed = not facts or facts.get("issuer") == facts.get("subject")
    return Tls(context, fingerprint_of(der), ends, is_self_signed)


def fingerprint_of(der: bytes) -> str:
    """Return the SHA-256 of a certificate (DER) as browsers show it: pairs of hexadecimal digits with colons."""
    return hashlib.sha256(der).digest().hex(":").upper()


def _trusting(certificate: Path) -> ssl.SSLContext:
    """Return a client that trusts exactly this certificate."""
    client = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    client.check_hostname = False
    client.verify_flags |= ssl.VerifyFlags.VERIFY_X509_PARTIAL_CHAIN
    client.load_verify_locations(certificate)
    return client


def _anything() -> ssl.SSLContext:
    client = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    client.check_hostname = False
    client.verify_mode = ssl.CERT_NONE
    return client


def _shake_hands(server: ssl.SSLContext, client: ssl.SSLContext) -> tuple[bytes, dict[str, Any]]:
    """Return the server's certificate (DER), and its facts when the client checked it. Raises ssl.SSLError."""
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = (server.wrap_bio(to_server, to_client, server_side=True), client.wrap_bio(to_client, to_server))
    open_ends = list(reversed(ends))
    for _ in range(_ROUNDS):
        for end in tuple(open_ends):
            try:
                end.do_handshake()
                open_ends.remove(end)
            except ssl.SSLWantReadError:
                pass
    return ends[1].getpeercert(binary_form=True) or b"", dict(ends[1].getpeercert() or {})
