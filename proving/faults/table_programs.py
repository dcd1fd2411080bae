"""Faults of our own program, and of the people at its page."""

from __future__ import annotations

import signal
from typing import Final

from hawk.comm.protocol.commands import CheckFence, Hold, Land, ReturnToLaunch
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.model.operation import StateName
from proving.faults import answers
from proving.faults.fault import (
    ACCEPTED,
    DOWN,
    MOTORS_OFF,
    UP,
    Bring,
    Disk,
    Fault,
    Flood,
    HalfRequests,
    KillMotors,
    Leave,
    Order,
    Return,
    SecondDaemon,
    See,
    Signal,
    WallClock,
    When,
    absent,
    both,
    exited,
    mode,
    refused,
    restarted,
    state,
)
from proving.faults.sights import second_ended, second_says, warned

_HOVER, _EXPLORE, _RETURN = StateName.HOVER, StateName.AUTONOMOUS_EXPLORE, StateName.RETURN_TO_LAUNCH
_LOST = StateName.COMMUNICATION_LOST
_KILL, _TERM, _STOP = signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP
_RUNS: Final = See(restarted(), 15.0, real=True)
_TAKEN_UP: Final = (_RUNS, See(both(state(_HOVER, _LOST, _RETURN), UP), 17.0, real=True))
_SQUARE: Final = [
    FenceCorner(latitude=47.0 + 0.001 * north, longitude=8.0 + 0.001 * east)
    for north, east in ((0, 0), (0, 1), (1, 1), (1, 0))
]

