"""Performer: the one room that acts. It performs decided values; their outcomes are facts of the next tick."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

from hawk.comm.protocol.heartbeat import CommandSocket
from hawk.ddc import acts as actions
from hawk.ddc.fence import path as fence_path
from hawk.ddc.fence.keepers import FenceKeeper, OutlineKeeper
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.motion import Goal
from hawk.ddc.parameters.heights import ParameterStore
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.requests.flight_log import FlightLog
from hawk.ddc.requests.requests import FenceChecks, Outcomes, Requests
from hawk.ddc.requests.service_interface import DdcServiceInterface, Sender, TargetRefused
from hawk.model.operation import Fall, StateName
from hawk.model.plans import HeightParameters
from hawk.model.sentences import words_of


@dataclass(frozen=True, slots=True)
class Tools:
    """Everything that acts are performed with."""

    topics: DdcTopicInterface
    service: DdcServiceInterface
    socket: CommandSocket
    requests: Requests
    log: FlightLog
    heights: ParameterStore
    fences: FenceKeeper
    fence_checks: FenceChecks
    outlines: OutlineKeeper
    record: Callable[[str, dict[str, Any]], None]
    count_start: Callable[[], int]
    """Journals a start in the air, restores the flight, and returns the number of starts."""
    begin_survey: Callable[[], None]
    keep_fall: Callable[[Fall | None], None]
    """Journals motors that went off in the air; None: cleared."""
    outcomes: Outcomes = field(default_factory=Outcomes)


VITAL = (actions.Ask, actions.SendTarget, actions.EnterState)
"""Acts that reach the autopilot, or that say what may."""


@dataclass(frozen=True, slots=True)
class Fault:
    """An act that failed. ``is_vital``: the autopilot did not hear of it."""

    error: Exception
    is_vital: bool


class Performer:
    """Performs acts, in their order. A fault in one act does not stop the others."""

    def __init__(self, tools: Tools) -> None:
        self._tools = tools
        self._sender = Sender(StateName.IDLE, may_send_targets=False, holds=False)
        self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="hawk-parameters")
        self._is_closed = False

    def perform(self, acts: actions.Acts) -> list[Fault]:
        """Perform the acts; return the faults of those that failed."""
        faults: list[Fault] = []
        for act in acts:
            try:
                self._perform(act)
            except Exception as error:
                faults.append(Fault(error, isinstance(act, VITAL)))
        return faults

    async def close(self) -> None:
        """End the threads that write files and check fences; wait for a file that is being written. Once is enough."""
        self._tools.fence_checks.close()
        if self._is_closed:
            return
        self._is_closed = True
        await asyncio.get_running_loop().run_in_executor(self._executor, int)  # its one thread is done with the files
        self._executor.shutdown(wait=False)

    def _perform(self, act: actions.Act) -> None:
        tools = self._tools
        match act:
            case actions.Ask(request):
                tools.requests.start(act, lambda: self._call(request))
            case actions.SendTarget(goal):
                self._send(goal)
            case actions.EnterState(name, may_send_targets, holds):
                self._sender = Sender(name, may_send_targets, holds)
                tools.topics.curr_state_pub.publish(name)
                if name is StateName.IDLE:
                    tools.service.forget_held_fence()  # each arming looks at the autopilot's fence again
            case actions.Log(level, text, details):
                tools.log.add(level, text, details)
            case actions.Reply(client, message):
                tools.socket.reply(client, message)
            case actions.JudgeFence():
                tools.fence_checks.ask(act)
            case actions.Record(kind, payload):
                tools.record(kind, dict(payload))
            case actions.ShowUserError(error, text):
                tools.outcomes.user_error, tools.outcomes.user_error_text = error, text
            case _:
                self._publish(act)

    def _publish(self, act: actions.Act) -> None:
        tools = self._tools
        match act:
            case actions.Desire(pose):
                tools.topics.des_pose_pub.publish(pose)
                if pose is not None:
                    tools.outcomes.desired_count = max(tools.outcomes.desired_count, pose.number)
            case actions.AskPlace(pose):
                tools.topics.asked_place_pub.publish(pose)
            case actions.UseHeights(heights):
                tools.topics.heights_pub.publish(heights)
            case actions.UseOutline(outline):
                tools.outlines.use(outline)
            case actions.EndLots(lots):
                tools.outlines.end_lots(lots)
            case actions.TakePlan(plan):
                tools.topics.taken_plan_pub.publish(plan)
            case actions.PutFenceInForce(fence):
                tools.topics.fence_pub.publish(fence)
                self._executor.submit(fence_path.prepare, fence)  # before the first path is asked for, in the air
            case actions.SetDatum(datum):
                tools.service.set_datum(datum)
            case actions.BeginSurvey():
                tools.begin_survey()
            case actions.ForgetAskedModes():
                tools.service.forget_asked_modes()
            case actions.SettleMode(mode):
                tools.service.settle_mode(mode)
            case actions.ForgetHeldFence():
                tools.service.forget_held_fence()
            case actions.SetVoice(speaks):
                tools.service.set_voice(speaks)
            case actions.CountStart():
                tools.outcomes.starts_in_air = tools.count_start()
            case actions.KeepFall(fall):
                tools.keep_fall(fall)
            case _:
                raise TypeError(f"{type(act).__name__} is not known")

    def _send(self, goal: Goal) -> None:
        topics, outcomes = self._tools.topics, self._tools.outcomes
        former = outcomes.target_refusal
        try:
            self._tools.service.send_target(goal, self._sender, topics.get_heights(), topics.fence_pub.value)
        except TargetRefused as refused:
            outcomes.target_refusal = words_of(refused)
            if outcomes.target_refusal != former:
                self._tools.record("target refused", {"reason": outcomes.target_refusal})
        else:
            outcomes.target_refusal = ""
            sent = {"north": goal.north, "east": goal.east, "height": goal.height, "yaw": goal.yaw}
            self._tools.record("target", sent)

    def _call(self, request: actions.Request) -> Coroutine[Any, Any, Any]:
        service = self._tools.service
        match request:
            case actions.SetArmed(armed):
                return service.set_arm(armed)
            case actions.SetMode(mode):
                return service.set_mode(mode)
            case actions.SendMode(mode):
                return service.send_mode(mode)
            case actions.TakeOff(height):
                return service.send_takeoff_cmd(height)
            case actions.SetReturnAltitude(altitude):
                return service.set_rtl_alt(altitude)
            case actions.UploadFence(fence):
                return service.upload_fence(fence)
            case actions.CompareFence(fence):
                return service.compare_fence(fence)
            case actions.SetHome(place):
                return service.set_home(place)
            case actions.CutMotors():
                return service.kill()
            case actions.ReadParameter(name):
                return service.get_parameter(name)
            case actions.SetParameters(values):
                return service.set_failsafes(dict(values))
            case actions.PutBack(parameter, value):
                return service.put_back(parameter, value)
            case actions.EnableFence():
                return service.enable_fence()
            case actions.StoreHeights(heights):
                return self._store_heights(heights)
        return self._store_fence(request.plan)

    async def _store_heights(self, heights: HeightParameters) -> None:
        await asyncio.get_running_loop().run_in_executor(self._executor, self._tools.heights.write, heights)

    async def _store_fence(self, plan: FencePlan | None) -> None:
        """Write the file off the loop, then plan with the fence, and show it.

        The next Arm uploads it. A drone that a pilot armed meanwhile flies on in the fence that is in force.
        """
        tools = self._tools
        await asyncio.get_running_loop().run_in_executor(self._executor, tools.fences.store, plan)
        tools.fences.use(plan)
        place, datum = tools.topics.get_global_pose(), tools.service.datum
        if place is not None and datum is not None and not tools.topics.may_fly():
            tools.topics.fence_pub.publish(tools.fences.build(datum, place))
