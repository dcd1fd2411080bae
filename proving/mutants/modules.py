"""The modules whose tests are tried by mutants, and these tests.

Those that decide about safety (`SAFETY`): their fast unit tests reach every branch (`make coverage`;
`WITHOUT_EVERY_BRANCH` names the exceptions) and kill nine of ten mutants of each group (`make mutants`). The rooms that
keep and count years of surveys (`ARCHIVE`): 85 % of the mutants of each.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]

_NAMED: Final[dict[str, tuple[str, ...]]] = {
    "transitions": ("hawk/ddc/decider.py", "hawk/ddc/rules/follower.py"),
    "states": (
        "hawk/ddc/states/base.py",
        "hawk/ddc/states/explore.py",
        "hawk/ddc/states/factory.py",
        "hawk/ddc/states/ground.py",
        "hawk/ddc/states/rtl_and_land.py",
        "hawk/ddc/states/hover.py",
        "hawk/ddc/states/moves.py",
        "hawk/ddc/states/path_home.py",
    ),
    "judge": ("hawk/ddc/rules/judge.py", "hawk/ddc/rules/needs.py", "hawk/ddc/rules/again.py"),
    "guard": ("hawk/ddc/rules/guard.py",),
    "before Arm": ("hawk/ddc/rules/preflight.py", "hawk/ddc/readings/clearance.py"),
    "commands": (
        "hawk/comm/protocol/authority.py",
        "hawk/comm/protocol/command_table.py",
        "hawk/ddc/rules/command_desk.py",
        "hawk/ddc/operations_manager.py",
        "hawk/ddc/readings/operator.py",
        "hawk/ddc/orders.py",
        "hawk/ddc/parameters/heights.py",
    ),
    "acts": (
        "hawk/comm/autopilot/autopilot.py",
        "hawk/comm/autopilot/calls.py",
        "hawk/comm/autopilot/commands.py",
        "hawk/comm/autopilot/gimbal.py",
        "hawk/comm/autopilot/parameters.py",
        "hawk/ddc/acts.py",
        "hawk/ddc/motion.py",
        "hawk/ddc/performer.py",
        "hawk/ddc/requests/requests.py",
    ),
    "failsafes": (
        "hawk/ddc/parameters/values.py",
        "hawk/ddc/rules/failed_ticks.py",
        "hawk/ddc/parameters/failsafes.py",
        "hawk/ddc/parameters/reader.py",
    ),
    "keeper": (
        "hawk/ddc/keeper/effort.py",
        "hawk/ddc/keeper/fence.py",
        "hawk/ddc/keeper/keeper.py",
        "hawk/ddc/keeper/parameters.py",
    ),
    "fence": (
        "hawk/comm/autopilot/vehicle.py",
        "hawk/ddc/fence/plan.py",
        "hawk/ddc/fence/keepers.py",
        "hawk/ddc/fence/path.py",
        "hawk/ddc/fence/geometry.py",
        "hawk/ddc/battery/energy.py",
    ),
    "kill": ("hawk/ddc/rules/kill.py",),
    "service interface": ("hawk/ddc/requests/service_interface.py",),
    "watchdog": ("hawk/runtime/process.py", "hawk/runtime/supervision.py"),
    "starts": ("hawk/ddc/rules/follower.py", "hawk/daemon/starts.py", "hawk/store/run_notes.py"),
    "second witnesses": (
        "hawk/ddc/stopwatch.py",
        "hawk/ddc/witnesses/heading.py",
        "hawk/ddc/witnesses/height.py",
        "hawk/ddc/witnesses/place.py",
        "hawk/ddc/witnesses/walk.py",
        "hawk/ddc/witnesses/witness.py",
        "hawk/ddc/rules/notices.py",
    ),
    "readings": (
        "hawk/comm/mavlink/foreign_writes.py",
        "hawk/model/frames.py",
        "hawk/comm/autopilot/terrain.py",
        "hawk/comm/autopilot/remote_control.py",
        "hawk/comm/autopilot/remote_id.py",
        "hawk/comm/autopilot/status_texts.py",
        "hawk/ddc/readings/clearance.py",
        "hawk/ddc/battery/battery.py",
        "hawk/ddc/battery/charge.py",
        "hawk/ddc/battery/chemistry.py",
        "hawk/ddc/readings/fall.py",
        "hawk/ddc/readings/remote_control.py",
        "hawk/ddc/readings/remote_id.py",
        "hawk/ddc/senses.py",
        "hawk/ddc/readings/wind.py",
    ),
    "telemetry that decides": (
        "hawk/comm/autopilot/boot_clock.py",
        "hawk/comm/clock.py",
        "hawk/comm/mavlink/claim.py",
        "hawk/comm/mavlink/frames.py",
        "hawk/comm/autopilot/mavlink_link.py",
        "hawk/comm/mavlink/peer.py",
        "hawk/comm/autopilot/streams.py",
        "hawk/comm/threads.py",
        "hawk/comm/topic.py",
        "hawk/comm/mavlink/udp_gate.py",
        "hawk/comm/autopilot/estimator.py",
        "hawk/comm/autopilot/telemetry.py",
        "hawk/ddc/readings/belief.py",
        "hawk/ddc/readings/home.py",
        "hawk/ddc/facts.py",
        "hawk/ddc/rules/silence.py",
        "hawk/ddc/readings/topic_interface.py",
        "hawk/ddc/readings/link.py",
    ),
}


def _unnamed(folder: str) -> tuple[str, ...]:
    """Return the modules of a folder that no group names."""
    named = {module for modules in _NAMED.values() for module in modules}
    found = (str(path.relative_to(ROOT)) for path in sorted((ROOT / folder).glob("*.py")) if path.stem != "__init__")
    return tuple(module for module in found if module not in named)


def _room(name: str) -> tuple[str, ...]:
    """Return all modules of a room."""
    found = sorted((ROOT / "hawk" / name).rglob("*.py"))
    return tuple(str(path.relative_to(ROOT)) for path in found if path.stem != "__init__")


SAFETY: Final = _NAMED | {"readings": _NAMED["readings"] + _unnamed("hawk/ddc/readings")}
"""Group -> modules, as paths in the checkout. A new reading is one of them without an entry."""
SAFETY_MODULES: Final = tuple(module for modules in SAFETY.values() for module in modules)

ARCHIVE: Final = {room: _room(room) for room in ("lots", "stats", "exports", "picture")}
"""Room -> its modules."""

GROUPS: Final = SAFETY | ARCHIVE
ALL_MODULES: Final = tuple(module for modules in GROUPS.values() for module in modules)

NEEDED: Final = dict.fromkeys(SAFETY, 0.90) | dict.fromkeys(ARCHIVE, 0.85)
"""Group -> share of its mutants that must be killed."""

LEFT_OUT: Final[dict[str, tuple[str, ...]]] = {
    "it reports: no state and no reaction reads it": (
        "hawk/ddc/requests/flight_log.py",
        "hawk/ddc/recorder.py",
        "hawk/ddc/memory.py",
        "hawk/ddc/replay.py",
        "hawk/ddc/status.py",
        "hawk/ddc/settings.py",
        "hawk/ddc/battery/survey.py",
    ),
    "files, words, and what an operator asks to be seen: the fence judges every target of it": (
        "hawk/runtime/files.py",
        "hawk/ddc/fence/outline.py",
        "hawk/ddc/fence/geojson.py",
        "hawk/ddc/words.py",
    ),
    "the connection to the operator's page: a lost operator is a reaction of the guard": (
        "hawk/comm/base_socket.py",
        "hawk/comm/protocol/commands.py",
        "hawk/comm/protocol/heartbeat.py",
        "hawk/comm/protocol/base.py",
        "hawk/comm/message_socket.py",
        "hawk/runtime/performance.py",
    ),
    "the camera: its faults end a task by Hover, and its motion is one of several witnesses": (
        "hawk/comm/cameras/calibration.py",
        "hawk/comm/cameras/sources",
        "hawk/comm/cameras/drone_camera.py",
        "hawk/comm/cameras/stamp_clock.py",
    ),
    "values without a decision, MAVSDK's own log, and what only `hawk-drone check` or another receiver hears": (
        "hawk/comm/mavlink/mavsdk_log.py",
        "hawk/comm/mavlink/passive_listener.py",
        "hawk/comm/autopilot/remote_id_sender.py",
    ),
}
"""Reason -> modules and folders of the drone's side that are not listed."""

