"""Modules that are loaded by their first use, on the thread that uses them, not by the start of the program.

A module that is called late is imported for types beside it, so that its calls are checked as any other ones::

    if TYPE_CHECKING:
        from hawk.lots import queries
    else:
        queries = late("hawk.lots.queries")

Where a function of it is handed over before it may be loaded, `late_functions` stands for the module.
"""

from __future__ import annotations

from collections.abc import Callable
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


class _LateFunctions(_Late):
    """Stands for a module; each name of it calls the module's function of that name."""

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*values: Any, **named: Any) -> Any:
            return getattr(import_module(self._module), name)(*values, **named)

        return call


def late(module: str) -> Any:
    """Return what stands for a module until it is used."""
    return _Late(module)


def load(module: str, *parts: str) -> Any:
    """Load a module, and parts of it by their names, now; return it. Raises ImportError where one is not installed."""
    for part in parts:
        import_module(f"{module}.{part}")
    return import_module(module)


def late_functions(module: str) -> Any:
    """Return what stands for a module until a function of it is called, on the thread that calls it."""
    return _LateFunctions(module)
