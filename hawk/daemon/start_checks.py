"""Checks of settings that need this computer: the store's folder, the network's file, the page's address."""

from __future__ import annotations

import errno
import socket
import tempfile
from collections.abc import Callable
from pathlib import Path

from hawk.algo.vision.network_file import VisionModelError
from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import Config, ConfigError, VisionSettings, WebSettings
from hawk.ddc.fence.geojson import read_fence, read_survey_outline
from hawk.ddc.fence.geometry import FenceError
from hawk.web.access.tokens import TOKEN_FILE, TokensError, read_tokens, with_configured
from hawk.web.security import InsecureBindingError, check_binding


def check_files(config: Config) -> None:
    """Read every file that the settings name, before anything starts. Raises ConfigError naming setting and remedy.

    The folder of the store is left to `make_folder`, which makes it.
    """
    load_calibration(config.camera)
    readers: tuple[tuple[str, Path | None, Callable[[Path], object]], ...] = (
        ("fence.file", config.fence.file, read_fence),
        ("flight.outline_file", config.flight.outline_file, read_survey_outline),
    )
    for setting, path, read in readers:
        try:
            if path is not None:
                read(path)
        except FenceError as error:
            raise ConfigError(f"{setting}: {error}") from error
    check_model(config.vision)


def check_access(config: Config) -> None:
    """Raise ConfigError where the page's address is taken, belongs to another computer, or needs a token.

    A port that is found free can be taken before the daemon opens it: that is reported then.
    """
    web, folder = config.web, config.store.directory
    try:
        kept = read_tokens(folder / TOKEN_FILE)
        check_binding(web, with_configured(kept, web.token, b""), folder.resolve())
    except (InsecureBindingError, TokensError) as error:
        raise ConfigError(str(error)) from error
    check_port(web)


def check_background(web: WebSettings) -> None:
    """Raise ConfigError for a folder of map tiles that is not there."""
    folder = web.background_tiles
    if folder is not None and not folder.is_dir():
        words = "is no folder; hawk-drone make-background makes one, or leave the setting out"
        raise ConfigError(f"web.background_tiles: {folder} {words}")


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

    It takes a second or two. A start in the air leaves it out: there `hawk.daemon.algorithms` falls back to the
    packaged network in OpenCV.
    """
    if settings.model is None and settings.engine == VisionSettings().engine:
        return
    from hawk.algo.vision.network import StallNetwork  # its libraries take half a second to load

    try:
        StallNetwork.load(settings.model, settings.engine, settings.threads)
    except VisionModelError as error:
        raise ConfigError(str(error)) from error


def check_port(web: WebSettings) -> None:
    """Listen for a moment where the page is to be served. Raises ConfigError as `listening_problem`."""
    try:
        found = socket.getaddrinfo(web.host, web.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        for family, _, _, _, address in dict.fromkeys(found):
            socket.create_server(address, family=family).close()
    except OSError as error:
        raise ConfigError(listening_problem(error, web)) from error


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
