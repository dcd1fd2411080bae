"""Faults of the link: one direction or both are silent, late, doubled, out of order, or speak for somebody else."""

from __future__ import annotations

from typing import Final

from hawk.comm.protocol.commands import Arm, CompulsiveMove, Land, ReturnToLaunch
from hawk.model.operation import StateName
from proving.faults import answers
from proving.faults.fault import (
    ACCEPTED,
    DOWN,
    MOTORS_OFF,
    UP,
    Fault,
    Forge,
    KillMotors,
    Link,
    Order,
    See,
    When,
    absent,
    both,
    check_fails,
    dropped,
    healthy,
    lower_than,
    mode,
    reported,
    state,
    unhealthy,
)
from proving.faults.proxy import Direction, Rule

_DOWN, _UP = Direction.DOWN, Direction.UP
_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_BOTH: Final = (dropped(_DOWN), dropped(_UP))
_WELL: Final = Link()
_STAYS: Final = both(UP, mode("GUIDED", "BRAKE"))
_SENT_HOME: Final = (See(mode("RTL"), 10.0, real=True), See(state(_RETURN), 12.0, real=True))
_HEARTBEAT: Final = {
    "type": 2,
    "autopilot": 3,
    "base_mode": 81,  # custom mode, guided, stabilised; not armed
    "custom_mode": 4,
    "system_status": 3,
    "mavlink_version": 3,
}
_POSITION: Final = {
    "time_boot_ms": "now",
    "lat": 473_000_000,
    "lon": 85_000_000,
    "alt": 500_000,
    "relative_alt": 0,
    "vx": 0,
    "vy": 0,
    "vz": 0,
    "hdg": 0,
}

SILENCE: Final = (
    Fault(
        "the autopilot is not heard, it hears us",
        When.HOVERING,
        (Link((dropped(_DOWN),)), See(mode("RTL"), 5.0), _WELL, See(state(_RETURN), 5.0)),
        answer=answers.NOT_HEARD,
    ),
    Fault(
        "the autopilot is not heard, it hears us",
        When.EXPLORING,
        (Link((dropped(_DOWN),)), See(mode("RTL"), 5.0), _WELL, See(state(_RETURN), 5.0)),
        answer=answers.NOT_HEARD,
    ),
    Fault(
        "the autopilot does not hear us, we hear it",
        When.HOVERING,
        (
            Link((dropped(_UP),)),
            See(mode("RTL"), 10.0, real=True),
            See(state(_RETURN), 12.0, real=True),
            _WELL,
            See(DOWN, 120.0),
        ),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the autopilot does not hear us, we hear it",
        When.EXPLORING,
        (Link((dropped(_UP),)), *_SENT_HOME),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut in both directions",
        When.HOVERING,
        (
            Link(_BOTH),
            See(unhealthy("link"), 4.0),
            See(mode("RTL"), 10.0, real=True),
            _WELL,
            See(both(state(_RETURN), healthy("link")), 10.0),
        ),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut in both directions",
        When.EXPLORING,
        (Link(_BOTH), See(unhealthy("link"), 4.0), See(mode("RTL"), 10.0, real=True), See(DOWN, 180.0)),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut in both directions",
        When.RETURNING,
        (Link(_BOTH), See(unhealthy("link"), 4.0), See(DOWN, 120.0), _WELL, See(state(StateName.IDLE), 10.0)),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut in both directions",
        When.GROUND,
        (Link(_BOTH), See(unhealthy("link"), 4.0), See(check_fails("Link"), 5.0), _WELL, See(healthy("link"), 10.0)),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut in both directions",
        When.ARMED,
        (Link(_BOTH), See(MOTORS_OFF, 15.0), _WELL, See(both(state(StateName.IDLE), healthy("link")), 10.0)),
        answer=answers.LINK_CUT,
    ),
    Fault(
        "the link is cut for a second",
        When.HOVERING,
        (Link(_BOTH), See(_STAYS, 1.0, lasts=True), _WELL, See(both(state(_HOVER), _STAYS), 10.0, lasts=True)),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "HEARTBEAT alone is lost before it reaches us",
        When.HOVERING,
        (Link((dropped(_DOWN, "HEARTBEAT"),)), See(unhealthy("link"), 4.0), See(mode("RTL"), 6.0)),
        answer=answers.NOT_HEARD,
    ),
    Fault(
        "the autopilot is not heard and the operator wants it down",
        When.HOVERING,
        (Link((dropped(_DOWN),)), See(unhealthy("link"), 4.0), Order(Land()), See(mode("LAND"), 4.0)),
        ends_flight=True,
        answer=answers.NOT_HEARD_AND_ASKED,
    ),
    Fault(
        "the autopilot is not heard and the operator wants it home",
        When.EXPLORING,
        (Link((dropped(_DOWN),)), See(unhealthy("link"), 4.0), Order(ReturnToLaunch()), See(mode("RTL"), 4.0)),
        answer=answers.NOT_HEARD_AND_ASKED,
    ),
    Fault(
        "the autopilot is not heard and the operator cuts the motors",
        When.HOVERING,
        (Link((dropped(_DOWN),)), See(unhealthy("link"), 4.0), KillMotors(), See(MOTORS_OFF, 2.0)),
        ends_flight=True,
        falls=True,
        answer=answers.NOT_HEARD_AND_ASKED,
    ),
)