WITHOUT_EVERY_BRANCH: Final = frozenset(
    {
        "hawk/comm/autopilot/autopilot.py",
        "hawk/model/frames.py",
        "hawk/comm/autopilot/mavlink_link.py",
        "hawk/comm/autopilot/parameters.py",
        "hawk/comm/autopilot/remote_id.py",
        "hawk/comm/threads.py",
        "hawk/comm/topic.py",
        "hawk/comm/mavlink/udp_gate.py",
        "hawk/ddc/fence/plan.py",
        "hawk/ddc/fence/keepers.py",
        "hawk/ddc/fence/path.py",
        "hawk/ddc/operations_manager.py",
        "hawk/ddc/states/path_home.py",
    }
)
"""Modules of which the fast unit tests miss some branches; flights and integration tests reach them."""

COVERING: Final = "not flight and not nightly"
"""The tests that run, as pytest's marker expression."""

_SAFETY_TESTS: Final = ("ddc", "comm", "daemon", "model", "runtime", "store")
_ARCHIVE_TESTS: Final = {
    "lots": ("lots", "stats", "web", "webhooks"),
    "stats": ("stats", "web"),
    "exports": ("exports", "web"),
    "picture": ("picture",),
}
"""Room -> rooms of the unit tests that reach it."""

_OWN: Final[dict[str, tuple[str, ...]]] = {
    "hawk/ddc/decider.py": ("decider", "operations_manager_lot_moves"),
    "hawk/ddc/states/base.py": ("base_by_facts", "home", "decider"),
    "hawk/ddc/states/explore.py": ("explore_by_facts", "decider"),
    "hawk/ddc/states/factory.py": ("base_by_facts", "decider"),
    "hawk/ddc/states/ground.py": ("ground_by_facts", "decider"),
    "hawk/ddc/states/rtl_and_land.py": ("rtl_and_land_by_facts", "decider"),
    "hawk/ddc/states/hover.py": ("hover_by_facts", "decider", "place_doubt", "height"),
    "hawk/ddc/states/moves.py": ("moves_by_facts", "decider"),
    "hawk/ddc/states/path_home.py": ("operations_manager_return_inside", "operations_manager_path_home"),
    "hawk/ddc/rules/follower.py": ("follower", "decider"),
    "hawk/ddc/rules/guard.py": ("decider", "guard"),
    "hawk/ddc/rules/judge.py": ("judge", "judge_commands_in_every_state", "decider"),
    "hawk/ddc/rules/needs.py": ("needs", "judge", "decider"),
    "hawk/ddc/acts.py": ("requests",),
    "hawk/ddc/motion.py": ("motion", "moves_route_follower"),
    "hawk/ddc/rules/preflight.py": ("preflight_by_facts",),
    "hawk/ddc/parameters/values.py": ("failsafes", "keeper"),
    "hawk/ddc/witnesses/walk.py": ("walk", "place"),
    "hawk/ddc/witnesses/witness.py": ("place_doubt", "height", "witness"),
    "hawk/ddc/rules/notices.py": ("place_doubt", "height"),
    "hawk/ddc/stopwatch.py": ("stopwatch", "heading", "height", "place", "home", "remote_control"),
    "hawk/ddc/rules/failed_ticks.py": ("failed_ticks",),
    "hawk/ddc/fence/plan.py": ("plan", "plan_fence_zones", "geometry_zones"),
    "hawk/ddc/requests/requests.py": ("requests", "performer", "plan", "plan_fence_zones"),
    "hawk/ddc/fence/keepers.py": ("plan", "plan_fence_zones", "senses"),
    "hawk/ddc/operations_manager.py": ("failed_ticks", "follower_restart", "reader", "operations_manager_flight"),
    "hawk/ddc/parameters/reader.py": ("reader", "plan"),
    "hawk/ddc/rules/command_desk.py": (
        "command_desk",
        "command_desk_route_requests",
        "operations_manager_lot_moves",
    ),
    "hawk/ddc/fence/geometry.py": ("geometry_limits", "geometry"),
    "hawk/ddc/readings/clearance.py": ("clearance", "clearance_slope", "senses"),
    "hawk/ddc/battery/battery.py": ("senses",),
    "hawk/ddc/battery/chemistry.py": ("charge", "failsafes"),
    "hawk/ddc/battery/energy.py": ("energy", "senses"),
    "hawk/ddc/readings/wind.py": ("wind", "senses"),
    "hawk/ddc/readings/belief.py": ("belief", "senses"),
    "hawk/ddc/readings/instant.py": ("senses", "fall"),
    "hawk/ddc/readings/limits.py": ("senses",),
    "hawk/ddc/readings/link.py": ("link", "senses"),
    "hawk/ddc/readings/operator.py": ("operator", "senses"),
    "hawk/ddc/readings/position.py": ("position", "senses"),
    "hawk/ddc/readings/remote_control.py": ("remote_control", "senses"),
    "hawk/ddc/readings/remote_id.py": ("remote_id", "senses"),
    "hawk/ddc/readings/sight.py": ("senses",),
    "hawk/ddc/keeper/effort.py": ("keeper",),
    "hawk/ddc/keeper/fence.py": ("keeper", "operations_manager_flight_gate"),
    "hawk/ddc/keeper/keeper.py": ("keeper", "home", "decider", "operations_manager_path_home"),
    "hawk/ddc/keeper/parameters.py": ("keeper", "reader"),
    "hawk/ddc/requests/service_interface.py": ("service_interface_target_gate", "service_interface"),
    "hawk/comm/autopilot/vehicle.py": ("vehicle", "autopilot", "mavlink_link"),
    "hawk/comm/autopilot/streams.py": ("streams", "telemetry"),
    "hawk/comm/mavlink/frames.py": ("frames_vehicle_kinds",),
    "hawk/comm/autopilot/telemetry.py": ("telemetry", "telemetry_places"),
    "hawk/daemon/starts.py": ("starts", "starts_goes_on"),
    "hawk/runtime/process.py": ("process_watchdog", "process_ticker", "process_priority", "process_parent"),
}
"""Module -> names of its own test files where they do not bear its name."""


def folders_of_tests(modules: Iterable[str]) -> tuple[str, ...]:
    """Return the folders of the tests that are tried for these modules."""
    rooms: dict[str, None] = {}
    for room in {Path(module).parts[1] for module in modules}:
        rooms |= dict.fromkeys(_ARCHIVE_TESTS.get(room, _SAFETY_TESTS))
    return tuple(f"tests/unit/{room}" for room in sorted(rooms))


def own_files(module: str) -> list[str]:
    """Return the test files of a module."""
    names = _OWN.get(module, (Path(module).stem,))
    room = ROOT / "tests" / "unit" / Path(module).parts[1]
    return [str(file.relative_to(ROOT)) for name in names for file in sorted(room.rglob(f"test_{name}.py"))]
