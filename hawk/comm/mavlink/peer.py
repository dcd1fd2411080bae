"""Whose datagrams are the autopilot's. Secret: the rule by which a sender is kept, and when another one replaces it.

UDP has no connection: anybody who reaches the port can send. The first sender of a copter's HEARTBEAT is kept while it
is heard; an antenna tracker or a rover is none. Without MAVLink signing nothing distinguishes a forged sender's address
from a true one; the limits of this rule are in docs/threat-model.md.
"""

from __future__ import annotations

import ipaddress
import threading
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from hawk.comm.mavlink.frames import AUTOPILOT_COMPONENT, GROUND_STATION, Heartbeat, heartbeats, kind_words, system_of
from hawk.model.sentences import say, semicolons, series

K = TypeVar("K")
Address = tuple[str, int]
"""Host (a number, not a name) and port."""

SILENT_S: Final = 3.0
"""Real seconds of silence after which another port of the kept host is heard: its router has started again."""
OTHER_HOST_S: Final = 30.0
"""The same for another host; the autopilot's ground-station failsafe (5 s) has acted long before."""
OVERLAP_S: Final = 0.5
"""A sender that was heard this long before the kept one's last datagram is a rival: it never replaces the kept one."""
SHOWN_S: Final = 10.0
"""Real seconds after its last datagram for which a second sender is shown."""
SEVERAL: Final = "Several copters are heard"
"""Beginning of `several_words`."""
_REMEMBERED: Final = 256
"""Second senders, and copters, that are remembered; the oldest is forgotten first."""
_NAMED: Final = 8
"""Copters that are named at most: forged ones may be many."""


@dataclass(frozen=True, slots=True)
class Expected:
    """The autopilot that is expected. None: the first one that is heard."""

    system_id: int | None = None
    host: str | None = None
    port: int | None = None
    wait_s: float = 0.0
    """Real seconds in which a second copter is waited for before one is kept that nobody named."""

    def allows(self, sender: Address) -> bool:
        """Return True when the autopilot may send from this address."""
        host, port = sender
        return self.host in (None, plain_host(host)) and self.port in (None, port)


FIRST_HEARD: Final = Expected()
"""No autopilot in particular."""


@dataclass(frozen=True, slots=True)
class _Shown:
    """The second sender that is shown. Frozen: other threads read it."""

    key: Address | str
    words: str
    last: float


class PeerKeeper:
    """Keeps one sender. One thread calls it; others may read `kept`, `refused`, `system_id` and `second_sender`."""

    def __init__(self, expected: Expected) -> None:
        self._expected = expected
        self._heard = 0.0
        self._strangers: dict[Address | str, float] = {}  # when each was heard first
        self._shown: _Shown | None = None
        self._copters: dict[tuple[Address, int], tuple[float, float]] = {}  # when first and last heard
        self.kept: Address | None = None
        """The sender that is heard; None before the first HEARTBEAT of a copter."""
        self.system_id = expected.system_id
        """The autopilot's MAVLink system id: as expected, else that of the first one heard."""
        self.refused = 0
        """Datagrams of other senders."""

    def heard(self, now: float) -> None:
        """Note a datagram of the kept sender. ``now``: monotonic real seconds."""
        self._heard = now

    def admit(self, sender: Address, datagram: bytes, now: float) -> bool:
        """Return True when a datagram is the autopilot's; it may make its sender the kept one."""
        if sender != self.kept:
            if not self._replaces(sender, datagram, now):
                self.refused += 1
                return False
            self._strangers.pop(self._key(sender), None)
            self.kept = sender
            self._shown = None
        self._heard = now
        return True

    def second_sender(self, now: float) -> str:
        """Return words for a sender that is not the autopilot, while it is heard; else an empty text."""
        shown = self._shown
        return "" if shown is None or now - shown.last > SHOWN_S else shown.words

    def _replaces(self, sender: Address, datagram: bytes, now: float) -> bool:
        found = [beat for beat in heartbeats(datagram) if beat.is_of_an_autopilot]
        if self.kept is None and not found:
            return False  # an autopilot's first second, or noise
        beats = [beat.system for beat in found if beat.is_of_a_copter]
        is_expected = self._expected.allows(sender) and (self.system_id in beats if self.system_id else bool(beats))
        is_awaited = is_expected and self.kept is None
        first = self._first_heard(sender, now) if is_awaited else self._note(sender, datagram, now)
        if not is_expected:
            return False
        if is_awaited and self.system_id is None and not self._is_alone(sender, beats, now):
            return False
        if self.kept is not None:
            wait = SILENT_S if plain_host(sender[0]) == plain_host(self.kept[0]) else OTHER_HOST_S
            if now - self._heard < wait or self._heard - first > OVERLAP_S:
                return False
        self.system_id = self.system_id or beats[0]
        return True

    def _is_alone(self, sender: Address, systems: list[int], now: float) -> bool:
        """Return True when one copter only was heard for the time to wait."""
        for system in systems:
            first, _ = self._copters.get((sender, system), (now, now))
            _make_room(self._copters, (sender, system))
            self._copters[sender, system] = (first, now)
        heard = {key: first for key, (first, last) in self._copters.items() if now - last <= SILENT_S}
        if len(heard) > 1:
            names = series(
                *(
                    say("system {system} at {place}", system=number, place=address_text(at))
                    for at, number in sorted(heard)[:_NAMED]
                )
            )
            self._shown = _Shown(sender, several_words(names), now)
            return False
        return now - min(heard.values()) >= self._expected.wait_s

    def _note(self, sender: Address, datagram: bytes, now: float) -> float:
        """Remember a stranger and show it, unless another one is shown; return when it was heard first."""
        key, shown = self._key(sender), self._shown
        if shown is None or now - shown.last > SHOWN_S:
            self._shown = _Shown(key, self._words(sender, datagram), now)
        elif shown.key == key:
            self._shown = _Shown(key, shown.words, now)
        return self._first_heard(sender, now)

    def _first_heard(self, sender: Address, now: float) -> float:
        key = self._key(sender)
        _make_room(self._strangers, key)
        return self._strangers.setdefault(key, now)

    def _key(self, sender: Address) -> Address | str:
        """Return a name by which a sender is known again: another host's ports are one sender, it can change them."""
        host = plain_host(sender[0])
        return sender if self.kept is not None and host == plain_host(self.kept[0]) else host

    def _words(self, sender: Address, datagram: bytes) -> str:
        system = system_of(datagram)
        place = address_text(sender)
        who = (
            say("{place} (no MAVLink)", place=place)
            if system is None
            else say("{place} (system {system})", place=place, system=system)
        )
        if self.kept is None:
            beat = next((beat for beat in heartbeats(datagram) if beat.is_of_an_autopilot), None)
            if beat is not None and not beat.is_of_a_copter:
                kind = kind_words(beat.kind, beat.autopilot)
                return say("{who} sends to the autopilot's port, but is no ArduCopter: {kind}.", who=who, kind=kind)
            return say("{who} sends to the autopilot's port, but is not the expected autopilot.", who=who)
        return say("{who} sends to the autopilot's port, too. It is not heard.", who=who)