LOSSES: Final = (
    Fault(
        "half of all datagrams are lost on the ground",
        When.GROUND,
        (
            Link((dropped(_DOWN, share=0.5), dropped(_UP, share=0.5))),
            See(absent(UP), 15.0, lasts=True),
            _WELL,
            See(healthy("link"), 5.0),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "a third of all datagrams is lost",
        When.HOVERING,
        (
            Link((dropped(_DOWN, share=0.3), dropped(_UP, share=0.3))),
            See(both(state(_HOVER), UP), 20.0, lasts=True),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 10.0),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "the position is lost before it reaches us",
        When.EXPLORING,
        (
            Link((dropped(_DOWN, "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"),)),
            See(unhealthy("position"), 3.0),
            See(state(_HOVER, _RETURN, StateName.LAND), 6.0),
        ),
        answer=answers.NO_POSITION,
    ),
    Fault(
        "the position is lost before it reaches us",
        When.HOVERING,
        (
            Link((dropped(_DOWN, "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"),)),
            See(unhealthy("position"), 3.0),
            Order(CompulsiveMove(x=10.0, y=0.0)),
            See(absent(ACCEPTED), 1.0),
            See(UP, 4.0, lasts=True),
        ),
        answer=answers.NO_POSITION,
    ),
    Fault(
        "the landed state is lost before it reaches us",
        When.HOVERING,
        (
            Link((dropped(_DOWN, "EXTENDED_SYS_STATE"),)),
            See(both(UP, absent(state(StateName.IDLE, StateName.ARM))), 15.0, lasts=True),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 3.0),
            See(DOWN, 120.0),
        ),
        answer=answers.LANDED_WRONG,
    ),
    Fault(
        "the battery is lost before it reaches us",
        When.HOVERING,
        (Link((dropped(_DOWN, "SYS_STATUS", "BATTERY_STATUS"),)), See(mode("RTL"), 45.0), See(state(_RETURN), 46.0)),
        answer=answers.NO_CHARGE_SENT,
    ),
    Fault(
        "parameters do not come",
        When.GROUND,
        (
            Link((dropped(_DOWN, "PARAM_VALUE"),)),
            Order(Arm()),
            See(both(absent(UP), absent(state(StateName.TAKEOFF))), 12.0, lasts=True),
        ),
        answer=answers.NO_PARAMETERS,
    ),
    Fault(
        "no command is acknowledged",
        When.HOVERING,
        (
            Link((dropped(_DOWN, "COMMAND_ACK"),)),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 3.0),
            See(state(_RETURN), 4.0),
        ),
        answer=answers.NO_CHARGE_SENT,
    ),
    Fault(
        "the fence's upload is not acknowledged",
        When.GROUND,
        (
            Link((dropped(_DOWN, "MISSION_ACK", "MISSION_REQUEST_INT", "MISSION_REQUEST"),)),
            Order(Arm()),
            See(both(absent(UP), absent(state(StateName.TAKEOFF))), 20.0, lasts=True),
        ),
        answer=answers.NO_PARAMETERS,
    ),
)

