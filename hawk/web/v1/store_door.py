"""Modules of the store of lots, which load SQLAlchemy: a thread of the store opens them, when it first calls one."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


class StoreDoor:
    """A module whose functions are called on a thread of the store.

    Import it under the same name where types are checked, and make a door of it elsewhere.
    """

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*values: Any, **named: Any) -> Any:
            return getattr(import_module(self._module), name)(*values, **named)

        return call
