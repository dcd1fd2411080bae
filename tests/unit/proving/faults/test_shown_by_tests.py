from __future__ import annotations

from pathlib import Path

import pytest

from proving.faults.__main__ import TESTS
from proving.faults.shown_by_tests import MarkerError, ShownFault, shown_by_tests, table

MARKED = """import pytest

@pytest.mark.fault("the link " "is cut", "it returns")
def test_link() -> None: ...

class TestBattery:
    @pytest.mark.slow
    @pytest.mark.fault("it is empty", "it lands")
    @pytest.mark.fault("the link is cut")
    async def test_empty(self) -> None: ...

def test_something_else() -> None: ...
"""


def test_faults_are_read_from_the_markers_with_all_their_tests(tmp_path: Path) -> None:
    (tmp_path / "unit").mkdir()
    (tmp_path / "unit" / "test_a.py").write_text(MARKED)
    (tmp_path / "unit" / "test_b.py").write_text("def test_b() -> None: ...\n")
    assert shown_by_tests(tmp_path) == (
        ShownFault(
            "the link is cut", "it returns", ("unit/test_a.py::test_link", "unit/test_a.py::TestBattery::test_empty")
        ),
        ShownFault("it is empty", "it lands", ("unit/test_a.py::TestBattery::test_empty",)),
    )
    assert (
        table(shown_by_tests(tmp_path)).splitlines()[2].startswith("| the link is cut | it returns | `unit/test_a.py::")
    )


@pytest.mark.parametrize(
    ("second", "problem"),
    [('"a", "its end"', "'a' has an end at another test"), ('"b"', "'b' has no end at any test")],
)
def test_a_fault_has_one_end(tmp_path: Path, second: str, problem: str) -> None:
    first = '@pytest.mark.fault("a", "end")\ndef test_a() -> None: ...\n'
    (tmp_path / "test_a.py").write_text(f"{first}@pytest.mark.fault({second})\ndef test_b() -> None: ...\n")
    with pytest.raises(MarkerError, match=problem):
        shown_by_tests(tmp_path)


@pytest.mark.slow
def test_every_fault_that_a_test_shows_has_one_end() -> None:
    faults = shown_by_tests(TESTS)
    assert len(faults) > 200
    assert all(fault.end and fault.words for fault in faults)
