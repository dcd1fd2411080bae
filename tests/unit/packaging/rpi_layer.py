"""Reads a layer of rpi-image-gen: fields between METABEGIN and METAEND (DEB822 in comments), then YAML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

ROOT = Path(__file__).parents[3]
LAYER = ROOT / "packaging" / "rpi-image" / "layer" / "hawk-drone.yaml"
CONFIG = ROOT / "packaging" / "rpi-image" / "config" / "hawk-drone.yaml"


def fields(path: Path = LAYER) -> dict[str, str]:
    """Return the fields; a line that begins with a second space goes on."""
    text = path.read_text("utf-8")
    block = re.search(r"^# METABEGIN\n(.*?)^# METAEND\n", text, re.MULTILINE | re.DOTALL)
    assert block is not None
    found: dict[str, str] = {}
    name = ""
    for line in block[1].splitlines():
        words = line.removeprefix("#").removeprefix(" ")
        if not words.strip():
            continue
        if words.startswith(" "):
            found[name] += words
        else:
            name, colon, value = words.partition(":")
            assert colon, line
            assert name not in found, line
            found[name] = value.strip()
    return found


def body(path: Path = LAYER) -> Any:
    """Return what stands behind the fields."""
    return YAML(typ="safe", pure=True).load(path.read_text("utf-8"))


def hooks() -> list[str]:
    """Return the scripts that run in the new root; mmdebstrap runs each by ``sh -c`` with the root's folder as $1."""
    return [str(hook) for hook in body()["mmdebstrap"]["customize-hooks"]]
