"""The modules that decide about safety, and their tests.

Their fast unit tests reach every branch (`make coverage`; `WITHOUT_EVERY_BRANCH` names the exceptions) and kill nine of
ten mutants of each group (`make mutants`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parent.parent

GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "transitions": ("hawk/ddc/decider.py", "hawk/ddc/follower.py"),
    "states": (
        "hawk/ddc/states/base.py",
        "hawk/ddc/states/explore.py",
        "hawk/ddc/states/factory.py",
        "hawk/ddc/states/ground.py",
        "hawk/ddc/states/homing.py",
        "hawk/ddc/states/hover.py",
        "hawk/ddc/states/moves.py",
        "hawk/ddc/states/path_home.py",
        "hawk/ddc/states/takeoff.py",
    ),
    "judge": ("hawk/ddc/judge.py",),
    "guard": ("hawk/ddc/guard.py",),
    "before Arm": ("hawk/ddc/preflight.py", "hawk/ddc/slope.py"),
    "commands": (
        "hawk/comm/authority.py",
        "hawk/ddc/command_desk.py",
        "hawk/ddc/command_table.py",
        "hawk/ddc/operations_manager.py",
        "hawk/ddc/operator.py",
        "hawk/ddc/orders.py",
        "hawk/ddc/params.py",
        "hawk/ddc/route_requests.py",
    ),
    "acts": (
        "hawk/comm/autopilot.py",
        "hawk/comm/calls.py",
        "hawk/comm/commands.py",
        "hawk/comm/gimbal.py",
        "hawk/comm/parameters.py",
        "hawk/ddc/acts.py",
        "hawk/ddc/motion.py",
        "hawk/ddc/performer.py",
        "hawk/ddc/requests.py",
    ),
    "failsafes": (
        "hawk/ddc/battery_thresholds.py",
        "hawk/ddc/failing.py",
        "hawk/ddc/failsafes.py",
        "hawk/ddc/parameter_values.py",
        "hawk/ddc/parameters.py",
        "hawk/ddc/return_settings.py",
    ),
    "keeper": (
        "hawk/ddc/keeping/changes.py",
        "hawk/ddc/keeping/effort.py",
        "hawk/ddc/keeping/fence.py",
        "hawk/ddc/keeping/home.py",
        "hawk/ddc/keeping/keeper.py",
        "hawk/ddc/keeping/parameters.py",
    ),
    "fence": (
        "hawk/comm/fence_rings.py",
        "hawk/ddc/fence.py",
        "hawk/ddc/fence_checks.py",
        "hawk/ddc/fence_file.py",
        "hawk/ddc/fence_path.py",
        "hawk/ddc/geofence.py",
        "hawk/ddc/home_path.py",
        "hawk/ddc/zones.py",
    ),
    "kill": ("hawk/ddc/kill.py",),
    "service interface": ("hawk/ddc/service_interface.py", "hawk/ddc/target_gate.py"),
    "watchdog": ("hawk/process.py", "hawk/supervision.py"),
    "starts": ("hawk/ddc/restart.py", "hawk/starts.py", "hawk/store/run_notes.py"),
    "second witnesses": (
        "hawk/ddc/camera_hold.py",
        "hawk/ddc/doubt.py",
        "hawk/ddc/heading.py",
        "hawk/ddc/height.py",
        "hawk/ddc/place.py",
        "hawk/ddc/stopwatch.py",
        "hawk/ddc/witness.py",
        "hawk/ddc/witness_reports.py",
        "hawk/ddc/witnesses.py",
    ),
    "readings": (
        "hawk/comm/foreign_writes.py",
        "hawk/comm/frames.py",
        "hawk/comm/rangefinder.py",
        "hawk/comm/remote_control.py",
        "hawk/comm/remote_id.py",
        "hawk/comm/status_texts.py",
        "hawk/comm/terrain.py",
        "hawk/ddc/below.py",
        "hawk/ddc/charge.py",
        "hawk/ddc/chemistry.py",
        "hawk/ddc/clearance.py",
        "hawk/ddc/energy.py",
        "hawk/ddc/fall.py",
        "hawk/ddc/remote_control.py",
        "hawk/ddc/remote_id.py",
        "hawk/ddc/senses.py",
        "hawk/ddc/wind.py",
    ),
    "telemetry that decides": (
        "hawk/comm/boot_clock.py",
        "hawk/comm/clock.py",
        "hawk/comm/claim.py",
        "hawk/comm/mavlink_frames.py",
        "hawk/comm/mavlink_link.py",
        "hawk/comm/peer.py",
        "hawk/comm/roster.py",
        "hawk/comm/streams.py",
        "hawk/comm/threads.py",
        "hawk/comm/topic.py",
        "hawk/comm/udp_gate.py",
        "hawk/comm/vehicle_kinds.py",
        "hawk/comm/estimator.py",
        "hawk/comm/telemetry.py",
        "hawk/ddc/belief.py",
        "hawk/ddc/home.py",
        "hawk/ddc/facts.py",
        "hawk/ddc/silence.py",
        "hawk/ddc/topic_interface.py",
        "hawk/ddc/watches.py",
    ),
}
"""Group -> modules, as paths in the checkout."""

ALL_MODULES: Final = tuple(module for modules in GROUPS.values() for module in modules)

LEFT_OUT: Final[dict[str, tuple[str, ...]]] = {
    "it reports: no state and no reaction reads it": (
        "hawk/ddc/drain.py",
        "hawk/ddc/flight_log.py",
        "hawk/ddc/ground_watch.py",
        "hawk/ddc/replay.py",
        "hawk/ddc/status.py",
        "hawk/ddc/survey_memory.py",
        "hawk/ddc/survey_need.py",
        "hawk/ddc/survey_notice.py",
        "hawk/ddc/survey_watch.py",
    ),
    "files, words, and what an operator asks to be seen: the fence judges every target of it": (
        "hawk/ddc/area_import.py",
        "hawk/ddc/atomic_file.py",
        "hawk/ddc/fence_geojson.py",
        "hawk/ddc/outline.py",
        "hawk/ddc/outline_geojson.py",
        "hawk/ddc/outline_keeper.py",
        "hawk/ddc/outline_rules.py",
        "hawk/ddc/settings.py",
        "hawk/ddc/words.py",
    ),
    "the connection to the operator's page: a lost operator is a reaction of the guard": (
        "hawk/comm/async_message_socket.py",
        "hawk/comm/base_socket.py",
        "hawk/comm/control_messages.py",
        "hawk/comm/corners.py",
        "hawk/comm/map_update.py",
        "hawk/comm/message_base.py",
        "hawk/comm/message_socket.py",
        "hawk/comm/messages.py",
        "hawk/comm/names.py",
        "hawk/comm/operator_camera.py",
        "hawk/comm/operator_desk.py",
        "hawk/comm/outline_messages.py",
        "hawk/comm/performance.py",
        "hawk/comm/status.py",
    ),
    "the camera: its faults end a task by Hover, and its motion is one of several witnesses": (
        "hawk/comm/calibration.py",
        "hawk/comm/camera_sources",
        "hawk/comm/drone_camera.py",
        "hawk/comm/stamp_clock.py",
    ),
    "values without a decision, MAVSDK's own log, and what only `hawk-drone check` or another receiver hears": (
        "hawk/comm/mavsdk_log.py",
        "hawk/comm/passive_listener.py",
        "hawk/comm/remote_id_sender.py",
        "hawk/comm/vehicle.py",
    ),
}
"""Reason -> modules and folders of the drone's side that are not listed."""

