"""What a counterfactual calls solved is solved: the changed problem from scratch, its plan verified."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kabo.explain.explain import explain
from kabo.explain.scene_changes import changed
from kabo.language import Problem, load_problem
from kabo.language.scene_description import BodyDescription, PoseDescription, Shape
from kabo.planner.solve import solve
from kabo.scene import load_scene
from kabo.verify import verify_plan
from tests.conftest import PROPERTY_SCALE

DOMAINS = Path(__file__).resolve().parent.parent.parent / "domains"

# Where boards may hang: over the stacks, and over the dishwasher and the bottles. (x, y), heights, widths [m]
STACKED = ((0.43, 0.49), (-0.2, 0.2), (0.09, 0.16), (0.1, 0.3))
BARTENDER = ((0.1, 0.35), (-1.0, 0.7), (0.2, 0.3), (0.2, 0.5))
Range = tuple[float, float]


def with_boards(problem: Problem, boards: list[list[float]]) -> Problem:
    """The problem with square boards (x, y, height, width) that hang in the air."""
    assert problem.scene is not None
    made = {
        f"board_{number}": BodyDescription(
            f"board_{number}",
            Shape("box", size=(width, width, 0.01)),
            PoseDescription(position=(x, y, z)),
            movable=False,
        )
        for number, (x, y, z, width) in enumerate(boards)
    }
    scene = replace(problem.scene, bodies={**problem.scene.bodies, **made})
    return replace(problem, scene=scene)


def check(problem: Problem) -> int:
    """How many changes helped; each is looked at."""
    assert problem.scene is not None
    found = explain(problem, max_samples=8000, max_expansions=100_000, timeout=600.0, changes=2)
    solved = [each for each in found.counterfactuals if each.result == "solved"]
    for each in solved:
        other = changed(problem, load_scene(problem.scene), each.change)
        plan = solve(other).plan
        assert plan is not None and verify_plan(other, plan).ok
    return len(solved)


def hung(name: str, ranges: tuple[Range, ...], seed: int) -> Problem:
    """A problem of the domains with a board somewhere."""
    rng = np.random.default_rng(seed)
    rows = [[round(float(rng.uniform(low, high)), 3) for low, high in ranges]]
    return with_boards(load_problem(DOMAINS / f"{name}.yaml"), rows)


BLOCKING = (3, 6)  # seeds with which the board blocks


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*BLOCKING, *range(10, 10 + round(10 * PROPERTY_SCALE))])
def test_what_is_said_to_help_in_stacks_helps(seed: int) -> None:
    helped = check(hung("stacked/n3", STACKED, seed))
    assert helped or seed not in BLOCKING


@pytest.mark.parametrize("seed", range(round(10 * PROPERTY_SCALE)))
def test_what_is_said_to_help_at_the_bar_helps(seed: int) -> None:
    check(hung("bartender/four_bottles", BARTENDER, seed))