PROGRAM: Final = (
    Fault(
        "our program is killed",
        When.HOVERING,
        (
            Signal(_KILL),
            *_TAKEN_UP,
            Return(),
            See(UP, 3.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS,
    ),
    Fault(
        "our program is killed",
        When.EXPLORING,
        (
            Signal(_KILL),
            See(both(restarted(), UP), 15.0, real=True),
            See(state(_HOVER, _LOST, _RETURN), 17.0, real=True),
        ),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS,
    ),
    Fault(
        "our program is killed",
        When.RETURNING,
        (Signal(_KILL), See(restarted(), 15.0, real=True), See(DOWN, 180.0), See(state(StateName.IDLE), 190.0)),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS,
    ),
    Fault(
        "our program is killed",
        When.GROUND,
        (Signal(_KILL), See(both(restarted(), state(StateName.IDLE)), 15.0, real=True)),
        answer=answers.PROGRAM_ENDS,
    ),
    Fault(
        "our program is killed twice within a minute",
        When.HOVERING,
        (
            Signal(_KILL),
            See(restarted(), 15.0, real=True),
            Signal(_KILL),
            See(mode("RTL"), 15.0, real=True),
            See(DOWN, 180.0),
        ),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS_TWICE,
    ),
    Fault(
        "our program gets SIGTERM",
        When.HOVERING,
        (Signal(_TERM), See(mode("RTL"), 4.0, real=True), See(exited(0), 10.0, real=True), See(DOWN, 180.0)),
        ends_flight=True,
        answer=answers.PROGRAM_STOPPED,
    ),
    Fault(
        "our program stands still",
        When.HOVERING,
        (Signal(_STOP), *_TAKEN_UP),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS,
    ),
    Fault(
        "our program stands still",
        When.EXPLORING,
        (
            Signal(_STOP),
            See(both(restarted(), UP), 15.0, real=True),
            See(state(_HOVER, _LOST, _RETURN), 17.0, real=True),
        ),
        ends_flight=True,
        answer=answers.PROGRAM_ENDS,
    ),
)

COMPUTER: Final = (
    Fault(
        "a second daemon is started on the same store",
        When.GROUND,
        (
            SecondDaemon(shared=True),
            See(second_ended(2), 15.0, real=True),
            See(state(StateName.IDLE), 3.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.SECOND_DAEMON,
    ),
    Fault(
        "a second daemon is started on the same store",
        When.HOVERING,
        (
            SecondDaemon(shared=True),
            See(second_ended(2), 15.0, real=True),
            See(both(state(_HOVER), UP), 5.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.SECOND_DAEMON,
    ),
    Fault(
        "a second daemon is started on the same autopilot",
        When.HOVERING,
        (
            SecondDaemon(shared=False),
            See(second_says("another hawk-drone"), 30.0, real=True),
            See(both(state(_HOVER), UP), 10.0, lasts=True),
        ),
        ends_flight=True,
        answer=answers.SECOND_DAEMON,
    ),
    Fault(
        "the disk is full",
        When.EXPLORING,
        (
            See(absent(warned("disk", "recording", "journal")), 1.0),
            Disk(full=True),
            See(warned("disk", "recording", "journal"), 20.0),
            See(both(state(_EXPLORE), UP), 10.0, lasts=True),
        ),
        ends_flight=True,
        own_disk=True,
        answer=answers.DISK_FULL,
    ),
    Fault(
        "the disk is full and our program is killed twice",
        When.HOVERING,
        (
            Disk(full=True),
            Signal(_KILL),
            _RUNS,
            See(both(UP, mode("GUIDED", "BRAKE", "RTL")), 3.0, lasts=True),
            Signal(_KILL),
            See(mode("RTL"), 15.0, real=True),
            See(DOWN, 180.0),
        ),
        ends_flight=True,
        own_disk=True,
        answer=answers.DISK_FULL,
    ),
    Fault(
        "the wall clock steps by 31 minutes and our program is killed",
        When.EXPLORING,
        (WallClock(1860.0), Signal(_KILL), *_TAKEN_UP),
        ends_flight=True,
        answer=answers.CLOCK_STEP,
    ),
    Fault(
        "the wall clock steps back by an hour and our program is killed twice",
        When.HOVERING,
        (
            WallClock(-3600.0),
            Signal(_KILL),
            _RUNS,
            Signal(_KILL),
            See(mode("RTL"), 15.0, real=True),
            See(DOWN, 180.0),
        ),
        ends_flight=True,
        answer=answers.CLOCK_STEP,
    ),
    Fault(
        "the wall clock steps by three days between two starts",
        When.GROUND,
        (
            Bring(When.HOVERING),
            Bring(When.GROUND),
            WallClock(3 * 86400.0),
            Signal(_KILL),
            See(both(restarted(), state(StateName.IDLE)), 15.0, real=True),
        ),
        ends_flight=True,
        answer=answers.CLOCK_STEP,
    ),
)

PEOPLE: Final = (
    Fault(
        "the operator is gone",
        When.HOVERING,
        (Leave(), See(state(_LOST), 8.0), See(mode("RTL"), 20.0), See(state(_RETURN), 20.0)),
        answer=answers.OPERATOR_GONE,
    ),
    Fault(
        "the operator is gone",
        When.EXPLORING,
        (Leave(), See(state(_LOST), 8.0), See(mode("RTL"), 20.0), See(DOWN, 200.0)),
        answer=answers.OPERATOR_GONE,
    ),
    Fault(
        "the operator is gone and comes back",
        When.HOVERING,
        (Leave(), See(state(_LOST), 8.0), Return(), See(state(_HOVER), 5.0)),
        answer=answers.OPERATOR_GONE,
    ),
    Fault(
        "the operator is gone and somebody else lands it",
        When.HOVERING,
        (Leave(), See(state(_LOST), 8.0), Order(Land(), stranger=True), See(mode("LAND"), 2.0), See(DOWN, 90.0)),
        answer=answers.OPERATOR_GONE,
    ),
    Fault(
        "somebody without control sends it home",
        When.EXPLORING,
        (Order(ReturnToLaunch(), stranger=True), See(refused(), 1.0), See(state(_EXPLORE), 3.0, lasts=True)),
        answer=answers.WITHOUT_CONTROL,
    ),
    Fault(
        "a thousand half requests",
        When.EXPLORING,
        (HalfRequests(1000), Order(Hold()), See(ACCEPTED, 1.0), See(both(state(_HOVER), UP), 3.0)),
        ends_flight=True,
        answer=answers.WITHOUT_CONTROL,
    ),
    Fault(
        "a viewer asks for 250 costly answers at once",
        When.EXPLORING,
        (
            Flood(CheckFence(corners=_SQUARE, ceiling=50.0), 250),
            Order(Hold()),
            See(ACCEPTED, 1.0),
            See(both(state(_HOVER), UP), 3.0),
        ),
        answer=answers.WITHOUT_CONTROL,
    ),
    Fault(
        "the operator cuts the motors",
        When.HOVERING,
        (KillMotors(), See(MOTORS_OFF, 1.0)),
        ends_flight=True,
        falls=True,
        answer=answers.MOTORS_CUT,
    ),
    Fault(
        "the operator cuts the motors",
        When.GROUND,
        (KillMotors(), See(both(MOTORS_OFF, absent(UP)), 5.0, lasts=True)),
        ends_flight=True,
        answer=answers.MOTORS_CUT,
    ),
)

PROGRAMS: Final = (*PROGRAM, *COMPUTER, *PEOPLE)
