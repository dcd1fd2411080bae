"""A whole survey as a part of a fault's flight, and its measures against the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.survey import report
from hawk.survey.client import DroneClient
from hawk.survey.operator import SurveyOperator, SurveyPlan
from hawk.survey.run import FenceSender
from hawk.survey.stack import SimulatedStack


async def fly_survey(drone: DroneClient, stack: SimulatedStack) -> tuple[dict[str, float], str]:
    """Fly a survey; return its measures against the stack's truth (with its ``status``), and its reason in words."""
    watch = FenceSender(stack)

    def look(_: str, beat: Heartbeat) -> None:
        watch.look(beat)

    outcome = await SurveyOperator(drone, SurveyPlan(set_failsafes=True), look).run()
    await watch.close()
    survey = await drone.survey_map()
    measures = report.compare(survey, stack.truth) if survey is not None and stack.truth is not None else {}
    return {
        **measures,
        "status": float(outcome.status),
        "duration_s": outcome.duration_s or 0.0,
        "distance_flown_m": outcome.distance_m or 0.0,
    }, outcome.reason


def figures(measures: Mapping[str, float]) -> Sequence[str]:
    """Return the measures for the table."""
    if "stall_recall" not in measures:
        return ()
    return (
        f"{measures['found_stalls']:.0f} stalls of {measures['true_stalls']:.0f}",
        f"recall {measures['stall_recall']:.3f}",
        f"precision {measures['stall_precision']:.3f}",
        f"states {measures['state_accuracy']:.1%}",
        f"{measures['distance_flown_m']:.0f} m in {measures['duration_s']:.0f} s",
    )
