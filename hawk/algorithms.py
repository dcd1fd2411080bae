"""Builds the algorithms from the settings.

A module of its own because all that vision and mapping need is imported with it, which the daemon does only once the
autopilot is open.
"""

from __future__ import annotations

import cv2

from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.annotate import PictureStyle
from hawk.algo.vision.app import VisionApp
from hawk.algo.vision.settings import VisionSettings
from hawk.config import Config


def make_manager(config: Config, survey_id: str, *, is_simulation: bool) -> AlgorithmManagerApp:
    """Return everything but the network itself, which is loaded with the first frame. ``survey_id`` may be empty."""
    cv2.setNumThreads(config.vision.threads)
    settings = VisionSettings(
        model=config.vision.model,
        use_network=config.vision.use_network,
        threads=config.vision.threads,
        minimum_height_m=config.vision.minimum_height_m,
        minimum_stalls=config.vision.minimum_stalls,
    )
    interface = AlgorithmTopicInterface()
    caption = "SIMULATION" if is_simulation else ""
    manager = AlgorithmManagerApp(style=PictureStyle(config.web.video_width, config.web.video_quality, caption))
    mapper = MapperApp(map_id=survey_id or "first")
    planner = PathPlanApp(
        PathPlanSettings(cm_per_pixel=config.flight.explore_cm_per_pixel, exposure_s=config.camera.exposure_s)
    )
    manager.init(interface, VisionApp(settings), mapper, planner, FrameCamera(interface))
    return manager
