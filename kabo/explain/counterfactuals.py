"""Counterfactuals: changes of a problem that its failed calls suggest, each of them solved from scratch."""

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.displays import counted
from kabo.errors import InputError
from kabo.explain.blame import blocking
from kabo.explain.findings import (
    BaseMoved,
    BodyRemoved,
    Change,
    Counterfactual,
    Finding,
    FloorLarger,
    LeastMove,
    SmallerEpsilon,
)
from kabo.explain.scene_changes import changed, may_grow, removable
from kabo.geometry_server import SceneSurroundings, Situation, supports
from kabo.language.problem import Problem
from kabo.phases import phase
from kabo.plan import plan_statistics
from kabo.planner.result import Result
from kabo.planner.solve import solve

_LOG = logging.getLogger("kabo.explain")
EPSILON_DIVISOR = 4  # a smaller epsilon is tried, divided by this
MAX_CHANGES = 6  # changes that are tried
MAX_BLAMED_CALLS = 4  # failed calls that may suggest a body to take out
MARGINS_M = (0.03, 0.1)  # metres beyond the least move of a base, so that the arm has room
FLOOR_MARGINS_M = (0.1, 0.5)  # likewise for a floor: other targets may need more of it
BUDGET_DIVISOR = 8  # each change may use samples and expansions divided by this, but at most the greater of
MIN_SAMPLES, MIN_EXPANSIONS = 5_000, 10_000  # samples and expansions, and
LEAST_SAMPLES = 2_000  # that a change may use in any case, or as many as the problem itself
USED_FACTOR = 4  # times what the problem itself used


@dataclass(frozen=True)
class TrialBudget:
    """The budget for solving changed problems: limits, use by the original run, and the seconds left.

    `samples` and `expansions` are the limits of the run on the original problem, `used_samples` and
    `used_expansions` what that run used.
    """

    samples: int
    expansions: int
    used_samples: int
    used_expansions: int
    seconds_left: Callable[[], float]
    cancelled: Callable[[], bool] | None = None

    @property
    def share(self) -> tuple[int, int]:
        """The greatest numbers of samples and of expansions for solving the problem with one change."""
        samples = min(self.samples // BUDGET_DIVISOR, max(MIN_SAMPLES, USED_FACTOR * self.used_samples))
        return max(samples, min(self.samples, LEAST_SAMPLES)), min(
            self.expansions // BUDGET_DIVISOR, max(MIN_EXPANSIONS, USED_FACTOR * self.used_expansions)
        )


def candidates(
    problem: Problem, surroundings: SceneSurroundings, findings: Sequence[Finding], most: int = MAX_CHANGES
) -> list[Change]:
    """The changes that the failed calls suggest, the most promising first; at most `most` of them."""
    needed = [finding for finding in findings if not finding.dispensable] or list(findings)
    found = list(dict.fromkeys(_suggested(problem, surroundings, needed)))
    last = [change for change in found if isinstance(change, SmallerEpsilon)]
    others = [change for change in found if not isinstance(change, SmallerEpsilon)]
    return [*others[: max(0, most - len(last))], *last][:most]


def _suggested(problem: Problem, surroundings: SceneSurroundings, findings: Sequence[Finding]) -> Iterator[Change]:
    for finding in findings[:MAX_BLAMED_CALLS]:
        freed = [name for name, count in finding.freed if count and removable(problem, name)]
        yield from (BodyRemoved(name) for name in freed if not _carries(surroundings, name))
    # What blocked most may be worth leaving out although something else is behind it: a plan may move that away.
    for name in (name for finding in findings[:1] for name, _ in blocking(finding)[:1]):
        if removable(problem, name) and not _carries(surroundings, name):
            yield BodyRemoved(name)
    farthest: dict[str, LeastMove] = {}
    floors: dict[str, str] = {}
    for finding in findings:
        if finding.robot is not None and finding.nearer:
            if finding.floor is not None:
                floors[finding.robot] = finding.floor
            move = finding.nearer[-1]  # the last one keeps the height, if that helps
            farthest[finding.robot] = max(move, farthest.get(finding.robot, move), key=lambda each: each.metres)
    for robot, move in farthest.items():
        if not move.metres:
            continue
        if robot not in floors:
            yield from (_moved(robot, np.array(move.by), margin) for margin in MARGINS_M)
        elif may_grow(problem, floors[robot]):
            larger = (FloorLarger(robot, floors[robot], round(move.metres + more, 3)) for more in FLOOR_MARGINS_M)
            yield from larger
    # Last: the parts of all bodies are made anew for it, which may take the time of all other changes.
    if any(finding.because_of_epsilon and not finding.proof for finding in findings):
        yield SmallerEpsilon(round(surroundings.budget.epsilon / EPSILON_DIVISOR, 9))


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
    told: Callable[[list[Counterfactual], Sequence[Change]], None] = lambda _, __: None,
    **options: Any,
) -> tuple[list[Counterfactual], Sequence[Change]]:
    """The results of solving the problem with each change alone, and the changes for which there was no time.

    Solved ones come first, the shortest plans leading.

    Args:
        problem: the problem without changes.
        surroundings: the geometry of the problem's scene.
        changes: the changes to try, from `candidates`.
        means: the budget for all changes together; changes are left out once its time is spent.
        told: called with the same before each change.
        options: the options of `solve` with which the unchanged problem was solved.
    """
    found: list[Counterfactual] = []
    with phase("trying changes", len(changes), "changes", log=_LOG) as step:
        for number, change in enumerate(changes):
            seconds = means.seconds_left() / (len(changes) - number)
            told(found, changes[number:])
            if seconds <= 0.0 or (means.cancelled is not None and means.cancelled()):
                return found, changes[number:]
            one = _tried(changed(problem, surroundings.scene, change), change, means, seconds, options)
            found = sorted([*found, *([] if one is None else [one])], key=_helpful)
            step()
    return found, ()


def _helpful(one: Counterfactual) -> tuple[bool, int]:
    return one.plan_actions is None, one.plan_actions or 0


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
    except InputError as error:
        if isinstance(change, BodyRemoved):  # without the body the problem is not valid: something else names it
            return None
        return Counterfactual(change, "not_tried", None, error.diagnostics[0].message)
    if result.plan is not None:
        return Counterfactual(change, result.status, plan_statistics(result.plan).plan_actions)
    return Counterfactual(change, result.status, None, _how_far(result) if result.status == "exhausted" else None)


def _how_far(result: Result) -> str:
    """How much was tried in vain: a few samples say less than many."""
    count, budget = result.statistics["inverse_kinematics_calls"], result.reason and result.reason.budget
    until = " until the time was up" if budget == "time" else ""
    return f"{counted(count, 'sample')} {'was' if count == 1 else 'were'} tried{until}"
