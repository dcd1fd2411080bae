"""Flights of the drone: whether one goes on, and what begins and ends with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hawk.daemon.flight_offer import FlightOffer
from hawk.daemon.starts import Starts
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.model.vehicle import VehicleState
from hawk.store.journal import FlightJournal
from hawk.store.recording import Recording
from hawk.versions.flight_state import FlightStateFile


@dataclass(frozen=True, slots=True)
class FlightParts:
    """The parts that note a flight. ``offer``: None for a simulated drone."""

    journal: FlightJournal
    starts: Starts
    recording: Recording
    state_file: FlightStateFile
    offer: FlightOffer | None


class FlightFollower:
    """Listens to the motors, the arm place and the operation state, and passes it on to the parts."""

    def __init__(
        self,
        parts: FlightParts,
        topics: DdcTopicInterface,
        datum: Callable[[], GlobalPose | None],
        note_lots: Callable[[bool], None],
    ) -> None:
        """Listen from now on.

        Args:
            parts: The parts that note it.
            topics: The topics of vehicle and states.
            datum: Returns the datum of the map, None before there is one.
            note_lots: Called with True while a flight goes on: lots are saved after it.
        """
        self._parts = parts
        self._topics = topics
        self._datum = datum
        self._note_lots = note_lots
        topics.vehicle.arm_place.listen(self._keep_arm_place)
        topics.vehicle.state.listen(self._record)
        topics.curr_state_pub.listen(lambda _: self._note())

    @property
    def offer(self) -> FlightOffer | None:
        """The offer after a flight."""
        return self._parts.offer

    @property
    def may_fly(self) -> bool:
        """True for an armed drone, and while nothing is heard for one that flew lately."""
        state = self._topics.vehicle.state.value
        if state is not None and (state.connected or state.armed):
            return self._topics.may_fly()
        return self._parts.starts.flew_lately

    def _keep_arm_place(self, place: ArmPlace) -> None:
        self._parts.journal.set_arm_place(place)
        datum = self._datum()
        if datum is not None:
            self._parts.journal.set_datum(datum)

    def _record(self, state: VehicleState) -> None:
        parts = self._parts
        if state.armed:
            parts.state_file.write(may_fly=True)  # at once: no version is switched from now on
        if state.connected:
            (parts.recording.begin if state.armed else parts.recording.end)()
            if parts.offer is not None:
                parts.offer.note(armed=state.armed)
        self._note()

    def _note(self) -> None:
        """Note whether a flight goes on: a late "disarmed" ends none, its state does."""
        state, may_fly = self._topics.vehicle.state.value, self._topics.may_fly()
        if state is None or not state.connected:
            return
        if not may_fly:
            self._parts.starts.found_disarmed()
        self._note_lots(may_fly)