def _make_room(table: dict[K, Any], key: K) -> None:
    """Forget the oldest entry where another key would be one too many."""
    if key not in table and len(table) >= _REMEMBERED:
        del table[next(iter(table))]


def several_words(names: str) -> str:
    """Return words on several copters; they begin with `SEVERAL`."""
    return say(
        "Several copters are heard: {names}. Name yours in autopilot.vehicle_system_id, autopilot.vehicle_address.",
        names=names,
    )


def plain_host(host: str) -> str:
    """Return a host without the IPv6 form of an IPv4 address."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    mapped = getattr(address, "ipv4_mapped", None)
    return str(mapped or address)


def address_text(address: Address) -> str:
    """Return ``HOST:PORT``, with brackets about IPv6."""
    host = plain_host(address[0])
    return f"[{host}]:{address[1]}" if ":" in host else f"{host}:{address[1]}"


"""Real seconds after its last HEARTBEAT for which a system is shown."""


@dataclass(frozen=True, slots=True)
class _Member:
    """The last HEARTBEAT of a component, when it came, and when the first one did."""

    beat: Heartbeat
    heard: float
    first: float


class Roster:
    """The systems on one link by their HEARTBEATs. Callable on every thread; ``now`` is monotonic real seconds."""

    def __init__(self, own_id: int) -> None:
        """``own_id``: our MAVLink system id."""
        self._own_id = own_id
        self._lock = threading.Lock()
        self._members: dict[tuple[int, int], _Member] = {}

    def take(self, beat: Heartbeat, now: float) -> None:
        """Note a HEARTBEAT."""
        with self._lock:
            key = (beat.system, beat.component)
            before = self._members.get(key)
            self._members[key] = _Member(beat, now, now if before is None else before.first)  # keeps its place

    def vehicle(self, wanted: int | None, now: float, wait_s: float = 0.0) -> int | None:
        """Return the system id of the copter: ``wanted``, else the only one that was heard for ``wait_s``; else None.

        Without a time to wait the first one is taken.
        """
        copters = self._copters(now)
        if wanted is not None or not wait_s:
            return next((each.beat.system for each in copters if wanted in (None, each.beat.system)), None)
        is_sure = len(copters) == 1 and now - copters[0].first >= wait_s
        return copters[0].beat.system if is_sure else None

    def several(self, now: float) -> str:
        """Return the copters in words when there are several; else empty."""
        copters = self._copters(now)
        return semicolons(*(_named(each.beat) for each in copters)) if len(copters) > 1 else ""

    def names(self, now: float) -> str:
        """Return what is heard, in words; empty when nothing is."""
        return semicolons(*(_named(each) for each in self._heard(now)))

    def other_vehicles(self, vehicle: int, now: float) -> str:
        """Return the copters that are heard besides the vehicle, in words; empty when there is none."""
        others = (each for each in self._heard(now) if each.is_of_a_copter and each.system != vehicle)
        return semicolons(*(_named(each) for each in others))

    def twin(self, now: float) -> str:
        """Return words for a ground station with our own id; empty when there is none."""
        found = (each for each in self._heard(now) if each.system == self._own_id and each.kind == GROUND_STATION)
        each = next(found, None)
        return (
            "" if each is None else say("{named}, component {component}", named=_named(each), component=each.component)
        )

    def _copters(self, now: float) -> list[_Member]:
        with self._lock:
            members = list(self._members.values())
        return [each for each in members if now - each.heard <= SHOWN_S and each.beat.is_of_a_copter]

    def _heard(self, now: float) -> list[Heartbeat]:
        with self._lock:
            return [each.beat for each in self._members.values() if now - each.heard <= SHOWN_S]


def _named(beat: Heartbeat) -> str:
    kind = kind_words(beat.kind, beat.autopilot)
    if beat.component == AUTOPILOT_COMPONENT or beat.kind == GROUND_STATION:
        return say("{kind}, system {system}", kind=kind, system=beat.system)
    return say("{kind}, system {system}.{component}", kind=kind, system=beat.system, component=beat.component)
