"""A self-signed certificate with its key, made by the system's ``openssl``.

``openssl`` is on every system that checks certificates; a Python package for this would be a compiled one more on the
drone, for a command that is run every two years.
"""

from __future__ import annotations

import ctypes
import ipaddress
import re
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from hawk.config.sections import WebSettings
from hawk.runtime.private_files import leave_to_owner, write_private
from hawk.web.access.tls import load_tls

CERTIFICATE_FILE: Final = "certificate.pem"
KEY_FILE: Final = "certificate-key.pem"
LONGEST_DAYS: Final = 825
"""Apple's limit for certificates that a person trusts by hand (support.apple.com/103769)."""
OPENSSL_S: Final = 60.0
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9.-]{0,252}")
_NOWHERE: Final = ("192.0.2.1", 9)
"""An address that is nobody's (RFC 5737): which of this computer's addresses leads out. Nothing is sent."""


RELEASED: Final = datetime(2026, 11, 24, tzinfo=UTC)
"""Date of the newest release: a clock that is earlier is wrong."""
_BEFORE: Final = timedelta(days=2)
"""A certificate begins this long before it is made: clocks that are behind by less take it."""
_CLOCK_ERROR: Final = 5  # TIME_ERROR of adjtimex(2): nothing keeps the clock right
_TIMEX_BYTES: Final = 512
"""More than struct timex; all zero it asks for the state alone."""


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
    try:
        state = ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(_TIMEX_BYTES))
    except (OSError, AttributeError):
        return ""
    if state != _CLOCK_ERROR:
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
