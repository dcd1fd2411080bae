"""A self-signed certificate with its key, made by the system's ``openssl``.

``openssl`` is on every system that checks certificates; a Python package for this would be a compiled one more on the
drone, for a command that is run every two years.
"""

from __future__ import annotations

import ipaddress
import re
import shutil
import socket
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.config import WebSettings
from hawk.web.private_files import leave_to_owner, write_private
from hawk.web.tls import load_tls

CERTIFICATE_FILE: Final = "certificate.pem"
KEY_FILE: Final = "certificate-key.pem"
LONGEST_DAYS: Final = 825
"""Apple's limit for certificates that a person trusts by hand (support.apple.com/103769)."""
OPENSSL_S: Final = 60.0
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9.-]{0,252}")
_NOWHERE: Final = ("192.0.2.1", 9)
"""An address that is nobody's (RFC 5737): which of this computer's addresses leads out. Nothing is sent."""


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


def make_certificate(plan: CertificatePlan) -> MadeCertificate:
    """Make certificate (mode 0644) and key (0600), and try them out. Raises CertificateError, OSError."""
    if not 1 <= plan.days <= LONGEST_DAYS:
        raise CertificateError(f"--days: must be 1 to {LONGEST_DAYS}, not {plan.days}")
    alternatives = ",".join(_alternative(name) for name in dict.fromkeys(plan.names))
    folder = plan.folder.resolve()
    certificate, key = folder / CERTIFICATE_FILE, folder / KEY_FILE
    for path in (certificate, key):
        if path.exists() and not plan.replace:
            raise CertificateError(f"{path} is there already: --replace replaces it")
    folder.mkdir(parents=True, exist_ok=True)
    made_certificate, made_key = _run_openssl(alternatives, plan.days)
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


def _run_openssl(alternatives: str, days: int) -> tuple[bytes, bytes]:
    """Return certificate and key, PEM."""
    command = shutil.which("openssl")
    if command is None:
        raise CertificateError("openssl is not installed: apt install openssl")
    with tempfile.TemporaryDirectory(prefix="hawk-certificate-") as name:  # mode 0700
        settings, certificate, key = (Path(name) / each for each in ("openssl.cnf", "certificate", "key"))
        settings.write_text(
            "[req]\ndistinguished_name = dn\nx509_extensions = page\nprompt = no\n[dn]\nCN = Parking Lot Hawk\n[page]\n"
            f"subjectAltName = {alternatives}\nbasicConstraints = critical,CA:FALSE\n"
            "keyUsage = critical,digitalSignature\nextendedKeyUsage = serverAuth\nsubjectKeyIdentifier = hash\n"
        )
        arguments = ["req", "-x509", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
        arguments += ["-sha256", "-days", str(days), "-config", str(settings)]
        arguments += ["-keyout", str(key), "-out", str(certificate)]
        try:
            ended = subprocess.run([command, *arguments], capture_output=True, text=True, timeout=OPENSSL_S)
        except subprocess.TimeoutExpired:
            raise CertificateError(f"openssl did not end within {OPENSSL_S:g} s") from None
        if ended.returncode != 0:
            raise CertificateError(f"openssl: {ended.stderr.strip()[-500:]}")
        return certificate.read_bytes(), key.read_bytes()
