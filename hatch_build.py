"""Build hook: the operator page is built while the package is built, and the wheel carries it."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PageBuildHook(BuildHookInterface[Any]):
    """Builds ``hawk/web/static`` before anything is packed."""

    PLUGIN_NAME = "page"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - hatchling's signature
        """Build the page unless it is up to date."""
        _load_build_page(Path(self.root)).build_page(Path(self.root))


def _load_build_page(root: Path) -> Any:
    specification = importlib.util.spec_from_file_location("build_page", root / "packaging" / "build_page.py")
    if specification is None or specification.loader is None:
        raise FileNotFoundError("packaging/build_page.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
