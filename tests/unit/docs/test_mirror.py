"""Unit tests stand in their module's folder, under its name: ``test_<module>.py`` or ``test_<module>_<aspect>.py``."""

from __future__ import annotations

from pathlib import Path

from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
UNIT = ROOT / "tests" / "unit"
OF_NO_MODULE = {"docs", "packaging", "page"}
"""Folders of tests on documents, scripts and the page's build."""
OF_ALL_MODULES = {"test_imports.py", "test_field_inputs.py", "test_sweep.py"}
FOLDERS = sorted({file.parent for file in UNIT.rglob("test_*.py")} - {UNIT / name for name in OF_NO_MODULE})


@sweep("folder", FOLDERS)
def test_each_file_bears_the_name_of_a_module(folder: Path) -> None:
    inside = folder.relative_to(UNIT)
    rooms = [room for room in (ROOT / "hawk" / inside, ROOT / inside) if room.is_dir() and room != ROOT]
    names = {
        found.stem.strip("_") for room in rooms for found in room.iterdir() if found.suffix == ".py" or found.is_dir()
    }
    files = {file.name.removeprefix("test_").removesuffix(".py") for file in folder.glob("test_*.py")} - {
        name.removeprefix("test_").removesuffix(".py") for name in OF_ALL_MODULES
    }
    assert [file for file in sorted(files) if not any(f"{file}_".startswith(f"{name}_") for name in names)] == []
