"""The progress bar of a survey."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from hawk.survey import operator


class SurveyProgress:
    """Shows phase, share seen of the lot found so far, stalls found, height and battery on standard error."""

    def __init__(self, *, quiet: bool, console: Console | None = None) -> None:
        self._bar = Progress(
            TextColumn("{task.description:<14}"),
            BarColumn(bar_width=30),
            TextColumn("{task.fields[facts]}"),
            TimeElapsedColumn(),
            console=console or Console(stderr=True),
            disable=quiet,
        )
        self._task: TaskID | None = None

    def __enter__(self) -> Self:
        self._bar.start()
        self._task = self._bar.add_task("Connecting", total=1.0, facts="")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._bar.stop()

    def show(self, progress: operator.Progress) -> None:
        """Show one heartbeat."""
        if self._task is None:
            return
        beat = progress.heartbeat
        height = "–" if beat.relative_altitude is None else f"{beat.relative_altitude:.0f} m"
        battery = "–" if beat.battery_percentage is None else f"{beat.battery_percentage:.0f} %"
        seen = "" if beat.explored is None else f"{100 * beat.explored:.0f} % seen so far · "
        self._bar.update(
            self._task,
            description=progress.phase,
            completed=beat.explored or 0.0,
            facts=f"{seen}{beat.free} free, {beat.taken} taken, {beat.unknown} unclear · {height} · battery {battery}",
        )
