"""Builds the algorithms from the settings.

It is a module of its own because it imports the libraries of vision and mapping; the daemon does so once the autopilot
is open.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import cv2

from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.camera_check import CameraCheck
from hawk.algo.vision.network import DEFAULT_ENGINE
from hawk.algo.vision.network_file import VisionModelError, network_name
from hawk.algo.vision.picture import PictureStyle
from hawk.config.sections import Config

_LOG = logging.getLogger(__name__)


def program_name(model: Path | None) -> str:
    """Return the program's version with the network by which it sees: the first digits of its file's SHA-256."""
    return f"{version('hawk-drone')}, network {network_name(model)}"


def make_manager(config: Config, survey_id: str, *, is_simulation: bool) -> AlgorithmManagerApp:
    """Return the manager with all its parts. ``survey_id`` names the map; it may be empty."""
    cv2.setNumThreads(config.vision.threads)
    program_name(config.vision.model)  # read off the loop
    settings = VisionSettings(
        model=config.vision.model,
        engine=config.vision.engine,
        threads=config.vision.threads,
        minimum_height_m=config.vision.minimum_height_m,
        minimum_stalls=config.vision.minimum_stalls,
    )
    interface = AlgorithmTopicInterface()
    caption = "SIMULATION" if is_simulation else ""
    manager = AlgorithmManagerApp(
        style=PictureStyle(config.web.video_width, config.web.video_quality, caption),
        camera_check=CameraCheck(config.vision.minimum_height_m),
    )
    mapper = MapperApp(map_id=survey_id or "first")
    planner = PathPlanApp(
        PathPlanSettings(cm_per_pixel=config.flight.explore_cm_per_pixel, exposure_s=config.camera.exposure_s)
    )
    manager.init(interface, _vision(settings), mapper, planner, FrameCamera(interface))
    return manager


def _vision(settings: VisionSettings) -> VisionApp:
    """Return vision. What cannot be used any more is replaced by the packaged network in OpenCV: the flight goes on."""
    try:
        return VisionApp(settings)
    except VisionModelError as error:
        _LOG.error("%s; the packaged network is used in its place, in OpenCV", error)
        return VisionApp(replace(settings, model=None, engine=DEFAULT_ENGINE))
