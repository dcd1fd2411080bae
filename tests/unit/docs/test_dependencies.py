"""Imports are declared, declared dependencies are used, and docs/dependencies.md gives the reason for each."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from tests.statements import statements
from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]
DOCUMENT = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
OURS = {"hawk", "benchmarks", "proving", "training", "tests", "packaging"}


def declared(requirements: list[str]) -> set[str]:
    """Return the names of distributions, in lower case with dashes."""
    return {re.split(r"[\s<>=!~\[;]", text, maxsplit=1)[0].lower().replace("_", "-") for text in requirements}


LATE = ("late", "late_functions", "load")
LATE_CALL = re.compile(rf"(?<![.\w])({'|'.join(LATE)})\(")


def imported(folder: str) -> set[str]:
    """Return the top-level modules of others that a folder's files import."""
    files = (path for path in (ROOT / folder).rglob("*.py") if "node_modules" not in path.parts)
    return set[str]().union(*map(imported_by, files)) - OURS - set(sys.stdlib_module_names)


@cache
def imported_by(path: Path) -> frozenset[str]:
    """Return the top-level modules that a file imports, or loads late (`hawk.runtime.late`)."""
    found: set[str] = set()
    text = path.read_text(encoding="utf-8")
    late = LATE if path.is_relative_to(ROOT / "hawk") else ()
    tree = ast.parse(text)
    for node in ast.walk(tree) if late and LATE_CALL.search(text) else statements(tree.body):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.split(".")[0])
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in late:
            found |= {str(given.value).split(".")[0] for given in node.args[:1] if isinstance(given, ast.Constant)}
    return frozenset(found)


@cache
def known_distributions() -> dict[str, set[str]]:
    """Return the installed distributions of each module."""
    return {m: {n.lower().replace("_", "-") for n in names} for m, names in packages_distributions().items()}


def distributions(modules: set[str]) -> dict[str, set[str]]:
    """Return the installed distributions of each module; a module that is not installed stands for itself."""
    return {module: known_distributions().get(module, {module}) for module in modules}


RUN_TIME = declared(PROJECT["dependencies"])
EXTRAS = {name: declared(values) - {"hawk-drone"} for name, values in PROJECT["optional-dependencies"].items()}
_OF_HAWK = ("sim", "background", "onnxruntime", "pictures", "cluster", "plans", "report")
TO_RUN = RUN_TIME.union(*(EXTRAS[name] for name in _OF_HAWK))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "allowed"),
    [
        ("hawk", TO_RUN),
        ("training", RUN_TIME | EXTRAS["training"]),
        ("benchmarks", TO_RUN | EXTRAS["dev"]),
        ("proving", TO_RUN | EXTRAS["dev"] | {"coverage"}),
        ("tests", TO_RUN | EXTRAS["dev"]),
    ],
)
def test_every_import_is_declared(folder: str, allowed: set[str]) -> None:
    undeclared = {module for module, names in distributions(imported(folder)).items() if not names & allowed}
    assert not undeclared


@pytest.mark.slow
def test_every_dependency_to_run_is_imported() -> None:
    used = {name for names in distributions(imported("hawk")).values() for name in names}
    assert TO_RUN - used == {"tzfpy"}, "a child of hawk/lots/time_zone.py imports it"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "only"),
    [
        ("pymavlink", ["picture", "sim"]),
        ("PIL", ["picture", "sim"]),
        ("pyogrio", ["lots"]),
        ("rasterio", ["formats", "picture"]),
        ("ezdxf", ["lots"]),
        ("pyproj", ["lots", "picture"]),
        ("weasyprint", ["report"]),
        ("pikepdf", ["report"]),
    ],
)
def test_only_these_rooms_import_what_an_extra_brings(module: str, only: list[str]) -> None:
    rooms = [path.name for path in (ROOT / "hawk").iterdir() if path.is_dir()]
    assert sorted(room for room in rooms if module in imported(f"hawk/{room}")) == only


@pytest.mark.parametrize("extra", ["sim", "background", "docs", "pictures", "plans", "report"])
def test_the_tools_to_develop_with_include_what_is_tested(extra: str) -> None:
    assert f"hawk-drone[{extra}]" in PROJECT["optional-dependencies"]["dev"]


@sweep("name", sorted(RUN_TIME.union(*EXTRAS.values()) - {"hawk-drone"}))
def test_every_dependency_is_defended(name: str) -> None:
    assert f"`{name}`" in DOCUMENT


def test_the_document_names_no_package_that_is_not_used() -> None:
    rows = set(re.findall(r"^(?:\| |- )`([\w.-]+)`", DOCUMENT, re.MULTILINE))
    build = declared(SETTINGS["build-system"]["requires"])
    assert rows == TO_RUN | EXTRAS["cluster"] | build
