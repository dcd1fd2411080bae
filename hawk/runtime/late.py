"""Modules that are loaded by their first use, on the thread that uses them, not by the start of the program.

A module that is called late is imported for types beside it, so that its calls are checked as any other ones::

    if TYPE_CHECKING:
        from hawk.lots import queries
    else:
        queries = late("hawk.lots.queries")
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


class _Late:
    """Stands for a module; each name of it is that of the module."""

    def __init__(self, name: str) -> None:
        self._module = name

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self._module), name)

    def __repr__(self) -> str:
        return f"<late {self._module}>"


def late(module: str) -> Any:
    """Return what stands for a module until it is used."""
    return _Late(module)
