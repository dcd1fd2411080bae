"""Names in documents: the code, files and headings that they stand for."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
FOLDERS = ("hawk/", "tests/", "docs/", "packaging/", "training/", "benchmarks/", "proving/", "debian/", ".github/")


def marked(text: str) -> list[str]:
    """Return the texts between backticks."""
    return re.findall(r"`([^`\n]+)`", text)


def exists(name: str) -> bool:
    """Return True for a module, or an attribute of one, what `__init__` sets included."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part):
                return inspect.isclass(found) and part == parts[-1] and part in instance_attributes(found)
            found = getattr(found, part)
        return True
    return False


def instance_attributes(owner: type) -> set[str]:
    """Return the names that the class's methods assign to ``self``."""
    return set(re.findall(r"\bself\.(\w+)(?::[^=\n]+)? = ", inspect.getsource(owner)))


@cache
def names_of_tests(path: Path) -> frozenset[str]:
    """Return the names of a file's tests."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    return frozenset(node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, kinds))


def is_known(name: str) -> bool:
    """Return True for a text between backticks that is no name of ours, or a name that exists."""
    if name.startswith("hawk.") and re.fullmatch(r"[\w.]+", name):
        return exists(name)
    if name.startswith(FOLDERS) and re.fullmatch(r"[\w./-]+", name):
        return (ROOT / name).exists()
    return True


def anchors(text: str) -> set[str]:
    """Return the anchors of a Markdown page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(text: str) -> list[str]:
    """Return the targets of a Markdown page's links and images."""
    return re.findall(r"\]\(([^)\s]+)\)", text)
