"""Build hook: the operator page and the documentation are built while the package is built, and the wheel carries both.

An editable installation, for work on hawk, gets the page only: ``make docs`` builds the documentation there.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

EDITABLE = "editable"
"""Hatchling's name of an editable wheel."""


class PageBuildHook(BuildHookInterface[Any]):
    """Builds ``hawk/web/static`` and ``hawk/web/docs_site`` before anything is packed."""

    PLUGIN_NAME = "page"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - hatchling's signature
        """Build both unless they are up to date."""
        root = Path(self.root)
        _load(root, "build_page").build_page(root)
        if version != EDITABLE:
            _load(root, "docs_site").build_docs(root)


def _load(root: Path, name: str) -> Any:
    specification = importlib.util.spec_from_file_location(name, root / "packaging" / f"{name}.py")
    if specification is None or specification.loader is None:
        raise FileNotFoundError(f"packaging/{name}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
