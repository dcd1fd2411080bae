"""The autopilot's parameters by PARAM_REQUEST_READ and PARAM_SET, several at once, each with the autopilot's type.

MAVSDK's Param plugin asks one at a time, takes 3 s for an unknown name, and writes a value of the wrong type before it
complains; here such a value is refused before it is sent.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Awaitable, Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.model.sentences import say

Send = Callable[[str, Mapping[str, Any]], Awaitable[None]]
"""Sends one message off the loop. Raises AutopilotError."""

_RANGES = {
    1: (0, 2**8 - 1),
    2: (-(2**7), 2**7 - 1),
    3: (0, 2**16 - 1),
    4: (-(2**15), 2**15 - 1),
    5: (0, 2**32 - 1),
    6: (-(2**31), 2**31 - 1),
}
"""MAV_PARAM_TYPE of whole numbers with their range; every other type is a real number."""

TRIES = 4
HOLD_ASKS = 6
"""A value is set and read back for this many times ``answer_s`` (3 s): a set may be confirmed before it holds."""
NAME_CHARACTERS = 16


class AutopilotParameters:
    """Reads and sets parameters; keeps the read values. Lives on the loop."""

    def __init__(self, send: Send, answer_s: float = 0.5) -> None:
        """Begin with nothing read. ``answer_s``: real seconds until a request is repeated."""
        self._send = send
        self._answer_s = answer_s
        self._values: dict[str, float | int] = {}
        self._types: dict[str, int] = {}
        self._waiters: dict[str, set[asyncio.Future[float | int]]] = {}

    @property
    def values(self) -> Mapping[str, float | int]:
        """Values read since the autopilot booted."""
        return MappingProxyType(self._values)

    def forget(self) -> None:
        """Forget all values: the autopilot has booted."""
        self._values.clear()
        self._types.clear()

    def take(self, fields: Mapping[str, Any]) -> None:
        """Take a PARAM_VALUE; a malformed one is dropped."""
        name, value, kind = fields.get("param_id"), fields.get("param_value"), fields.get("param_type")
        if not isinstance(name, str) or not isinstance(value, (int, float)) or not isinstance(kind, int):
            return
        if not math.isfinite(value):
            return
        typed = round(value) if kind in _RANGES else float(value)
        self._values[name] = typed
        self._types[name] = kind
        for waiter in self._waiters.pop(name, ()):
            if not waiter.done():
                waiter.set_result(typed)

    async def read_many(self, names: Iterable[str]) -> dict[str, float | int | None]:
        """Read parameters concurrently; None for those that the autopilot does not have or did not answer."""
        wanted = list(dict.fromkeys(names))
        found = await asyncio.gather(*(self._read(name) for name in wanted))
        return dict(zip(wanted, found, strict=True))

    async def get(self, name: str) -> float | int:
        """Read one parameter. Raises AutopilotError when the autopilot does not answer for it."""
        value = await self._read(name)
        if value is None:
            raise AutopilotError(say("{name}: the autopilot does not answer for a parameter of this name", name=name))
        return value

    async def set(self, name: str, value: float) -> None:
        """Set one parameter with the autopilot's own type, and read it back until the value holds.

        ArduPilot has confirmed a value and given the old one to a read a moment later.

        Raises:
            AutopilotError: It is not sent, not confirmed, or does not hold within HOLD_ASKS times ``answer_s``.
        """
        if not math.isfinite(value):
            raise AutopilotError(say("{name}: {value} is not a finite number: not sent", name=name, value=str(value)))
        if name not in self._types:
            await self.get(name)
        kind = self._types[name]
        _check_type(name, value, kind)
        fields = {"param_id": name, "param_value": float(value), "param_type": kind}
        deadline = time.monotonic() + HOLD_ASKS * self._answer_s
        while True:
            said = await self._ask(name, "PARAM_SET", fields)
            if _is_same(said, value):
                said = await self._ask(name, "PARAM_REQUEST_READ", {"param_id": name, "param_index": -1})
                if _is_same(said, value):
                    return
            if time.monotonic() >= deadline:
                break
            await asyncio.sleep(self._answer_s / 10)
        if said is None:
            raise AutopilotError(say("{name}: the autopilot did not confirm {value:g}", name=name, value=value))
        raise AutopilotError(
            say("{name}: set to {value:g}, but the autopilot says {said:g}", name=name, value=value, said=said)
        )

    async def _read(self, name: str) -> float | int | None:
        if not 0 < len(name) <= NAME_CHARACTERS:
            raise AutopilotError(
                say("{name}: a parameter's name has 1 to {most} characters", name=repr(name), most=NAME_CHARACTERS)
            )
        for _ in range(TRIES):
            answer = await self._ask(name, "PARAM_REQUEST_READ", {"param_id": name, "param_index": -1})
            if answer is not None:
                return answer
        return None

    async def _ask(self, name: str, message: str, fields: Mapping[str, Any]) -> float | int | None:
        """Send once and wait for the next PARAM_VALUE of that name; None when none came in time."""
        waiter: asyncio.Future[float | int] = asyncio.get_running_loop().create_future()
        self._waiters.setdefault(name, set()).add(waiter)
        try:
            await self._send(message, fields)
            async with asyncio.timeout(self._answer_s):
                return await waiter
        except TimeoutError:
            return None
        finally:
            self._waiters.get(name, set()).discard(waiter)


def _is_same(said: float | None, value: float) -> bool:
    """Compare as the autopilot's single precision does."""
    return said is not None and math.isclose(said, value, rel_tol=1e-6, abs_tol=1e-6)


def _check_type(name: str, value: float, kind: int) -> None:
    limits = _RANGES.get(kind)
    if limits is None:
        return
    if value != round(value):
        raise AutopilotError(
            say(
                "{name}: {value:g} is not a whole number, as the autopilot's parameter is: not sent",
                name=name,
                value=value,
            )
        )
    if not limits[0] <= value <= limits[1]:
        raise AutopilotError(
            say(
                "{name}: {value:g} is outside {low} to {high}: not sent",
                name=name,
                value=value,
                low=limits[0],
                high=limits[1],
            )
        )
