from __future__ import annotations

from hawk.comm.clock import ManualClock
from hawk.comm.messages import Ack, AutonomousMove, Control, RouteRequest
from hawk.config import OperatorSettings
from hawk.web.gate import Gate
from hawk.web.hub import ClientHub
from hawk.web.sessions import ControlDesk


def test_who_only_watches_may_ask_for_a_way_but_not_fly_it() -> None:
    desk = ControlDesk(ManualClock(0.0), OperatorSettings())
    gate = Gate(desk, ClientHub())
    for client in ("ana", "eve"):
        desk.connect(client, None)
    assert gate("ana", Control(action="Request")) == Ack(id=None, accepted=True)
    assert gate("ana", AutonomousMove(x=1, y=2)) is None
    assert gate("ana", RouteRequest(x=1, y=2)) is None
    assert gate("eve", RouteRequest(x=1, y=2)) is None
    refused = gate("eve", AutonomousMove(x=1, y=2))
    assert isinstance(refused, Ack)
    assert not refused.accepted
