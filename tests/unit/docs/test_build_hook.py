"""The build hook: a wheel and a source archive carry page and documentation, an editable installation the page only."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).parents[3]


@pytest.fixture
def hook() -> ModuleType:
    specification = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("version", "built"), [("standard", ["page", "docs"]), ("editable", ["page"])], ids=["standard", "editable"]
)
def test_page_and_documentation_are_built_by_the_kind_of_wheel(
    hook: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, version: str, built: list[str]
) -> None:
    done: list[str] = []
    builders = SimpleNamespace(build_page=lambda _: done.append("page"), build_docs=lambda _: done.append("docs"))
    monkeypatch.setattr(hook, "_load", lambda root, name: builders)
    made = hook.PageBuildHook(str(tmp_path), {}, None, None, str(tmp_path), "wheel")
    made.initialize(version, {})
    assert done == built


def test_the_builders_are_found(hook: ModuleType) -> None:
    assert callable(hook._load(ROOT, "build_page").build_page)
    assert callable(hook._load(ROOT, "docs_site").build_docs)
