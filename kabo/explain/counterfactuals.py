"""What one change would do: few changes, taken from what stood in the way, each solved from scratch."""

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
from kabo.geometry_server import Situation, Surroundings, supports
from kabo.language.problem import Problem
from kabo.plan import plan_statistics
from kabo.planner.solve import solve

FINER = 4  # the part of epsilon that is tried
MOST = 6  # changes that are tried
BLAMED = 4  # calls whose failures suggest what to take out
MARGINS = (0.03, 0.1)  # m: how much farther than it must a base is moved, for the arm to have room
SHARE = 8  # the part of all samples and expansions that each change may use
LEAST_SAMPLES, LEAST_EXPANSIONS = 5_000, 10_000  # that it may use of these at least, or
TIMES = 4  # as many times what the problem itself took before it was given up, whichever is more


@dataclass(frozen=True)
class TrialBudget:
    """What trying changes may cost: budgets and what was used of them; seconds for all only cut off."""

    samples: int
    expansions: int
    used_samples: int
    used_expansions: int
    seconds_left: Callable[[], float]
    cancelled: Callable[[], bool] | None = None

    @property
    def share(self) -> tuple[int, int]:
        """Samples and expansions of one change: a part of the budget, and no more than there is reason for."""
        samples = min(self.samples // SHARE, max(LEAST_SAMPLES, TIMES * self.used_samples))
        return samples, min(self.expansions // SHARE, max(LEAST_EXPANSIONS, TIMES * self.used_expansions))


def candidates(
    problem: Problem, surroundings: Surroundings, findings: Sequence[Finding], most: int = MOST
) -> list[Change]:
    """The changes that what stood in the way suggests, the most promising first."""
    needed = [finding for finding in findings if not finding.dispensable] or list(findings)
    found = list(dict.fromkeys(_suggested(problem, surroundings, needed)))
    return found[:most]


def _suggested(problem: Problem, surroundings: Surroundings, findings: Sequence[Finding]) -> Iterator[Change]:
    for finding in findings[:BLAMED]:
        freed = [name for name, count in finding.freed if count and removable(problem, name)]
        yield from (BodyRemoved(name) for name in freed if not _carries(surroundings, name))
    if any(finding.because_of_epsilon for finding in findings):
        yield SmallerEpsilon(round(surroundings.budget.epsilon / FINER, 9))
    farthest: dict[str, LeastMove] = {}
    for finding in findings:
        if finding.robot is not None and finding.nearer:
            move = finding.nearer[-1]  # the last one keeps the height, if that helps
            farthest[finding.robot] = max(move, farthest.get(finding.robot, move), key=lambda each: each.metres)
    for robot, move in farthest.items():
        yield from (_moved(robot, np.array(move.by), margin) for margin in MARGINS if move.metres)


def _moved(robot: str, by: Any, margin: float) -> BaseMoved:
    x, y, z = (round(float(v), 3) + 0.0 for v in by * (1.0 + margin / float(np.linalg.norm(by))))
    return BaseMoved(robot, (x, y, z))


def _carries(surroundings: Surroundings, name: str) -> bool:
    """Whether an object stands on a body at the start."""
    scene = surroundings.scene
    start = Situation.of(scene.start)
    return any(name in supports(surroundings, start, other) for other in scene.movable if other != name)


def tried(
    problem: Problem, surroundings: Surroundings, changes: Sequence[Change], means: TrialBudget, **options: Any
) -> list[Counterfactual]:
    """What came of each change; what solves the problem first, fewest actions first, else in their order.

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
    except InputError:  # what is left is no problem: something else named what is gone
        return None
    actions = None if result.plan is None else plan_statistics(result.plan).plan_actions
    return Counterfactual(change, result.status, actions)
