"""The lint of the page finds modules that import each other, by values or by types alone."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path

import pytest

RULES = Path(__file__).resolve().parents[3] / "hawk" / "web" / "page" / ".oxlintrc.json"
OXLINT = Path(sysconfig.get_path("scripts")) / "oxlint"

USES_B = 'import { b } from "./b.ts";\nexport const a = b;\n'
CIRCLE = "import(no-cycle)"


def lint(folder: Path, **modules: str) -> subprocess.CompletedProcess[str]:
    for name, source in modules.items():
        (folder / f"{name}.ts").write_text(source, "utf-8")
    command: list[str | Path] = [OXLINT, "--config", RULES, "--format", "unix", folder]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.parametrize(
    "returning",
    [
        'import { a } from "./a.ts";\nexport const b = (): number => a;\n',
        'import type { A } from "./a.ts";\nexport const b: A = 1;\n',
        'import { type A } from "./a.ts";\nexport const b: A = 1;\n',
        'export { a } from "./a.ts";\nexport const b = 1;\n',
        'export type * from "./a.ts";\nexport const b = 1;\n',
    ],
    ids=["values", "types", "types among values", "export of a value", "export of types"],
)
def test_finds_two_modules_that_import_each_other(returning: str, tmp_path: Path) -> None:
    found = lint(tmp_path, a=USES_B, b=returning)
    assert found.returncode == 1
    assert found.stdout.count(CIRCLE) == 2, found.stdout


def test_finds_a_circle_of_three_by_types_alone(tmp_path: Path) -> None:
    modules = {
        name: f'import type {{ {other.upper()} }} from "./{other}.ts";\nexport type {name.upper()} = {other.upper()};\n'
        for name, other in (("a", "b"), ("b", "c"), ("c", "a"))
    }
    found = lint(tmp_path, **modules)
    assert found.returncode == 1
    assert found.stdout.count(CIRCLE) == 3, found.stdout


def test_refuses_a_type_named_by_its_file_which_would_hide_a_circle(tmp_path: Path) -> None:
    found = lint(tmp_path, a=USES_B, b='export const b: import("./a.ts").A = 1;\n')
    assert found.returncode == 1
    assert "typescript(consistent-type-imports)" in found.stdout


def test_finds_none_where_two_modules_share_a_third(tmp_path: Path) -> None:
    shared = 'import type { C } from "./c.ts";\n'
    found = lint(tmp_path, a=shared + USES_B, b=f"{shared}export const b: C = 1;\n", c="export type C = number;\n")
    assert found.returncode == 0, found.stdout
