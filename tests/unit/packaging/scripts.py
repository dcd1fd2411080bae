"""The programs of the folder packaging/, which is no package: another one has its name."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[3]


def load(name: str) -> ModuleType:
    """Return the module of ``packaging/NAME.py``."""
    specification = importlib.util.spec_from_file_location(Path(name).name, ROOT / "packaging" / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