ORDER: Final = (
    Fault(
        "one HEARTBEAT comes 1.2 s late",
        When.HOVERING,
        (
            Link((Rule(_DOWN, frozenset({"HEARTBEAT"}), delay_s=1.2, times=1),)),
            See(both(state(_HOVER), _STAYS, absent(reported("Landed"))), 6.0, lasts=True),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "one position comes 1.2 s late",
        When.EXPLORING,
        (
            Link((Rule(_DOWN, frozenset({"LOCAL_POSITION_NED"}), delay_s=1.2, times=1),)),
            See(both(state(_EXPLORE), UP, absent(reported("booted"))), 6.0, lasts=True),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "datagrams come out of order, up to 0.3 s late",
        When.HOVERING,
        (
            Link((Rule(_DOWN, jitter_s=0.3), Rule(_UP, jitter_s=0.3))),
            See(both(state(_HOVER), _STAYS, absent(reported("booted"))), 15.0, lasts=True),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "every datagram comes three times",
        When.EXPLORING,
        (
            Link((Rule(_DOWN, copies=2), Rule(_UP, copies=2))),
            See(both(state(_EXPLORE), UP), 10.0, lasts=True),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "every datagram comes a second late",
        When.HOVERING,
        (
            Link((Rule(_DOWN, delay_s=1.0), Rule(_UP, delay_s=1.0))),
            See(both(UP, absent(state(StateName.IDLE, StateName.ARM))), 12.0, lasts=True),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 5.0),
        ),
        answer=answers.LINK_POOR,
    ),
    Fault(
        "all datagrams wait for 4 s and then come at once",
        When.HOVERING,
        (
            Link((Rule(_DOWN, delay_s=4.0),)),
            See(UP, 4.0, lasts=True),
            _WELL,
            See(
                both(UP, absent(reported("Motors off")), absent(state(StateName.IDLE, StateName.ARM))), 8.0, lasts=True
            ),
        ),
        answer=answers.LINK_POOR,
    ),
)

FORGED: Final = (
    Fault(
        "another sender says that the motors are off",
        When.HOVERING,
        (
            Forge("HEARTBEAT", _HEARTBEAT, foreign=True, times=40),
            See(both(UP, state(_HOVER), absent(reported("Motors off"))), 3.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
    Fault(
        "another system says that the motors are off",
        When.HOVERING,
        (
            Forge("HEARTBEAT", _HEARTBEAT, system=7, times=40),
            See(both(UP, state(_HOVER), absent(reported("Motors off"))), 3.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
    Fault(
        "another sender says that the drone is elsewhere",
        When.EXPLORING,
        (
            Forge("GLOBAL_POSITION_INT", _POSITION, foreign=True, times=40),
            See(both(UP, state(_EXPLORE)), 3.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
    Fault(
        "the link says once that the drone has landed",
        When.HOVERING,
        (
            Forge("EXTENDED_SYS_STATE", {"vtol_state": 0, "landed_state": 1}),
            See(both(UP, state(_HOVER)), 5.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
    Fault(
        "the link says all the time that the drone has landed",
        When.HOVERING,
        (
            Link((Rule(_DOWN, frozenset({"EXTENDED_SYS_STATE"}), change={"landed_state": 1}),)),
            See(both(UP, absent(state(StateName.IDLE, StateName.ARM))), 12.0, lasts=True),
            Order(ReturnToLaunch()),
            See(mode("RTL"), 3.0),
        ),
        answer=answers.LANDED_WRONG,
    ),
    Fault(
        "the link says once that the autopilot has just booted",
        When.HOVERING,
        (
            Forge("SYSTEM_TIME", {"time_unix_usec": 0, "time_boot_ms": 500}),
            Forge(
                "ATTITUDE",
                dict.fromkeys(("roll", "pitch", "yaw", "rollspeed", "pitchspeed", "yawspeed"), 0.0)
                | {"time_boot_ms": 500},
            ),
            See(both(UP, state(_HOVER), absent(reported("booted"))), 6.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
    Fault(
        "the link says once that the motors are off",
        When.EXPLORING,
        (
            Forge("HEARTBEAT", _HEARTBEAT),
            See(both(UP, absent(state(StateName.IDLE, StateName.ARM)), absent(lower_than(5.0))), 6.0, lasts=True),
        ),
        answer=answers.FORGED,
    ),
)

LINK: Final = (*SILENCE, *LOSSES, *ORDER, *FORGED)
