"""Reads a Containerfile: instructions by stage, and labels as an engine reads them."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[3]
CONTAINERFILE = ROOT / "packaging" / "container" / "Containerfile"


@dataclass
class Stage:
    """``base``: what FROM names, an image or a stage before."""

    base: str
    name: str
    instructions: list[tuple[str, str]] = field(default_factory=list)

    def all(self, instruction: str) -> list[str]:
        """Return the arguments of every instruction of this name."""
        return [words for name, words in self.instructions if name == instruction]

    def labels(self) -> dict[str, str]:
        """Return the labels."""
        pairs = [word.partition("=") for words in self.all("LABEL") for word in shlex.split(words)]
        return {key: value for key, _, value in pairs}

    def environment(self) -> dict[str, str]:
        """Return what ENV sets."""
        return dict(word.split("=", 1) for words in self.all("ENV") for word in shlex.split(words))


def read(path: Path = CONTAINERFILE) -> tuple[dict[str, str], list[Stage]]:
    """Return the arguments that stand before the first stage, and the stages."""
    text = "\n".join(line for line in path.read_text("utf-8").splitlines() if not line.startswith("#"))
    arguments: dict[str, str] = {}
    stages: list[Stage] = []
    for line in re.sub(r"\\\n", "", text).splitlines():
        name, _, words = line.strip().partition(" ")
        if name == "FROM":
            base, _, stage = words.partition(" AS ")
            stages.append(Stage(base, stage))
        elif name == "ARG" and not stages:
            key, _, value = words.partition("=")
            arguments[key] = value
        elif name:
            stages[-1].instructions.append((name, words.strip()))
    return arguments, stages


def words_of(text: str) -> list[str]:
    """Return the words of ENTRYPOINT, CMD or VOLUME, which are JSON here. Raises ValueError for a shell's line."""
    found = json.loads(text)
    assert isinstance(found, list)
    return [str(word) for word in found]
