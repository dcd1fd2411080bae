"""A Dask scheduler of the user's own: its address, and the certificates by which it and its clients know each other.

Who reaches a scheduler without certificates runs programs on all of its workers, and on this computer.
"""

from __future__ import annotations

import ipaddress
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

from hawk.picture.values import PictureError
from hawk.runtime.late import load

if TYPE_CHECKING:
    from distributed import Security

START: Final = (
    "start it by dask scheduler --protocol tls --tls-ca-file CA --tls-cert CERTIFICATE --tls-key KEY --no-dashboard "
    "--dashboard-address 127.0.0.1:0, and name it as tls://HOST:8786 (docs/how-to/count-a-city.md)"
)
_REACH_S: Final = 5.0


@dataclass(frozen=True, slots=True)
class Scheduler:
    """``address``: ``tls://HOST:PORT`` with the three files (PEM), or ``tcp://HOST:PORT`` of this computer without."""

    address: str
    ca_file: Path | None = None
    cert: Path | None = None
    key: Path | None = None

    def check(self) -> None:
        """Refuse an address that others can use, and files that do not fit it. Raises PictureError."""
        parts = urlsplit(self.address)
        files = {"--tls-ca-file": self.ca_file, "--tls-cert": self.cert, "--tls-key": self.key}
        missing = [name for name, path in files.items() if path is None]
        if parts.scheme == "tls":
            if missing:
                raise PictureError(
                    f"{missing[0]} is missing: {self.address} needs --tls-ca-file, --tls-cert and --tls-key, as dask "
                    "worker does"
                )
            self.security()
        elif len(missing) < len(files):
            given = next(name for name in files if name not in missing)
            raise PictureError(f"{given}: only together with a scheduler at tls://HOST:8786, not {self.address}")
        elif not _is_this_computer(parts.hostname or ""):
            raise PictureError(
                f"--scheduler {self.address}: everybody on that network can run programs on its workers and here; "
                f"{START}"
            )

    def check_reached(self) -> None:
        """Find before the work whether it listens. Raises PictureError."""
        try:
            place = urlsplit(self.address)
            socket.create_connection((place.hostname or "", place.port or 0), timeout=_REACH_S).close()
        except (OSError, ValueError) as error:
            raise PictureError(f"--scheduler {self.address}: does not answer ({error}); {START}") from error

    def security(self) -> Security | None:
        """Return Dask's settings of TLS; None without files. Raises PictureError for files that cannot be used."""
        if self.ca_file is None or self.cert is None or self.key is None:
            return None
        made: Security = load("distributed").Security(
            require_encryption=True,
            tls_ca_file=str(self.ca_file),
            tls_client_cert=str(self.cert),
            tls_client_key=str(self.key),
        )
        try:
            made.get_connection_args("client")
        except (OSError, ssl.SSLError) as error:
            raise PictureError(
                f"--tls-ca-file, --tls-cert, --tls-key: cannot be used ({error}); all three are PEM files, and the key "
                "is that of the certificate, without a pass phrase"
            ) from error
        return made


def _is_this_computer(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
