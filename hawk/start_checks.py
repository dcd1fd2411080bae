"""Checks of settings that need this computer: the store's folder, the network's file, the page's address."""

from __future__ import annotations

import errno
import socket
import tempfile
from pathlib import Path

from hawk.config import ConfigError, VisionSettings, WebSettings


def make_folder(setting: str, directory: Path) -> None:
    """Make a folder, and try to write into it. Raises ConfigError naming the setting or option."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except OSError as error:
        reason = f"{setting}: {directory} cannot be used: {error.strerror or error}"
        raise ConfigError(f"{reason}; name a folder that this user may write") from error


def check_model(settings: VisionSettings) -> None:
    """Load the network and the engine that the settings name, if any, and try them. Raises ConfigError naming the one.

    It takes a second or two. A start in the air leaves it out: there `hawk.algorithms` falls back to the packaged
    network in OpenCV.
    """
    is_default = settings.model is None and settings.engine == VisionSettings().engine
    if is_default or not settings.use_network:
        return
    from hawk.algo.vision.network import StallNetwork, VisionModelError  # their libraries take half a second to load

    try:
        StallNetwork.load(settings.model, settings.engine, settings.threads)
    except VisionModelError as error:
        raise ConfigError(str(error)) from error


def listening_problem(error: OSError, web: WebSettings) -> str:
    """Return which setting keeps the page from being served, and the remedy."""
    reason = error.strerror or str(error)
    if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
        return f"web.host: {web.host!r} is no address of this computer ({reason}); 0.0.0.0 stands for all that it has"
    if error.errno == errno.EACCES:
        return f"web.port: port {web.port} is not for this user ({reason}); name one of 1024 and more"
    if error.errno == errno.EADDRINUSE:
        return f"web.port: port {web.port} of {web.host} is in use ({reason}); name a free one"
    return f"web.host, web.port: {web.host}:{web.port} cannot be served: {reason}"
