"""The subjects of docs/faults.md in order, and rows of several tables' faults; other faults bring theirs (`Answer`)."""

from __future__ import annotations

from typing import Final

from proving.faults.page import Row, Subject

SUBJECTS: Final[tuple[Subject, ...]] = (
    Subject(
        "Link to the autopilot",
        (
            Row(
                "the autopilot is not heard; it hears us",
                "sends Return To Launch without an answer; mode RTL after {mode RTL}",
                "**Link** is unhealthy. Let it come home",
                ("the autopilot is not heard, it hears us", "HEARTBEAT alone is lost before it reaches us"),
            ),
            Row(
                "the same, and you ask for Return home, Land or Cut motors",
                "sends it without an answer: RTL after {mode RTL}, LAND {mode LAND}, motors off {motors off}",
                "these three work while nothing is heard",
                (
                    "the autopilot is not heard and the operator wants it down",
                    "the autopilot is not heard and the operator wants it home",
                    "the autopilot is not heard and the operator cuts the motors",
                ),
            ),
            Row(
                "neither hears the other, or the autopilot does not hear us",
                "the autopilot's own failsafe acts: mode RTL after {mode RTL}; armed on the ground: it disarms",
                "**Link** is unhealthy, or the state becomes Return To Launch by itself. Let it land",
                ("the autopilot does not hear us, we hear it", "the link is cut in both directions"),
            ),
            Row(
                "messages are late, doubled, out of order, or a share of them is lost; gaps of up to 4 s",
                "flies on; no take-off on the ground while half is lost",
                "nothing to do",
                (
                    "the link is cut for a second",
                    "half of all datagrams are lost on the ground",
                    "a third of all datagrams is lost",
                    "one HEARTBEAT comes 1.2 s late",
                    "one position comes 1.2 s late",
                    "datagrams come out of order, up to 0.3 s late",
                    "every datagram comes three times",
                    "every datagram comes a second late",
                    "all datagrams wait for 4 s and then come at once",
                ),
            ),
            Row(
                "the position is not sent",
                "ends a task and holds; position unhealthy after {position unhealthy}",
                "moves are refused. Return home, or fly by hand",
                ("the position is lost before it reaches us",),
            ),
            Row(
                "the charge is not sent, or no command is acknowledged",
                "returns home; mode RTL after {mode RTL} (charge: 30 s count as a gap)",
                "let it land; look for the cause on the ground",
                ("the battery is lost before it reaches us", "no command is acknowledged"),
            ),
            Row(
                "the landed state is not sent, or is wrong",
                "counts as in the air; flies on, Return home works",
                "the part `ground` is unhealthy. Land",
                (
                    "the landed state is lost before it reaches us",
                    "the link says all the time that the drone has landed",
                ),
            ),
            Row(
                "parameters do not come, or the fence's upload is not acknowledged",
                "does not take off",
                "the check says what is missing",
                ("parameters do not come", "the fence's upload is not acknowledged"),
            ),
            Row(
                "another sender forges messages, or single ones are wrong or no text",
                "flies on by the first sender; believes no single word of landing, boot or motors off",
                "**Link** names the sender's address; Arm is refused until it is silent for 10 s",
                (
                    "another sender says that the motors are off",
                    "another system says that the motors are off",
                    "another sender says that the drone is elsewhere",
                    "the link says once that the drone has landed",
                    "the link says once that the autopilot has just booted",
                    "the link says once that the motors are off",
                    "the autopilot says what is no text",
                ),
            ),
            Row(
                "antenna tracker, gimbal or a second copter on the link",
                "finds its copter: Idle after {Idle}; in flight it flies on",
                "of two copters name yours: `autopilot.vehicle_system_id`",
                (
                    "an antenna tracker is heard before the copter",
                    "a gimbal is heard before the copter",
                    "a second copter is heard before ours",
                    "antenna tracker, gimbal and second copter come onto the link",
                ),
            ),
            Row(
                "the link speaks MAVLink 1",
                "does not arm; in flight it flies on",
                "the check names `SERIALn_PROTOCOL` 2",
                ("the link speaks MAVLink 1 from the start", "the link falls back to MAVLink 1"),
            ),
            Row(
                "the autopilot's program ends or boots on the ground",
                "does not arm until it is back",
                "**Link** is unhealthy; wait for the checks",
                ("the autopilot's program ends on the ground", "the autopilot boots on the ground"),
            ),
        ),
    ),
    Subject(
        "Position, height, heading",
        (
            Row(
                "GNSS is lost",
                "ends a task; the autopilot lands, or holds the height alone: after {mode LAND*}",
                "fly by hand where the place below is bad. On the ground: Arm is refused",
                ("GNSS is lost", "GNSS is lost on the ground"),
            ),
            Row(
                "the position jumps by 25 m and more",
                "ends a task, holds at the new estimate; reported after {*position*}",
                "nothing is mapped until it is back. Return home or land",
                ("the estimate of the position jumps by 25 m", "GNSS is off by 30 m and stays so"),
            ),
            Row(
                "GNSS walks away, all flags good",
                "the camera sees it: the task ends after {not: Autonomous Explore}, the camera holds the true place or "
                "it lands; a return under way becomes Hover or Land",
                "“The camera sees the drone move …”. Land or fly by hand; what you ask for in doubt is flown",
                (
                    "GNSS walks north at 0.7 m/s, the autopilot with it",
                    "GNSS walks west at 0.7 m/s, the autopilot with it",
                    "GNSS walks south-east at 1.4 m/s for 12 s, from the first metre of the task on",
                    "GNSS walks at 0.7 m/s while the drone returns",
                ),
            ),
            Row(
                "GNSS walks away slowly, over ground without texture, in a first hover in wind, or with gaps",
                "the camera sees what adds up: a doubt after {*camera sees*}; it holds the true place; a return that "
                "must be is a landing",
                "the same",
                (
                    "GNSS walks at 0.1 m/s, the autopilot with it",
                    "GNSS walks at 0.25 m/s, the autopilot with it",
                    "GNSS walks at 0.25 m/s over ground without texture",
                    "GNSS walks at 0.7 m/s in a flight's first hover, in wind",
                    "GNSS walks at 0.7 m/s while every fourth picture shows nothing",
                    "GNSS has walked at 0.25 m/s, then the battery falls to 15 %",
                ),
            ),
            Row(
                "the camera sees no ground that it knows, in the air",
                "flies on; after {*no second witness*} the part `witness` is unhealthy",
                "a walk of GNSS would not be seen: come home, or fly lower",
                ("the camera sees nothing for 15 s",),
            ),
            Row(
                "small errors of GNSS: wander, a step of 1.5 m, 25 m for 4 s, 10 m from the boot on, another origin",
                "flies on; at 10 m from the boot on it arms once the position is trusted",
                "nothing to do",
                (
                    "GNSS wanders at 0.04 m/s",
                    "GNSS steps by 1.5 m",
                    "GNSS is off by 25 m for 4 s",
                    "GNSS is off by 10 m from the boot on",
                    "the autopilot's own origin moves by 20 m",
                ),
            ),
            Row(
                "the barometer drifts or steps, all flags good",
                "reported after {reported*} (slow drift: the longest), ends a task, keeps the true height; a return "
                "that must be becomes Land",
                "“The height is not what the autopilot reports”. Land",
                (
                    "the barometer rises by 0.5 m/s",
                    "the barometer falls by 0.5 m/s",
                    "the barometer rises by 0.5 m/s while the drone returns",
                    "the barometer rises by 0.05 m/s, too slowly for the camera's minute",
                    "the barometer steps by 6 m",
                ),
            ),
            Row(
                "the barometer follows the weather, or drifts before the flight",
                "flies on; on the ground it stays Idle",
                "nothing to do",
                (
                    "the barometer rises by 0.02 m/s, as with the weather",
                    "the barometer rises by 0.2 m/s before the flight",
                ),
            ),
            Row(
                "all compasses fail",
                "flies on by gyroscopes and GNSS; reported after {reported*}",
                "land soon. On the ground: Arm is refused",
                ("all compasses fail for 20 s", "all compasses fail", "all compasses fail on the ground"),
            ),
            Row(
                "all compasses turn by 45° to 60°, all flags good",
                "the camera sees it: ends a task after {not: Autonomous Explore}; nothing is mapped",
                "fly by hand or land: the drone may circle for some 10 s",
                ("all compasses turn by 45°", "all compasses turn by −60°"),
            ),
        ),
    ),
    Subject(
        "Battery",
        (
            Row(
                "the charge runs low, or the true charge is far below the counter's",
                "returns home: mode RTL after {mode RTL*}, landed after {landed}",
                "let it come home",
                ("the battery falls to 15 %", "the true charge is 8 % and the counter says 100 %"),
            ),
            Row(
                "the voltage sags under load: 3.25 V, 3.1 V a cell",
                "returns below 3.3 V after {not: Autonomous Explore}, lands below 3.2 V after {mode LAND or RTL}; a "
                "dip of 2 s changes nothing",
                "clear the ground below. Replace the battery",
                (
                    "an old battery sags to 3.25 V a cell under load",
                    "a battery sags to 3.1 V a cell",
                    "a battery sags to 3.1 V a cell for 2 s, in a gust",
                ),
            ),
            Row(
                "the counter of charge stands still or begins again",
                "counts by time and voltage from there; reported after {reported*}",
                "nothing to do in the air; look at the battery monitor afterwards",
                ("the counter of charge stands still", "the counter of charge begins at 100 % again"),
            ),
            Row(
                "on the ground: charge, voltage or number of cells is wrong or not known",
                "does not arm",
                "the checks **Battery** and **Battery thresholds** name the remedy",
                (
                    "the battery falls to 10 % on the ground",
                    "11.0 V and “100 %” on the ground",
                    "3.53 V a cell on the ground",
                    "no voltage is measured on the ground",
                    "two cells in place of three",
                    "four cells where the autopilot's threshold is for three",
                ),
            ),
        ),
    ),
    Subject(
        "Camera",
        (
            Row(
                "no picture, broken ones, or the same picture again and again",
                "ends a task after {Hover}; healthy {camera healthy} after the camera is",
                "**Camera** is unhealthy with its reason. On the ground: Arm is refused",
                (
                    "the camera sends no picture",
                    "the camera sends no picture on the ground",
                    "the camera sends broken pictures",
                    "the camera refuses connections",
                    "the camera sends one picture with new time stamps",
                ),
            ),
            Row(
                "the camera is turned, upside down, mirrored, or comes loose",
                "ends a task and maps no more; camera unhealthy after {camera unhealthy} of exploring",
                "the message names the value of `camera.mount_yaw_deg` that fits",
                (
                    "the camera sits turned by 90°",
                    "the camera sits upside down",
                    "the camera mirrors its pictures",
                    "the camera comes loose and turns by 90°",
                ),
            ),
            Row(
                "one damaged picture in ten, wrong or no time stamps, EXIF orientation, bytes behind the picture",
                "explores on; a damaged or badly stamped picture is left out",
                "nothing to do",
                (
                    "3 kB are lost within one picture of ten",
                    "the camera sends no time stamps",
                    "the camera's stamps step back by 0.5 s",
                    "the camera's stamps step ahead by 0.9 s",
                    "pictures claim an EXIF orientation",
                    "4000 bytes follow each picture's end",
                ),
            ),
            Row(
                "no picture during the return",
                "returns and lands as ever",
                "nothing to do",
                ("the camera sends no picture while the drone returns",),
            ),
        ),
    ),
    Subject(
        "Pilot and operators",
        (
            Row(
                "the pilot takes over",
                "Manual after {Manual}; sends nothing until **Resume**",
                "give the drone back by the switch, then **Resume**",
                ("the pilot takes over",),
            ),
            Row(
                "the remote control is lost",
                "the autopilot's failsafe returns: mode RTL after {mode RTL}",
                "nobody can take over by hand: let it land",
                ("the pilot's radio is lost",),
            ),
            Row(
                "the operator is gone",
                "holds after `operator.operator_timeout_s`, returns home `operator.operator_hold_s` later",
                "**Take control** in time and it holds for you; anyone may send it home or land it",
                (
                    "the operator is gone",
                    "the operator is gone and comes back",
                    "the operator is gone and somebody else lands it",
                ),
            ),
            Row(
                "somebody without control sends it home; a flood of requests or commands",
                "refuses the first, answers the one in control: Hover after {Hover}",
                "nothing to do",
                (
                    "somebody without control sends it home",
                    "a thousand half requests",
                    "a viewer asks for 250 costly answers at once",
                ),
            ),
            Row(
                "the operator cuts the motors",
                "motors off after {motors off}; it falls",
                "look at the drone, then **Allow arming again**",
                ("the operator cuts the motors",),
            ),
            Row(
                "armed, and nobody takes off",
                "motors off after {motors off}",
                "**Arm** again",
                ("nobody takes off",),
            ),
        ),
    ),
    Subject(
        "Other ground stations",
        (
            Row(
                "another station lands it, sends it home, stops it, or sends it to a place",
                "follows; the task ends",
                "the message names the station where the link carries its messages. **Hold** takes it back",
                (
                    "a second station lands it",
                    "a second station sends it home",
                    "a second station stops it",
                    "a second station sends it 30 m away by a target of its own",
                ),
            ),
            Row(
                "another station changes a failsafe, a threshold or the return height",
                "puts it back; reported and right again after {reported*}",
                "no new task until then. Close the other station",
                (
                    "a second station sets BATT_FS_LOW_ACT to 5, which cuts the motors",
                    "a second station sets BATT_FS_CRT_ACT to 5, which cuts the motors",
                    "a second station sets RTL_ALT to 300 m",
                    "a second station sets BATT_LOW_VOLT to 0",
                    "a second station sets FENCE_ACTION to 0",
                    "a second station sets FENCE_ENABLE to 0",
                    "a second station sets FS_GCS_ENABLE to 0",
                    "a second station turns our failsafe off",
                ),
            ),
            Row(
                "another station clears, replaces or switches off the fence",
                "uploads it again: in force after {the fence as before, “ence”}; after the fourth change in a minute "
                "it returns home",
                "no new task until then. Close the other station",
                (
                    "a second station turns the fence off",
                    "a second station switches the fence off by a command",
                    "a second station clears the fence",
                    "a second station clears the fence, and again and again",
                    "a second station replaces the fence by a wide one",
                    "a second station replaces the fence by one that is elsewhere",
                    "a second station clears the fence between Arm and Takeoff",
                    "after the fence is cleared no task begins until it is back",
                ),
            ),
            Row(
                "another station moves home",
                "sets it back; the fourth time within a minute it returns home",
                "close the other station",
                ("a second station moves home", "a second station moves home every 6 s"),
            ),
            Row(
                "another station uploads rally points",
                "clears them in flight, reported after {reported*}; returns home, not there. On the ground: no Arm",
                "remove them from the autopilot",
                (
                    "a second station uploads a rally point 44 m from home",
                    "a rally point is there before the flight",
                    "rally points come while the drone returns",
                    "a second station clears the fence and uploads a rally point outside",
                ),
            ),
            Row(
                "another station, or a failure, stops the motors in the air",
                "“Motors off in the air”, in red, after {“otors off in the air”}; Arm stays locked",
                "the message has place and time. Look at the drone, then **Allow arming again**",
                ("a second station cuts the motors in the air", "the motors stop in the air by themselves"),
            ),
        ),
    ),
    Subject("People", ()),
    Subject(
        "Program and computer",
        (
            Row(
                "the program ends or hangs",
                "is started again: shows itself after {the daemon runs again}; holds, a return or landing goes on",
                "control, map and survey are there; go on",
                ("our program is killed", "our program stands still"),
            ),
            Row(
                "the program ends twice within a minute in the air",
                "mode RTL {mode RTL} after the second end",
                "let it land; send `hawk-drone doctor`",
                ("our program is killed twice within a minute",),
            ),
            Row(
                "the program is stopped in the air (SIGTERM)",
                "asks for RTL first (mode RTL after {mode RTL}), then it ends",
                "never stop it in the air",
                ("our program gets SIGTERM",),
            ),
            Row(
                "a second daemon is started",
                "the second ends, or waits and names the first; the flight goes on",
                "stop one of them",
                (
                    "a second daemon is started on the same store",
                    "a second daemon is started on the same autopilot",
                ),
            ),
            Row(
                "the disk is full",
                "reports it after {reported*} and flies on without a recording; starts are counted in memory",
                "land, free the disk",
                ("the disk is full", "the disk is full and our program is killed twice"),
            ),
            Row(
                "the clock of the computer steps",
                "changes nothing, across starts too",
                "nothing to do",
                (
                    "the wall clock steps by 31 minutes and our program is killed",
                    "the wall clock steps back by an hour and our program is killed twice",
                    "the wall clock steps by three days between two starts",
                ),
            ),
        ),
    ),
)
