"""A run: rounds of fuzzed messages, a witness whose commands must all be answered, and bare connections beside."""

from __future__ import annotations

import asyncio
import random
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import aiohttp

from proving.fuzz.answers import id_of, problem_with
from proving.fuzz.cases import Case, Cases
from proving.fuzz.rig import FuzzClient, FuzzRig
from proving.fuzz.wire import exchange, frames, request

ROUND: Final = 32
"""Messages in flight: a client that leaves 64 answers unread is disconnected."""
WIRE_SHARE: Final = 0.03
"""Connections with fuzzed bytes, by message."""
WIRES: Final = 64
"""Such connections at one time."""
CONTROL_ROUNDS: Final = 20
"""Rounds after which control goes from the witness to the fuzzer, and back."""
FINDINGS: Final = 20
"""A run with this number of findings ends."""
_WITNESS: Final = ('{"Type": "Heartbeat", "Id": "%s"}', '{"Type": "Arm", "Id": "%s"}')


@dataclass(slots=True)
class Result:
    """Counts, and what was found: each with the number of its case."""

    messages: int = 0
    connections: int = 0
    accepted: int = 0
    refused: int = 0
    witnessed: int = 0
    seconds: float = 0.0
    memory_mb: float = 0.0
    """Growth of this process, client and server, from the first tenth of the run to its end."""
    reasons: Counter[str] = field(default_factory=Counter)
    findings: list[str] = field(default_factory=list)


class Run:
    """Sends cases ``first`` to ``first + messages`` of a seed."""

    def __init__(self, folder: Path, seed: int, messages: int, first: int = 0) -> None:
        self._rig = FuzzRig(folder)
        self._cases = Cases(seed)
        self._seed = seed
        self._rng = random.Random(f"wire:{seed}:{first}")
        self._wires: set[asyncio.Task[None]] = set()
        self._numbers = range(first, first + messages)
        self.result = Result()

    @property
    def rig(self) -> FuzzRig:
        """The rig that the messages are sent to."""
        return self._rig

    async def run(self, report: Callable[[Result], None] = lambda _: None) -> Result:
        """Send everything; ``report`` is called after each hundredth."""
        result, begun = self.result, time.monotonic()
        memory: float | None = None
        async with self._rig.open(), aiohttp.ClientSession() as session:
            witness, fuzzer = await self._client(session), await self._client(session)
            for at in range(0, len(self._numbers), ROUND):
                numbers = self._numbers[at : at + ROUND]
                fuzzer = fuzzer if not fuzzer.has_left else await self._client(session)
                await self._pass_control(at // ROUND, witness, fuzzer)
                await self._round(numbers, witness, fuzzer)
                self._note_faults(f"cases {numbers[0]} to {numbers[-1]}")
                result.messages += len(numbers)
                result.seconds = time.monotonic() - begun
                if memory is None and at >= len(self._numbers) // 10:
                    memory = memory_mb()
                if (at // ROUND) % max(32, len(self._numbers) // ROUND // 100) == 0:
                    report(result)
                if len(result.findings) >= FINDINGS:
                    break
            await asyncio.gather(*self._wires)
            for client in (witness, fuzzer):
                await client.close()
        result.memory_mb = memory_mb() - (memory or 0.0)
        self._note_faults("the end")
        return result

    async def _client(self, session: aiohttp.ClientSession) -> FuzzClient:
        return FuzzClient(await session.ws_connect(f"{self._rig.server.url}ws", max_msg_size=0))

    async def _pass_control(self, number: int, witness: FuzzClient, fuzzer: FuzzClient) -> None:
        if number % CONTROL_ROUNDS:
            return
        owner, other = (witness, fuzzer) if number // CONTROL_ROUNDS % 2 == 0 else (fuzzer, witness)
        for client, action in ((other, "Release"), (owner, "Request")):
            await client.send(f'{{"Type": "Control", "Action": "{action}"}}')
            if not await client.answered(self._rig, 1):
                self._find(f"round {number}", "a request for control was not answered")

    async def _round(self, numbers: range, witness: FuzzClient, fuzzer: FuzzClient) -> None:
        """Send a round with the witness's commands in its middle, and connections beside it."""
        await self._begin_wires(sum(self._rng.random() < WIRE_SHARE for _ in numbers))
        cases = [self._cases.at(number) for number in numbers]
        asked = [f"{kind}-{numbers[0]}" for kind in range(len(_WITNESS))]
        for position, case in enumerate(cases):
            if position == len(cases) // 2:
                for text, name in zip(_WITNESS, asked, strict=True):
                    await witness.send(text % name)
            await fuzzer.send(case.message)
        answers = await fuzzer.answered(self._rig, len(cases))
        self._judge(numbers, cases, answers, fuzzer.has_left)
        heard = [answer.get("Id") for answer in await witness.answered(self._rig, len(asked))]
        if sorted(map(str, heard)) != sorted(asked):
            self._find(f"cases {numbers[0]} to {numbers[-1]}", f"the witness asked {asked} and heard {heard}")
        self.result.witnessed += len(heard)

    async def _begin_wires(self, count: int) -> None:
        """Open ``count`` connections; the rounds go on beside them."""
        while len(self._wires) + count > WIRES:
            await self._rig.tick()
            await asyncio.sleep(0.005)
        for _ in range(count):
            self.result.connections += 1
            task = asyncio.create_task(self._wire(self.result.connections))
            self._wires.add(task)
            task.add_done_callback(self._wires.discard)

    def _judge(self, numbers: range, cases: list[Case], answers: list[dict[str, Any]], left: bool) -> None:
        if len(answers) != len(cases):
            self._find(
                f"cases {numbers[0]} to {numbers[-1]}",
                f"{len(cases)} messages, {len(answers)} answers{', and the server hung up' if left else ''}",
            )
            return
        sent: dict[str | int | None, list[tuple[int, Case]]] = {}
        for number, case in zip(numbers, cases, strict=True):
            sent.setdefault(id_of(case.message), []).append((number, case))
        for answer in answers:
            accepted = answer["Type"] != "Ack" or bool(answer["Accepted"])
            self.result.accepted += accepted
            self.result.refused += not accepted
            if not accepted:
                self.result.reasons[str(answer["Reason"])[:40]] += 1
            possible = sent.get(answer["Id"], [])
            problems = [problem_with(case, answer) for _, case in possible]
            if not possible:
                self._find(f"cases {numbers[0]} to {numbers[-1]}", f"an answer to an Id that was not sent: {answer}")
            elif all(problems):
                self._find(f"case {possible[0][0]}", problems[0])

    async def _wire(self, number: int) -> None:
        rng = random.Random(f"{self._seed}:wire:{number}")
        port = self._rig.server.port
        is_socket = rng.random() < 0.3
        path = rng.choice(("/ws", "/video")) if is_socket else None
        data = frames(rng) if is_socket else request(rng, port)
        if problem := await exchange(port, data, path):
            self._find(f"connection {number} ({data[:200]!r})", problem)

    def _note_faults(self, where: str) -> None:
        for text in self._rig.faults.found:
            self._find(where, text)
        self._rig.faults.found.clear()

    def _find(self, where: str, what: str) -> None:
        self.result.findings.append(f"{where}: {what}")


def memory_mb() -> float:
    """Return the resident memory of this process, megabytes (proc(5), status, VmRSS)."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024
