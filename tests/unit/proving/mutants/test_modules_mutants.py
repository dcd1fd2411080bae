"""The faults that are put into a module, their sample, the tests that are chosen for them, and the score."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from proving.mutants.__main__ import groups_below, main, table
from proving.mutants.modules import (
    ALL_MODULES,
    ARCHIVE,
    GROUPS,
    LEFT_OUT,
    ROOT,
    SAFETY_MODULES,
    WITHOUT_EVERY_BRANCH,
    folders_of_tests,
    own_files,
)
from proving.mutants.reach import ENOUGH_TESTS_S, ReachMap
from proving.mutants.runs import IMPORTED_ONCE, InOrder, Verdict
from proving.mutants.sampling import Mutant, difference, function_lines, mutants_of, mutated, sample

SOURCE = '''
LIMIT = 3.0
Either = int | str

def late(age: int | None, is_up: bool = True) -> bool:
    """Return 1 + 1."""
    return age is None or age >= LIMIT and is_up
'''


def changes(source: str = SOURCE) -> set[str]:
    return {difference(source, mutated(source, each)).split("  ->  ")[1] for each in mutants_of("m.py", source)}


@pytest.mark.slow
def test_bounds_conditions_numbers_and_defaults_are_changed_and_types_are_not() -> None:
    found = changes()
    assert "LIMIT = 4.0" in found
    assert "return age is None or age > LIMIT and is_up" in found
    assert "return age is not None or age >= LIMIT and is_up" in found
    assert "return age is None and age >= LIMIT and is_up" in found
    assert "return age is None or age >= LIMIT or is_up" in found
    assert any("is_up: bool = False" in line for line in found)
    assert not any("&" in line for line in found), "a type is no bound"
    assert not any("1 + 2" in line for line in found)


def test_the_star_before_parameters_by_name_is_left_alone_and_their_defaults_are_changed() -> None:
    source = "def area(side: int = 2 * 3, *, times: int = 4) -> int:\n    return side * times\n"
    found = changes(source)
    assert not any("/, times" in line for line in found)
    assert {"def area(side: int = 2 / 3, *, times: int = 4) -> int:", "return side / times"} <= found
    assert "def area(side: int = 2 * 3, *, times: int = 5) -> int:" in found
    assert changes("def go(*, far: bool) -> bool:\n    return far\n") == set()
    assert any("/ parts" in line for line in changes("def go(*parts: int) -> int:\n    return 2 * parts[0]\n"))


def test_every_mutant_is_a_program_that_differs() -> None:
    for each in mutants_of("m.py", SOURCE):
        assert ast.dump(ast.parse(mutated(SOURCE, each))) != ast.dump(ast.parse(SOURCE)), each


def test_a_sample_depends_on_seed_and_module_alone() -> None:
    assert sample("m.py", SOURCE, 1, 4) == sample("m.py", SOURCE, 1, 4)
    assert len(sample("m.py", SOURCE, 1, 4)) == 4
    assert len({tuple(sample("m.py", SOURCE, seed, 4)) for seed in range(5)}) > 1
    assert len(sample("m.py", SOURCE, 1, 10_000)) == len(mutants_of("m.py", SOURCE))


def test_a_mutant_that_is_not_there_is_an_error() -> None:
    with pytest.raises(ValueError, match="there is no such mutant"):
        mutated(SOURCE, Mutant("m.py", "core/AddNot", 99, 1))


@pytest.mark.slow
def test_every_module_is_there_and_has_a_line_that_a_fault_can_change() -> None:
    bare = [module for module in SAFETY_MODULES if not function_lines(ast.parse((ROOT / module).read_text("utf-8")))]
    assert bare == []


@pytest.mark.slow
@pytest.mark.nightly
def test_every_module_has_mutants() -> None:
    for module in SAFETY_MODULES:
        assert len(mutants_of(module, (ROOT / module).read_text(encoding="utf-8"))) > 0, module


def test_the_own_test_files_of_a_module_are_there() -> None:
    assert all(own_files(module) for module in SAFETY_MODULES), [m for m in SAFETY_MODULES if not own_files(m)]


def test_rooms_that_keep_surveys_are_listed_whole_and_only_tests_that_reach_them_are_mapped() -> None:
    assert {str(path.relative_to(ROOT)) for path in (ROOT / "hawk/stats").glob("[!_]*.py")} == set(ARCHIVE["stats"])
    assert not {module for modules in ARCHIVE.values() for module in modules} & set(SAFETY_MODULES)
    assert folders_of_tests(ARCHIVE["picture"]) == ("tests/unit/picture",)
    assert set(folders_of_tests(SAFETY_MODULES)) >= {"tests/unit/ddc", "tests/unit/comm"}
    assert "tests/unit/lots" not in folders_of_tests(SAFETY_MODULES)
    assert all((ROOT / folder).is_dir() for folder in folders_of_tests(ALL_MODULES))


def test_every_module_of_the_drones_side_is_listed_or_left_out_for_a_reason() -> None:
    left_out = {module for modules in LEFT_OUT.values() for module in modules}
    found = {str(path.relative_to(ROOT)) for room in ("comm", "ddc") for path in (ROOT / "hawk" / room).rglob("*.py")}
    modules = {module for module in found if not module.endswith("__init__.py")}
    unlisted = modules - set(ALL_MODULES)
    assert {module for module in unlisted if not any(module.startswith(each) for each in left_out)} == set()
    assert left_out.isdisjoint(ALL_MODULES)
    assert all((ROOT / each).exists() for each in left_out)


def test_tests_of_the_line_run_a_module_s_own_first_then_quick_ones_within_the_limit() -> None:
    module, own = "hawk/ddc/rules/judge.py", f"{own_files('hawk/ddc/rules/judge.py')[0]}::own"
    found = ReachMap(
        {module: {2: frozenset({"a.py::slow"}), 7: frozenset({"a.py::slow", "b.py::quick", "c.py::slower", own})}},
        {"a.py::slow": 2.0, own: 5.0, "c.py::slower": ENOUGH_TESTS_S},
    )
    of_line = found.tests(Mutant(module, "core/AddNot", 0, 7), inside_function=True)
    assert of_line == (own, "b.py::quick", "a.py::slow")
    assert found.tests(Mutant(module, "core/AddNot", 0, 2), inside_function=True) == ("a.py::slow",)
    at_import = found.tests(Mutant(module, "core/AddNot", 0, 2), inside_function=False)
    assert at_import == of_line, "a line of the module runs at import"
    assert function_lines(ast.parse(SOURCE)) == {6, 7}


@pytest.mark.slow
def test_what_is_imported_before_every_run_loads_no_module_under_test() -> None:
    code = f"import sys; [__import__(name) for name in {IMPORTED_ONCE}]; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert not {module.removesuffix(".py").replace("/", ".") for module in ALL_MODULES} & set(loaded.split())


class Item:
    def __init__(self, nodeid: str) -> None:
        self.nodeid = nodeid


def test_new_tests_of_a_modules_own_files_run_before_the_chosen_ones_and_no_other() -> None:
    items = [Item(each) for each in ("b.py::two", "own.py::known", "own.py::new", "c.py::new", "b.py::one")]
    plugin = InOrder(["own.py"], ["b.py::one", "b.py::two"], frozenset({"own.py::known", "b.py::one", "b.py::two"}))
    plugin.pytest_collection_modifyitems(items)
    assert [item.nodeid for item in items] == ["own.py::new", "b.py::one", "b.py::two"]


def verdicts(module: str, killed: int, survived: int) -> list[Verdict]:
    mutant = Mutant(module, "core/AddNot", 0, 1)
    outcomes = ["killed"] * (killed - 1) + ["timeout"] + ["survived"] * survived
    return [Verdict(mutant, outcome, "", 1.0) for outcome in outcomes]


def test_a_group_below_nine_of_ten_fails_the_run() -> None:
    (judge, *_), (guard,) = GROUPS["judge"], GROUPS["guard"]
    found = verdicts(judge, 9, 1) + verdicts(guard, 8, 1)
    assert groups_below(found) == ["guard"]
    assert groups_below(verdicts(ARCHIVE["lots"][0], 6, 1)) == [], "86 %: such a room needs 85"
    assert groups_below(verdicts(ARCHIVE["lots"][0], 5, 1)) == ["lots"]
    shown = table(found)
    assert f"| `{judge}` | 10 | 9 | 1 | 90% |" in shown
    assert "| **guard** | 9 | 8 | 1 | 89% |" in shown
    assert "| **all** | 19 | 17 | 2 | 89% |" in shown


@pytest.mark.slow
def test_the_modules_are_printed_as_coverage_takes_them() -> None:
    printed = subprocess.run(
        [sys.executable, "-m", "proving.mutants", "--list"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    listed = printed.stdout.strip().split(",")
    assert set(SAFETY_MODULES) >= WITHOUT_EVERY_BRANCH
    assert listed == [module for module in SAFETY_MODULES if module not in WITHOUT_EVERY_BRANCH]


def test_words_of_no_module_are_refused_before_any_test_runs(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--only", "nowhere"])
    assert "no module has 'nowhere' in its path; --list shows all" in capsys.readouterr().err
