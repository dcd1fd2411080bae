"""Certificates for tests, made by the system's openssl: of any age, signed by themselves or by an authority."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

SETTINGS = """
[ca]
default_ca = own
[own]
new_certs_dir = {folder}
database = {folder}/index.txt
rand_serial = yes
default_md = sha256
policy = any
unique_subject = no
[any]
commonName = supplied
[page]
subjectAltName = DNS:localhost,IP:127.0.0.1
basicConstraints = critical,CA:FALSE
extendedKeyUsage = serverAuth
[authority]
basicConstraints = critical,CA:TRUE
keyUsage = critical,keyCertSign
"""


@dataclass(frozen=True)
class Pair:
    certificate: Path
    key: Path


def openssl(*arguments: str | Path) -> None:
    subprocess.run(["openssl", *map(str, arguments)], check=True, capture_output=True)


def make_pair(
    folder: Path, name: str = "localhost", *, days: float = 300, age_days: float = 1, authority: Pair | None = None
) -> Pair:
    """Return a certificate that ends ``days`` from now and began ``age_days`` ago."""
    folder.mkdir(parents=True, exist_ok=True)
    settings, key, request, made = (folder / each for each in ("ca.cnf", "key.pem", "request.pem", "certificate.pem"))
    settings.write_text(SETTINGS.format(folder=folder))
    (folder / "index.txt").write_text("")
    openssl("ecparam", "-name", "prime256v1", "-genkey", "-noout", "-out", key)
    openssl("req", "-new", "-key", key, "-subj", f"/CN={name}", "-out", request)
    now = datetime.now(UTC)
    dates = ("-startdate", _stamp(now - timedelta(days=age_days)), "-enddate", _stamp(now + timedelta(days=days)))
    signer: list[str | Path] = ["-selfsign", "-keyfile", key]
    if authority is not None:
        signer = ["-cert", authority.certificate, "-keyfile", authority.key]
    kind = "authority" if name == "authority" else "page"
    openssl("ca", "-batch", "-notext", "-config", settings, *signer, *dates, "-extensions", kind,
            "-in", request, "-out", made)  # fmt: skip
    key.chmod(0o600)
    return Pair(made, key)


def _stamp(moment: datetime) -> str:
    return moment.strftime("%Y%m%d%H%M%SZ")
