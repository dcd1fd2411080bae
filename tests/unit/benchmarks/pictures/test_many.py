"""Growth with the number of photographs: the table, and the flight that is drawn."""

from __future__ import annotations

import pytest

from benchmarks.pictures.__main__ import main
from benchmarks.pictures.many import OPTIONS, Grown, table, world_for
from hawk.sim.photos import plan


def test_the_table_says_what_each_further_photograph_takes() -> None:
    one = Grown(100, {"read": 100.0, "map": 50.0}, 300.0, 60.0)
    two = Grown(200, {"read": 200.0, "map": 150.0}, 330.0, 130.0)
    lines = table([one, two]).splitlines()
    assert lines[2].startswith("| 100 | 1.50 | 1.00 | 0.00 |")
    assert lines[-1] == "Each further photograph: 2.00 s, 0.30 MiB of memory, 0.70 MiB kept."
    assert table([one]).count("\n") == 2


@pytest.mark.parametrize("count", [20, 50])
def test_a_flight_of_about_that_number_is_drawn(count: int) -> None:
    assert len(plan(world_for(count), OPTIONS)) == pytest.approx(count, rel=0.3)


@pytest.mark.parametrize("text", ["many", "3", "100,"])
def test_numbers_that_are_none_are_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--many", text])
    assert "as 100,200,400" in capsys.readouterr().err
