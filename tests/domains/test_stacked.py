"""STACKED n OBJECTS: shortest plans of 2 n - 1 actions [K Table 6.4], and stacks within reach."""

import importlib.util
import re

import pytest

import kabo
from kabo.plan import plan_statistics
from tests.domains.reach import grasps_in, spot
from tests.domains.scenes import DOMAINS, problem_of, scene_of

STACKS = ("stack_1", "stack_2", "stack_3")
State = tuple[tuple[str, ...], ...]


def _stacks(facts: dict[str, str]) -> State:
    above = {below: block for block, below in facts.items()}
    return tuple(tuple(_tower(above, stack)) for stack in STACKS)


def _tower(above: dict[str, str], foot: str) -> list[str]:
    tower = []
    while foot in above:
        foot = above[foot]
        tower.append(foot)
    return tower


def _facts(text: str) -> dict[str, str]:
    return dict(re.findall(r"one_below\((\w+)\) = (\w+)", text))


def _shortest(start: State, goal: State) -> int:
    """Breadth-first search over who stands on whom."""
    seen, layer, depth = {start}, [start], 0
    while goal not in layer:
        following = []
        for state in layer:
            for i in (k for k in range(3) if state[k]):
                for j in (k for k in range(3) if k != i):
                    after = list(state)
                    after[i], after[j] = state[i][:-1], (*state[j], state[i][-1])
                    if tuple(after) not in seen:
                        seen.add(tuple(after))
                        following.append(tuple(after))
        layer, depth = following, depth + 1
    return depth


@pytest.mark.parametrize("n", range(2, 7))
def test_the_shortest_plan_has_two_n_less_one_actions(n: int) -> None:
    initial, _, goal = (DOMAINS / "stacked" / f"n{n}.yaml").read_text().partition("goal:")
    assert _shortest(_stacks(_facts(initial)), _stacks(_facts(goal))) == 2 * n - 1


def test_bodies_stand_where_the_initial_knowledge_says() -> None:
    text = (DOMAINS / "stacked" / "n20.yaml").read_text()
    frames = dict(re.findall(r"(o\d+): \{model: tile, pose: \{frame: (\w+),", text))
    assert frames == _facts(text.partition("goal:")[0])
    assert len(frames) == 20


@pytest.mark.parametrize(
    ("n", "height", "level"),
    [(6, 0.04, 1), (6, 0.04, 2), (6, 0.04, 6), (6, 0.04, 10), (20, 0.02, 1), (20, 0.02, 12), (20, 0.02, 20)],
)
@pytest.mark.parametrize("stack", STACKS)
def test_towers_of_ten_cubes_and_of_twenty_flat_blocks_are_within_reach(
    stack: str, n: int, height: float, level: int
) -> None:
    scene = scene_of(DOMAINS / "stacked" / f"n{n}.yaml")
    body = scene.bodies["o1"]
    x, y, _ = scene.fixed_poses[stack][:3, 3]
    middle = 0.01 + height * (level - 0.5)
    spots = body.grasps["from_above"]
    assert _height(n) == height
    for above in (0.0, 0.05):  # in the hand, and where an approach begins
        assert grasps_in(scene.robots["mobile"], spots, body.features, spot(x, y), middle + above, 500) > 20


def _height(n: int) -> float:
    """What lifts the third block above the second, in the problem with n of them."""
    text = (DOMAINS / "stacked" / f"n{n}.yaml").read_text()
    found = re.search(r"o3: \{model: \w+, pose: \{frame: o2, position: \[0, 0, ([\d.]+)\]\}\}", text)
    assert found is not None
    return float(found[1])


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 5, 8, 10, 11, 16, 20])
def test_the_search_of_the_file_itself_finds_a_shortest_plan(n: int) -> None:
    result = kabo.solve(problem_of(DOMAINS / "stacked" / f"n{n}.yaml"), geometry="none")
    assert result.plan is not None
    assert plan_statistics(result.plan).plan_actions == 2 * n - 1


@pytest.mark.slow
def test_twenty_flat_blocks_are_restacked_with_motions_that_hold() -> None:
    problem = problem_of(DOMAINS / "stacked" / "n20.yaml")
    result = kabo.solve(problem, certificate=False)
    assert result.plan is not None
    assert plan_statistics(result.plan).plan_actions == 39
    assert kabo.verify(problem, result.plan).ok


def test_one_block_is_refused() -> None:
    specification = importlib.util.spec_from_file_location("rule", DOMAINS / "stacked" / "generate.py")
    assert specification is not None and specification.loader is not None
    rule = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(rule)
    with pytest.raises(rule.kabo.InputError, match="2 blocks or more"):
        rule.problem(1)
    assert problem_of(DOMAINS / "stacked" / "n2.yaml").objects["o2"] == "block"
