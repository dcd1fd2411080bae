"""Rows of docs/faults.md: how the drone answers faults that it answers alike, and what its operator does."""

from __future__ import annotations

from typing import Final

from proving.faults.fault import Answer, Subject

NOT_HEARD: Final = Answer(
    Subject.LINK,
    "the autopilot is not heard; it hears us",
    "sends Return To Launch without an answer; mode RTL after {mode RTL}",
    "**Link** is unhealthy. Let it come home",
)
NOT_HEARD_AND_ASKED: Final = Answer(
    Subject.LINK,
    "nothing is heard, and you ask for Return home, Land or Cut motors",
    "sends it without an answer: RTL after {mode RTL}, LAND {mode LAND}, motors off {motors off}",
    "these three work while nothing is heard",
)
LINK_CUT: Final = Answer(
    Subject.LINK,
    "neither hears the other, or the autopilot does not hear us",
    "the autopilot's own failsafe acts: mode RTL after {mode RTL}; armed on the ground: it disarms",
    "**Link** is unhealthy, or the state becomes Return To Launch by itself. Let it land",
)
LINK_POOR: Final = Answer(
    Subject.LINK,
    "messages are late, doubled, out of order, or a share of them is lost; gaps of up to 4 s",
    "flies on; no take-off on the ground while half is lost",
    "nothing to do",
)
NO_POSITION: Final = Answer(
    Subject.LINK,
    "the position is not sent",
    "ends a task and holds; position unhealthy after {position unhealthy}",
    "moves are refused. Return home, or fly by hand",
)
NO_CHARGE_SENT: Final = Answer(
    Subject.LINK,
    "the charge is not sent, or no command is acknowledged",
    "returns home; mode RTL after {mode RTL} (charge: 30 s count as a gap)",
    "let it land; look for the cause on the ground",
)
LANDED_WRONG: Final = Answer(
    Subject.LINK,
    "the landed state is not sent, or is wrong",
    "counts as in the air; flies on, Return home works",
    "the part `ground` is unhealthy. Land",
)
NO_PARAMETERS: Final = Answer(
    Subject.LINK,
    "parameters do not come, or the fence's upload is not acknowledged",
    "does not take off",
    "the check says what is missing",
)
FORGED: Final = Answer(
    Subject.LINK,
    "another sender forges messages, or single ones are wrong or no text",
    "flies on by the first sender; believes no single word of landing, boot or motors off",
    "**Link** names the sender's address; Arm is refused until it is silent for 10 s",
)
OTHERS_ON_LINK: Final = Answer(
    Subject.LINK,
    "antenna tracker, gimbal or a second copter on the link",
    "finds its copter: Idle after {Idle}; in flight it flies on",
    "of two copters name yours: `autopilot.vehicle_system_id`",
)
MAVLINK_1: Final = Answer(
    Subject.LINK,
    "the link speaks MAVLink 1",
    "does not arm; in flight it flies on",
    "the check names `SERIALn_PROTOCOL` 2",
)
AUTOPILOT_BOOTS: Final = Answer(
    Subject.LINK,
    "the autopilot's program ends or boots on the ground",
    "does not arm until it is back",
    "**Link** is unhealthy; wait for the checks",
)
GNSS_LOST: Final = Answer(
    Subject.POSITION,
    "GNSS is lost",
    "ends a task; the autopilot lands, or holds the height alone: after {mode LAND*}",
    "fly by hand where the place below is bad. On the ground: Arm is refused",
)
POSITION_JUMP: Final = Answer(
    Subject.POSITION,
    "the position jumps by 25 m and more",
    "ends a task, holds at the new estimate; reported after {*position*}",
    "nothing is mapped until it is back. Return home or land",
)
GNSS_WALK: Final = Answer(
    Subject.POSITION,
    "GNSS walks away, all flags good",
    "the camera sees it: the task ends after {not: Autonomous Explore}, the camera holds the true place or it "
    "lands; a return under way becomes Hover or Land",
    "“The camera sees the drone move …”. Land or fly by hand; what you ask for in doubt is flown",
)
GNSS_SLOW_WALK: Final = Answer(
    Subject.POSITION,
    "GNSS walks away slowly, over ground without texture, in a first hover in wind, or with gaps",
    "the camera sees what adds up: a doubt after {*camera sees*}; it holds the true place; a return that must be "
    "is a landing",
    "as in a faster walk",
)
NO_WITNESS: Final = Answer(
    Subject.POSITION,
    "the camera sees no ground that it knows, in the air",
    "flies on; after {*no second witness*} the part `witness` is unhealthy",
    "a walk of GNSS would not be seen: come home, or fly lower",
)
GNSS_SMALL_ERROR: Final = Answer(
    Subject.POSITION,
    "small errors of GNSS: wander, a step of 1.5 m, 25 m for 4 s, 10 m from the boot on, another origin",
    "flies on; at 10 m from the boot on it arms once the position is trusted",
    "nothing to do",
)
BAROMETER_DRIFT: Final = Answer(
    Subject.POSITION,
    "the barometer drifts or steps, all flags good",
    "reported after {reported*} (slow drift: the longest), ends a task, keeps the true height; a return that "
    "must be becomes Land",
    "“The height is not what the autopilot reports”. Land",
)
BAROMETER_WEATHER: Final = Answer(
    Subject.POSITION,
    "the barometer follows the weather, or drifts before the flight",
    "flies on; on the ground it stays Idle",
    "nothing to do",
)
COMPASSES_FAIL: Final = Answer(
    Subject.POSITION,
    "all compasses fail",
    "flies on by gyroscopes and GNSS; reported after {reported*}",
    "land soon. On the ground: Arm is refused",
)
COMPASSES_TURN: Final = Answer(
    Subject.POSITION,
    "all compasses turn by 45° to 60°, all flags good",
    "the camera sees it: ends a task after {not: Autonomous Explore}; nothing is mapped",
    "fly by hand or land: the drone may circle for some 10 s",
)
CHARGE_LOW: Final = Answer(
    Subject.BATTERY,
    "the charge runs low, or the true charge is far below the counter's",
    "returns home: mode RTL after {mode RTL*}, landed after {landed}",
    "let it come home",
)
VOLTAGE_SAG: Final = Answer(
    Subject.BATTERY,
    "the voltage sags under load: 3.25 V, 3.1 V a cell",
    "returns below 3.3 V after {not: Autonomous Explore}, lands below 3.2 V after {mode LAND or RTL}; a dip of 2 "
    "s changes nothing",
    "clear the ground below. Replace the battery",
)
CHARGE_COUNTER: Final = Answer(
    Subject.BATTERY,
    "the counter of charge stands still or begins again",
    "counts by time and voltage from there; reported after {reported*}",
    "nothing to do in the air; look at the battery monitor afterwards",
)
BATTERY_ON_GROUND: Final = Answer(
    Subject.BATTERY,
    "on the ground: charge, voltage or number of cells is wrong or not known",
    "does not arm",
    "the checks **Battery** and **Battery thresholds** name the remedy",
)
NO_PICTURE: Final = Answer(
    Subject.CAMERA,
    "no picture, broken ones, or the same picture again and again",
    "ends a task after {Hover}; healthy {camera healthy} after the camera is",
    "**Camera** is unhealthy with its reason. On the ground: Arm is refused",
)
CAMERA_TURNED: Final = Answer(
    Subject.CAMERA,
    "the camera is turned, upside down, mirrored, or comes loose",
    "ends a task and maps no more; camera unhealthy after {camera unhealthy} of exploring",
    "the message names the value of `camera.mount_yaw_deg` that fits",
)
PICTURE_DAMAGE: Final = Answer(
    Subject.CAMERA,
    "one damaged picture in ten, wrong or no time stamps, EXIF orientation, bytes behind the picture",
    "explores on; a damaged or badly stamped picture is left out",
    "nothing to do",
)
NO_PICTURE_ON_RETURN: Final = Answer(
    Subject.CAMERA,
    "no picture during the return",
    "returns and lands as ever",
    "nothing to do",
)
PILOT: Final = Answer(
    Subject.PILOT,
    "the pilot takes over",
    "Manual after {Manual}; sends nothing until **Resume**",
    "give the drone back by the switch, then **Resume**",
)
REMOTE_CONTROL_LOST: Final = Answer(
    Subject.PILOT,
    "the remote control is lost",
    "the autopilot's failsafe returns: mode RTL after {mode RTL}",
    "nobody can take over by hand: let it land",
)
OPERATOR_GONE: Final = Answer(
    Subject.PILOT,
    "the operator is gone",
    "holds after `operator.operator_timeout_s`, returns home `operator.operator_hold_s` later",
    "**Take control** in time and it holds for you; anyone may send it home or land it",
)
WITHOUT_CONTROL: Final = Answer(
    Subject.PILOT,
    "somebody without control sends it home; a flood of requests or commands",
    "refuses the first, answers the one in control: Hover after {Hover}",
    "nothing to do",
)
MOTORS_CUT: Final = Answer(
    Subject.PILOT,
    "the operator cuts the motors",
    "motors off after {motors off}; it falls",
    "look at the drone, then **Allow arming again**",
)
NO_TAKEOFF: Final = Answer(
    Subject.PILOT,
    "armed, and nobody takes off",
    "motors off after {motors off}",
    "**Arm** again",
)
STATION_COMMANDS: Final = Answer(
    Subject.STATIONS,
    "another station lands it, sends it home, stops it, or sends it to a place",
    "follows; the task ends",
    "the message names the station where the link carries its messages. **Hold** takes it back",
)
STATION_PARAMETERS: Final = Answer(
    Subject.STATIONS,
    "another station changes a failsafe, a threshold or the return height",
    "puts it back; reported and right again after {reported*}",
    "no new task until then. Close the other station",
)
STATION_FENCE: Final = Answer(
    Subject.STATIONS,
    "another station clears, replaces or switches off the fence",
    "uploads it again: in force after {the fence as before, “ence”}; after the fourth change in a minute it "
    "returns home",
    "no new task until then. Close the other station",
)
STATION_HOME: Final = Answer(
    Subject.STATIONS,
    "another station moves home",
    "sets it back; the fourth time within a minute it returns home",
    "close the other station",
)
STATION_RALLY: Final = Answer(
    Subject.STATIONS,
    "another station uploads rally points",
    "clears them in flight, reported after {reported*}; returns home, not there. On the ground: no Arm",
    "remove them from the autopilot",
)
MOTORS_STOPPED: Final = Answer(
    Subject.STATIONS,
    "another station, or a failure, stops the motors in the air",
    "“Motors off in the air”, in red, after {“otors off in the air”}; Arm stays locked",
    "the message has place and time. Look at the drone, then **Allow arming again**",
)
PROGRAM_ENDS: Final = Answer(
    Subject.PROGRAM,
    "the program ends or hangs",
    "is started again: shows itself after {the daemon runs again}; holds, a return or landing goes on",
    "control, map and survey are there; go on",
)
PROGRAM_ENDS_TWICE: Final = Answer(
    Subject.PROGRAM,
    "the program ends twice within a minute in the air",
    "mode RTL {mode RTL} after the second end",
    "let it land; send `hawk-drone doctor`",
)
PROGRAM_STOPPED: Final = Answer(
    Subject.PROGRAM,
    "the program is stopped in the air (SIGTERM)",
    "asks for RTL first (mode RTL after {mode RTL}), then it ends",
    "never stop it in the air",
)
SECOND_DAEMON: Final = Answer(
    Subject.PROGRAM,
    "a second daemon is started",
    "the second ends, or waits and names the first; the flight goes on",
    "stop one of them",
)
DISK_FULL: Final = Answer(
    Subject.PROGRAM,
    "the disk is full",
    "reports it after {reported*} and flies on without a recording; starts are counted in memory",
    "land, free the disk",
)
CLOCK_STEP: Final = Answer(
    Subject.PROGRAM,
    "the clock of the computer steps",
    "changes nothing, across starts too",
    "nothing to do",
)
