import numpy as np
import pytest

from hawk.worlds.plan import Axes, PlannedStall, SitePlan
from hawk.worlds.scene.materials import Material
from training.avenues import plant_avenue

GREY = Material("asphalt", (100.0, 100.0, 100.0), 0, 0, 0)
EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
PITCH, DEPTH, COUNT = 2.6, 5.2, 12


def a_plan() -> SitePlan:
    """One row along x with its closed ends at y = `DEPTH`, and another one far off, turned by a right angle."""
    plan = SitePlan(EAST, GREY, GREY, [(255.0, 255.0, 255.0)])
    unit = np.array([[0, 0], [PITCH, 0], [PITCH, DEPTH], [0, DEPTH]])
    plan.stalls = [
        PlannedStall(unit + np.array([k * PITCH, 0]), "perpendicular", False, False, 1.0) for k in range(COUNT)
    ]
    across = unit[:, ::-1] + np.array([100.0, 0])
    plan.stalls += [
        PlannedStall(across + np.array([0, k * PITCH]), "perpendicular", False, False, 1.0) for k in range(COUNT)
    ]
    return plan


@pytest.mark.parametrize("seed", range(12))
def test_an_avenue_stands_at_the_heads_of_one_row(seed: int) -> None:
    plan = a_plan()
    plant_avenue(plan, np.random.default_rng(seed))
    stems = np.array([[tree.x, tree.y] for tree in plan.trees])
    assert len(stems) >= 3
    first = (np.abs(stems[:, 1] - DEPTH) < 3.2).all() and (stems[:, 0] < COUNT * PITCH + 5).all()
    second = (np.abs(stems[:, 0] - 100 - DEPTH) < 3.2).all() and (stems[:, 1] < COUNT * PITCH + 5).all()
    assert first != second


def test_the_same_generator_plants_the_same_and_another_something_else() -> None:
    planted = []
    for seed in (3, 3, 4):
        plan = a_plan()
        plant_avenue(plan, np.random.default_rng(seed))
        planted.append(plan.trees)
    assert planted[0] == planted[1] != planted[2]


def test_where_no_stalls_are_nothing_is_planted() -> None:
    plan = a_plan()
    plan.stalls = []
    plant_avenue(plan, np.random.default_rng(0))
    assert plan.trees == []
