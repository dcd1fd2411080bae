"""Remedy where a package of an extra is missing: it comes with hawk's wheel. No index has a package of its name."""

from __future__ import annotations

from importlib.metadata import version


def remedy(extra: str) -> str:
    """Return the command that adds an extra, from the wheel."""
    wheel = f"hawk_drone-{version('hawk-drone')}-py3-none-any.whl"
    return f"install it from hawk's wheel: pip install './{wheel}[{extra}]'"
