"""Nothing that the Debian package leaves out of its wheels is loaded by hawk."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.statements import statements
from tests.unit.packaging.scripts import load

assemble_venv = load("deb/assemble_venv")
ROOT = Path(__file__).parents[3]
LEFT_OUT = sorted(
    {*assemble_venv.SKIPPED, *(f"{name}.{part}" for name in ("numpy", "scipy") for part in assemble_venv.UNUSED[name])}
)
WITHOUT = """
import importlib, pkgutil, sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name in LEFT_OUT:
            raise ImportError(f"{name} is left out")

LEFT_OUT = set(sys.argv[1:])
sys.meta_path.insert(0, Refuse())
import hawk
for found in pkgutil.walk_packages(hawk.__path__, "hawk."):
    importlib.import_module(found.name)
import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array, coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
costs = np.array([[4.0, 1.0], [2.0, 9.0]])
assert linear_sum_assignment(costs)[1].tolist() == [1, 0]
assert connected_components(coo_array(costs > 3))[0] == 2
assert dijkstra(coo_matrix(costs).tocsr(), indices=0)[1] == 1.0
assert cKDTree(costs).query([4.0, 1.5])[1] == 0
assert round(Rotation.from_euler("z", 90, degrees=True).apply([1, 0, 0])[1], 9) == 1
print(len([name for name in sys.modules if name.startswith("hawk.")]))
"""


def imported() -> Iterator[str]:
    for path in (ROOT / "hawk").rglob("*.py"):
        for node in statements(ast.parse(path.read_text(encoding="utf-8")).body):
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                yield from (node.module, *(f"{node.module}.{alias.name}" for alias in node.names))


@pytest.mark.slow
def test_no_module_imports_what_is_left_out() -> None:
    """Functions import, too."""
    names = set(imported())
    assert "scipy.spatial" in names
    assert not {name for name in names for left in LEFT_OUT if name == left or name.startswith(f"{left}.")}


@pytest.mark.nightly
@pytest.mark.slow
def test_every_module_is_imported_without_it() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, *LEFT_OUT], cwd=ROOT, capture_output=True, text=True, timeout=110, check=False
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 200
