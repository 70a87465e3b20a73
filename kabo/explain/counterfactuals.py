"""Counterfactuals: a few changes of the problem that its failures suggest, each solved from scratch."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.errors import InputError
from kabo.explain.findings import (
    BaseMoved,
    BodyRemoved,
    Change,
    Counterfactual,
    Finding,
    LeastMove,
    SmallerEpsilon,
)
from kabo.explain.scene_changes import changed, removable
from kabo.geometry_server import SceneSurroundings, Situation, supports
from kabo.language.problem import Problem
from kabo.plan import plan_statistics
from kabo.planner.solve import solve

EPSILON_DIVISOR = 4  # a smaller epsilon is tried, divided by this
MAX_CHANGES = 6  # changes that are tried
MAX_BLAMED_CALLS = 4  # failed calls that may suggest a body to take out
MARGINS_M = (0.03, 0.1)  # metres beyond the least move of a base, so that the arm has room
BUDGET_DIVISOR = 8  # each change may use samples and expansions divided by this, but at most the greater of
MIN_SAMPLES, MIN_EXPANSIONS = 5_000, 10_000  # samples and expansions, and
USED_FACTOR = 4  # times what the problem itself used


@dataclass(frozen=True)
class TrialBudget:
    """The budget for trying changes: that of the problem, what it used of it, and the seconds left for all changes."""

    samples: int
    expansions: int
    used_samples: int
    used_expansions: int
    seconds_left: Callable[[], float]
    cancelled: Callable[[], bool] | None = None

    @property
    def share(self) -> tuple[int, int]:
        """The samples and expansions that one change may use."""
        samples = min(self.samples // BUDGET_DIVISOR, max(MIN_SAMPLES, USED_FACTOR * self.used_samples))
        return samples, min(
            self.expansions // BUDGET_DIVISOR, max(MIN_EXPANSIONS, USED_FACTOR * self.used_expansions)
        )


def candidates(
    problem: Problem, surroundings: SceneSurroundings, findings: Sequence[Finding], most: int = MAX_CHANGES
) -> list[Change]:
    """The changes that the failures suggest, the most promising first."""
    needed = [finding for finding in findings if not finding.dispensable] or list(findings)
    found = list(dict.fromkeys(_suggested(problem, surroundings, needed)))
    return found[:most]


def _suggested(problem: Problem, surroundings: SceneSurroundings, findings: Sequence[Finding]) -> Iterator[Change]:
    for finding in findings[:MAX_BLAMED_CALLS]:
        freed = [name for name, count in finding.freed if count and removable(problem, name)]
        yield from (BodyRemoved(name) for name in freed if not _carries(surroundings, name))
    if any(finding.because_of_epsilon for finding in findings):
        yield SmallerEpsilon(round(surroundings.budget.epsilon / EPSILON_DIVISOR, 9))
    farthest: dict[str, LeastMove] = {}
    for finding in findings:
        if finding.robot is not None and finding.nearer:
            move = finding.nearer[-1]  # the last one keeps the height, if that helps
            farthest[finding.robot] = max(move, farthest.get(finding.robot, move), key=lambda each: each.metres)
    for robot, move in farthest.items():
        yield from (_moved(robot, np.array(move.by), margin) for margin in MARGINS_M if move.metres)


def _moved(robot: str, by: Any, margin: float) -> BaseMoved:
    x, y, z = (round(float(v), 3) + 0.0 for v in by * (1.0 + margin / float(np.linalg.norm(by))))
    return BaseMoved(robot, (x, y, z))


def _carries(surroundings: SceneSurroundings, name: str) -> bool:
    """Whether something stands on a body at the start."""
    scene = surroundings.scene
    start = Situation.of(scene.start)
    return any(name in supports(surroundings, start, other) for other in scene.movable if other != name)


def tried(
    problem: Problem,
    surroundings: SceneSurroundings,
    changes: Sequence[Change],
    means: TrialBudget,
    **options: Any,
) -> list[Counterfactual]:
    """The result of each change: those with a plan first, by their number of actions, then the others in order.

    Args:
        problem: to be changed.
        surroundings: of its scene.
        changes: from `candidates`.
        means: of all of them.
        options: of `solve`, as the problem itself was solved.
    """
    found = []
    for number, change in enumerate(changes):
        seconds = means.seconds_left() / (len(changes) - number)
        if seconds <= 0.0 or (means.cancelled is not None and means.cancelled()):
            break
        one = _tried(changed(problem, surroundings.scene, change), change, means, seconds, options)
        found += [] if one is None else [one]
    return sorted(found, key=lambda each: (each.plan_actions is None, each.plan_actions or 0))


def _tried(
    problem: Problem, change: Change, means: TrialBudget, seconds: float, options: dict[str, Any]
) -> Counterfactual | None:
    samples, expansions = means.share
    given = {**options, "epsilon": change.epsilon} if isinstance(change, SmallerEpsilon) else options
    try:
        result = solve(
            problem,
            **{**given, "max_samples": samples, "max_expansions": expansions, "timeout": seconds},
            certificate=False,
            cancelled=means.cancelled,
        )
    except InputError:  # without the body the problem is not valid: something else names it
        return None
    actions = None if result.plan is None else plan_statistics(result.plan).plan_actions
    return Counterfactual(change, result.status, actions)
