"""The programs of docs/python-client.md are run against the real web server."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from inspect import getmembers, isfunction
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.commands import Control
from hawk.comm.protocol.heartbeat import CommandOption, DroneStatus, OperationStatus, PerceptionStatus
from hawk.model.lot_map import OccupancyMap, Stall, StallState
from hawk.model.operation import StateName
from hawk.survey.client import DroneClient
from tests.unit.web.rig import Rig

TEXT = (Path(__file__).parents[3] / "docs" / "python-client.md").read_text(encoding="utf-8")
PROGRAMS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
OPTIONS = tuple(
    CommandOption(command=command, possible=True) for command in ("Set Failsafes", "Arm", "Takeoff", "Compulsive Move")
)
STALL = Stall(17, 21.4, -3.1, 1.57, 2.5, 5.0, 0.04, StallState.FREE, 0.97, 9, 207.9, 4)


def program(function: str) -> Any:
    """Return a function of the page's programs."""
    (source,) = (each for each in PROGRAMS if f"async def {function}(" in each)
    found: dict[str, Any] = {"__name__": "program"}
    exec(compile(source, "docs/python-client.md", "exec"), found)  # noqa: S102 - our own page
    return found[function]


class Drone(Rig):
    """The rig, and the commands that its queue brought."""

    served: tuple[str, ...] = ()


@pytest.fixture
async def rig() -> AsyncIterator[Drone]:
    made = Drone()
    await made.start()
    made.map.publish(OccupancyMap(stalls={17: STALL}, map_id="m"))

    async def tick() -> None:
        states = [StateName.HOVER, StateName.HOVER, StateName.IDLE]
        while True:
            made.served += tuple(command.type for _, command in made.serve_commands())
            state = states[min(len(made.side.hub) and made.sequence // 20, 2)]
            perception = PerceptionStatus(free=1)
            operation = OperationStatus(state=state, detail="Holds.", options=OPTIONS)
            made.publish_status(DroneStatus(operation=operation, perception=perception))
            await asyncio.sleep(0.001)

    task = asyncio.create_task(tick(), name="tick")
    yield made
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    assert made.server is not None
    await made.server.close()


async def test_watching_prints_what_the_drone_does_and_its_stalls(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    assert rig.server is not None
    await program("watch")("127.0.0.1", rig.server.port)
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2:] == ["Idle Holds. 1 free, 0 taken", "17 free 21.4 m north, -3.1 m east"]


async def test_a_program_takes_control_and_holds(rig: Rig) -> None:
    assert rig.server is not None
    assert await program("stop")("127.0.0.1", rig.server.port) == "holds; the motors could be cut"
    assert [command.type for _, command in rig.manager.urgent] == ["Hold", "Kill Request"]
    assert rig.side.desk.controlling_clients() == frozenset(), "control was given back"


async def test_a_program_flies(rig: Drone) -> None:
    assert rig.server is not None
    await program("hop")("127.0.0.1", rig.server.port)
    assert rig.served == ("Set Failsafes", "Arm", "Takeoff", "Compulsive Move")
    assert [command.type for _, command in rig.manager.urgent] == ["Land"]


async def test_it_says_why_it_was_refused(rig: Rig) -> None:
    assert rig.server is not None
    assert rig.server.port is not None
    async with DroneClient("127.0.0.1", rig.server.port) as other:
        await other.order(Control(action="Request"))
        said = await program("stop")("127.0.0.1", rig.server.port)
        assert said.startswith("refused: Someone else has control.")


def test_every_public_name_of_the_client_is_on_the_page() -> None:
    methods = {name for name, _ in getmembers(DroneClient, isfunction) if not name.startswith("_")}
    made = DroneClient("127.0.0.1", 1)
    values = {name for name in vars(made) if not name.startswith("_")}
    assert methods | values | {"is_connected"} <= set(re.findall(r"[a-z_]+", TEXT))