WITHOUT_EVERY_BRANCH: Final = frozenset(
    {
        "hawk/comm/autopilot.py",
        "hawk/comm/frames.py",
        "hawk/comm/mavlink_link.py",
        "hawk/comm/parameters.py",
        "hawk/comm/remote_id.py",
        "hawk/comm/threads.py",
        "hawk/comm/topic.py",
        "hawk/comm/udp_gate.py",
        "hawk/ddc/fence.py",
        "hawk/ddc/fence_file.py",
        "hawk/ddc/fence_path.py",
        "hawk/ddc/operations_manager.py",
        "hawk/ddc/states/path_home.py",
    }
)
"""Modules of which the fast unit tests miss some branches; flights and integration tests reach them."""

FAST: Final = "not flight and not slow"
"""The tests that run, as pytest's marker expression."""

TEST_FOLDERS: Final = ("tests/unit/ddc", "tests/unit/comm", "tests/unit/daemon", "tests/unit/store")

_OWN: Final[dict[str, tuple[str, ...]]] = {
    "hawk/ddc/decider.py": ("decider", "lot_moves"),
    "hawk/ddc/states/base.py": ("states_by_facts", "decider"),
    "hawk/ddc/states/explore.py": ("explore_by_facts", "decider"),
    "hawk/ddc/states/factory.py": ("states_by_facts", "decider"),
    "hawk/ddc/states/ground.py": ("ground_by_facts", "decider"),
    "hawk/ddc/states/homing.py": ("homing_by_facts", "decider"),
    "hawk/ddc/states/hover.py": ("holding_by_facts", "decider"),
    "hawk/ddc/states/moves.py": ("moves_by_facts", "decider"),
    "hawk/ddc/states/path_home.py": ("return_inside", "way_home"),
    "hawk/ddc/states/takeoff.py": ("ground_by_facts", "decider"),
    "hawk/ddc/follower.py": ("follower", "decider"),
    "hawk/ddc/guard.py": ("decider", "guard"),
    "hawk/ddc/judge.py": ("judge", "decider"),
    "hawk/ddc/acts.py": ("requests",),
    "hawk/ddc/motion.py": ("motion", "route_follower"),
    "hawk/ddc/preflight.py": ("preflight_by_facts",),
    "hawk/ddc/battery_thresholds.py": ("failsafes",),
    "hawk/ddc/camera_hold.py": ("place_doubt", "height"),
    "hawk/ddc/witness.py": ("place_doubt", "height"),
    "hawk/ddc/witness_reports.py": ("place_doubt", "height"),
    "hawk/ddc/witnesses.py": ("witnesses", "place_doubt"),
    "hawk/ddc/doubt.py": ("doubt", "heading", "height", "place"),
    "hawk/ddc/failing.py": ("failing_ticks",),
    "hawk/ddc/fence.py": ("fence", "fence_zones"),
    "hawk/ddc/fence_checks.py": ("performer", "fence", "fence_zones"),
    "hawk/ddc/fence_file.py": ("fence", "fence_zones", "senses"),
    "hawk/ddc/operations_manager.py": ("failing_ticks", "restart", "parameter_reader", "flight"),
    "hawk/ddc/parameter_values.py": ("failsafes", "keeping"),
    "hawk/ddc/parameters.py": ("parameter_reader", "fence"),
    "hawk/ddc/route_requests.py": ("route_requests", "lot_moves"),
    "hawk/ddc/zones.py": ("zones", "fence_zones"),
    "hawk/ddc/geofence.py": ("geofence_limits", "geofence"),
    "hawk/ddc/below.py": ("clearance", "slope", "senses"),
    "hawk/ddc/chemistry.py": ("charge", "failsafes"),
    "hawk/ddc/clearance.py": ("clearance", "senses"),
    "hawk/ddc/energy.py": ("energy", "senses"),
    "hawk/ddc/wind.py": ("wind", "senses"),
    "hawk/ddc/return_settings.py": ("failsafes",),
    "hawk/ddc/keeping/changes.py": ("keeping",),
    "hawk/ddc/keeping/effort.py": ("keeping",),
    "hawk/ddc/keeping/fence.py": ("keeping", "flight_gate"),
    "hawk/ddc/keeping/home.py": ("keeping", "home"),
    "hawk/ddc/keeping/keeper.py": ("keeping", "decider", "way_home"),
    "hawk/ddc/keeping/parameters.py": ("keeping", "parameter_reader"),
    "hawk/ddc/target_gate.py": ("target_gate", "service_interface"),
    "hawk/comm/fence_rings.py": ("fence_rings", "autopilot", "mavlink_link"),
    "hawk/comm/streams.py": ("rates", "telemetry"),
    "hawk/comm/vehicle_kinds.py": ("vehicle_kinds",),
    "hawk/comm/telemetry.py": ("telemetry", "telemetry_places"),
    "hawk/starts.py": ("starts", "goes_on"),
    "hawk/process.py": ("watchdog", "ticker", "priority", "parent"),
    "hawk/ddc/stopwatch.py": ("watches", "doubt"),
}
"""Module -> names of its own test files where they do not bear its name."""


def own_files(module: str) -> list[str]:
    """Return the test files of a module."""
    names = _OWN.get(module, (Path(module).stem,))
    room = "daemon" if len(Path(module).parts) == 2 else Path(module).parts[1]
    files = [f"tests/unit/{room}/test_{name}.py" for name in names]
    return [file for file in files if (ROOT / file).exists()]
