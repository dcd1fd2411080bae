"""Progress of a long work: a bar with the time left for a person, or a line of JSON a step for a program."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, TextIO

from hawk.picture.values import Progress
from hawk.runtime.late import late

if TYPE_CHECKING:
    from rich import console, progress
else:
    console = late("rich.console")
    progress = late("rich.progress")

_LINE_S: Final = 1.0


@contextmanager
def shown_progress(out: TextIO, *, as_json: bool) -> Iterator[Progress]:
    """Give the function that shows progress on a stream."""
    if as_json:
        yield _lines(out)
        return
    columns = (
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left"),
        progress.TimeRemainingColumn(),
    )
    with progress.Progress(*columns, console=console.Console(file=out)) as bar:
        tasks: dict[str, int] = {}

        def show(step: str, done: int, count: int) -> None:
            if step not in tasks:
                for task in tasks.values():
                    bar.update(task, completed=bar.tasks[task].total)  # type: ignore[arg-type]
                tasks[step] = bar.add_task(step, total=max(count, 1))
            bar.update(tasks[step], completed=done, total=max(count, 1))  # type: ignore[arg-type]

        yield show


def _lines(out: TextIO) -> Progress:
    """Return the function that writes a line a step, and one a second within it."""
    began: dict[str, float] = {}
    last = [0.0]

    def show(step: str, done: int, count: int) -> None:
        now = time.monotonic()
        is_new = step not in began
        began.setdefault(step, now)
        if not is_new and now - last[0] < _LINE_S and done < count:
            return
        last[0] = now
        took = now - began[step]
        left = round(took / done * (count - done), 1) if done else None
        line = {"event": "progress", "step": step, "done": done, "of": count, "seconds_left": left}
        print(json.dumps(line), file=out, flush=True)

    return show
