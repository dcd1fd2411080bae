"""Certificate and key of the web server: read, tried out, and judged before anything starts."""

from __future__ import annotations

import asyncio
import hashlib
import ipaddress
import logging
import math
import re
import shutil
import socket
import ssl
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

from hawk.config.sections import ConfigError, WebSettings
from hawk.model.moment import is_wall_clock_kept
from hawk.model.sentences import say
from hawk.runtime.files import leave_to_owner, write_private

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


CERTIFICATE_FILE: Final = "certificate.pem"
KEY_FILE: Final = "certificate-key.pem"
LONGEST_DAYS: Final = 825
"""Apple's limit for certificates that a person trusts by hand (support.apple.com/103769)."""
OPENSSL_S: Final = 60.0
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9.-]{0,252}")
_NOWHERE: Final = ("192.0.2.1", 9)
"""An address that is nobody's (RFC 5737): which of this computer's addresses leads out. Nothing is sent."""


RELEASED: Final = datetime(2026, 11, 29, tzinfo=UTC)
"""Day of the newest release (CHANGELOG.md): a clock that is earlier is wrong."""
_BEFORE: Final = timedelta(days=2)
"""A certificate begins this long before it is made: clocks that are behind by less take it."""


class CertificateError(Exception):
    """No certificate was made; the text gives the reason and the remedy."""


@dataclass(frozen=True, slots=True)
class CertificatePlan:
    """Folder of both files, names and addresses of the page, days until the end."""

    folder: Path
    names: tuple[str, ...]
    days: int = LONGEST_DAYS
    replace: bool = False


@dataclass(frozen=True, slots=True)
class MadeCertificate:
    """Both files, and the SHA-256 of the certificate as browsers show it."""

    certificate: Path
    key: Path
    fingerprint: str


def make_certificate(plan: CertificatePlan, wall: Callable[[], float] = time.time) -> MadeCertificate:
    """Make certificate (mode 0644) and key (0600), and try them out. Raises CertificateError, OSError.

    ``wall``: the clock by which it begins and ends, Unix seconds. One that is earlier than this release is refused: by
    the true time the certificate might be over already.
    """
    now = datetime.fromtimestamp(wall(), UTC)
    if now < RELEASED:
        words = f"this computer's clock says {now:%Y-%m-%d}, and this version is of {RELEASED:%Y-%m-%d}"
        raise CertificateError(f"{words}: set the clock first (timedatectl), else the certificate is over too early")
    if not 1 <= plan.days <= LONGEST_DAYS:
        raise CertificateError(f"--days: must be 1 to {LONGEST_DAYS}, not {plan.days}")
    alternatives = ",".join(_alternative(name) for name in dict.fromkeys(plan.names))
    folder = plan.folder.resolve()
    certificate, key = folder / CERTIFICATE_FILE, folder / KEY_FILE
    for path in (certificate, key):
        if path.exists() and not plan.replace:
            raise CertificateError(f"{path} is there already: --replace replaces it")
    folder.mkdir(parents=True, exist_ok=True)
    made_certificate, made_key = _run_openssl(alternatives, now, plan.days)
    write_private(key, made_key)
    write_private(certificate, made_certificate)
    certificate.chmod(0o644)
    for path in (certificate, key):
        leave_to_owner(path)
    tls = load_tls(WebSettings(tls_certificate=certificate, tls_key=key))
    assert tls is not None  # noqa: S101 - both are set
    return MadeCertificate(certificate, key, tls.fingerprint)


def usual_names(settings: WebSettings) -> list[str]:
    """Return the names and addresses by which this computer's page is likely to be opened."""
    host = socket.gethostname()
    found = [host, host if "." in host else f"{host}.local", "localhost", "127.0.0.1", "::1"]
    found += [settings.host, *settings.allowed_hosts, _own_address()]
    return [name for name in dict.fromkeys(found) if _is_name(name)]


def clock_doubt() -> str:
    """Return why this computer's clock may be wrong; empty when a time server or the like keeps it right."""
    if is_wall_clock_kept():
        return ""
    now = datetime.now(UTC)
    return f"Nothing keeps this clock right. Is it {now:%Y-%m-%d %H:%M} UTC? Else set it, and make it again: --replace."


def _own_address() -> str:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_NOWHERE)
        except OSError:
            return ""
        return str(probe.getsockname()[0])


def _is_name(name: str) -> bool:
    try:
        _alternative(name)
    except CertificateError:
        return False
    return True


def _alternative(name: str) -> str:
    """Return a name as openssl's subjectAltName has it (x509v3_config(5))."""
    try:
        address = ipaddress.ip_address(name)
    except ValueError:
        if not _NAME.fullmatch(name):
            raise CertificateError(f"--name: {name!r} is neither a host name nor an IP address") from None
        return f"DNS:{name}"
    if address.is_unspecified:
        raise CertificateError(f"--name: {name} is every address: name the one that browsers open")
    return f"IP:{address}"


def _run_openssl(alternatives: str, now: datetime, days: int) -> tuple[bytes, bytes]:
    """Return certificate and key, PEM: valid for ``days`` from now (UTC), and some before."""
    begin = now - _BEFORE
    end = min(now + timedelta(days=days), begin + timedelta(days=LONGEST_DAYS))
    command = shutil.which("openssl")
    if command is None:
        raise CertificateError("openssl is not installed: apt install openssl")
    with tempfile.TemporaryDirectory(prefix="hawk-certificate-") as name:  # mode 0700
        folder = Path(name)
        settings, request, certificate, key = (
            folder / each for each in ("openssl.cnf", "request", "certificate", "key")
        )
        (folder / "index").touch()
        settings.write_text(
            "[req]\ndistinguished_name = dn\nprompt = no\n[dn]\nCN = Parking Lot Hawk\n[ca]\ndefault_ca = own\n"
            f"[own]\ndatabase = {folder}/index\nnew_certs_dir = {folder}\nrand_serial = yes\ndefault_md = sha256\n"
            "policy = any\nx509_extensions = page\n[any]\ncommonName = supplied\n[page]\n"
            f"subjectAltName = {alternatives}\nbasicConstraints = critical,CA:FALSE\n"
            "keyUsage = critical,digitalSignature\nextendedKeyUsage = serverAuth\nsubjectKeyIdentifier = hash\n"
        )
        made = ["req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-sha256"]
        made += ["-config", str(settings), "-keyout", str(key), "-out", str(request)]
        times = [f"{each:%Y%m%d%H%M%SZ}" for each in (begin, end)]
        # the only command of openssl 3.0 to 3.3 that takes the begin of the validity
        signed = ["ca", "-selfsign", "-batch", "-notext", "-config", str(settings), "-keyfile", str(key)]
        signed += ["-startdate", times[0], "-enddate", times[1], "-in", str(request), "-out", str(certificate)]
        for arguments in (made, signed):
            _call([command, *arguments])
        return certificate.read_bytes(), key.read_bytes()


def _call(command: Sequence[str]) -> None:
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=OPENSSL_S)
    except subprocess.TimeoutExpired:
        raise CertificateError(f"openssl did not end within {OPENSSL_S:g} s") from None
    if ended.returncode != 0:
        raise CertificateError(f"openssl: {ended.stderr.strip()[-500:]}")
