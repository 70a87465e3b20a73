"""One branch of a plan on one clock: when each node begins, which outcomes it assumes, and what moves from rest to rest."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.motion import Trajectory
from kabo.plan import Node, Plan, Step, branch_of, plan_statistics, topological_order

SAME_TIME = 1e-9  # [s]
AT_REST = 1e-6  # [rad/s or m/s, and per s²]: slower is a rest


@dataclass(frozen=True)
class Choice:
    """What of a plan is exported to a format that has no branches.

    Attributes:
        branch: outcomes separated by commas, as many as the branch has; None: all of a plan without branches.
        node: in place of a branch: the motion of this node, and of nodes that begin before it has ended.
        robot: the only robot whose motion is exported; None: all.
    """

    branch: str | None = None
    node: str | None = None
    robot: str | None = None


@dataclass(frozen=True)
class TimedNode:
    """A node of the branch, from `begin` to `end` on the clock of the branch [s], and the outcome that is assumed."""

    name: str
    node: Node
    outcome: str | None
    begin: float
    end: float


@dataclass(frozen=True)
class Run:
    """What one robot's joints do from a rest to the next, on the clock of the branch; and what is then in its hand."""

    nodes: tuple[str, ...]
    robot: str
    trajectory: Trajectory
    attach: tuple[tuple[str, str], ...] = ()
    detach: tuple[str, ...] = ()


def refusal(file: str, message: str, hint: str | None = None) -> InputError:
    """The error about a plan."""
    return InputError([Diagnostic(file, 1, 1, message, hint)])


def require_followable(plan: Plan, file: str) -> None:
    """Checks that the plan can be followed: no cycle, and all branches lead over nodes that exist to goals.

    Raises:
        InputError: it cannot.
    """
    hint = "`kabo verify` says more"
    if plan.root not in plan.nodes:
        raise refusal(file, f"the plan begins at {plan.root}, which is no node of it", hint)
    for name, node in plan.nodes.items():
        for after in node.successors:
            if after not in plan.nodes:
                raise refusal(file, f"{name} leads to {after}, which is no node of the plan", hint)
        if node.kind != "goal" and not node.successors:
            raise refusal(file, f"{name} leads nowhere, and is no goal", hint)
    if topological_order(plan) is None:
        raise refusal(file, "the plan has a cycle", hint)


def timed_branch(plan: Plan, choice: Choice, file: str) -> list[TimedNode]:
    """The nodes that were chosen, in order; a node begins when the one before it ends, or earlier by its overlap.

    Raises:
        InputError: the plan branches further than was chosen, or what was chosen is not there.
    """
    steps = _one_motion(plan, choice.node, file) if choice.node is not None else _one_branch(plan, choice, file)
    timed: list[TimedNode] = []
    end = 0.0
    for name, outcome in steps:
        node = plan.nodes[name]
        begin = end - (node.overlap if timed else 0.0)
        end = max([end, *(begin + segment.times[-1] for segment in node.motion)])
        timed.append(TimedNode(name, node, outcome, begin, end))
    return timed


def runs_of(timed: Sequence[TimedNode], choice: Choice, file: str) -> list[Run]:
    """The motion from rest to rest of each robot's joints, in the order in which it begins.

    Raises:
        InputError: there is no motion, or none of the robot, or a segment has no trajectory, or never comes to rest.
    """
    require_motion(timed, choice.robot, file)
    runs: list[Run] = []
    latest: dict[tuple[str, tuple[str, ...]], int] = {}  # the number of the last run of these joints
    for run in _segments(timed, file):
        if choice.robot not in (None, run.robot):
            continue
        key = run.robot, run.trajectory.joints
        before = runs[latest[key]] if key in latest else None
        if before is not None and not _rests(before.trajectory):
            runs[latest[key]] = _joined(before, run, file)
        else:
            latest[key] = len(runs)
            runs.append(run)
    for run in runs:
        if not _rests(run.trajectory):
            raise refusal(file, f"{run.robot} is still moving at the end of {run.nodes[-1]}", "kabo verify")
    return sorted(runs, key=lambda run: run.trajectory.times[0])


def require_motion(timed: Sequence[TimedNode], robot: str | None, file: str) -> None:
    """Checks that there is motion, of the robot if one is named.

    Raises:
        InputError: there is none.
    """
    moving = sorted({segment.robot for each in timed for segment in each.node.motion})
    if not moving:
        what = "the plan has no motion" if len(timed) > 1 else f"{timed[0].name} has no motion"
        hint = "plan a problem with a scene" if len(timed) > 1 else "choose a node that moves something"
        raise refusal(file, f"{what}: nothing can be sent to a robot", hint)
    if robot is not None and robot not in moving:
        hint = did_you_mean(robot, moving) or f"{', '.join(moving)} can be chosen"
        raise refusal(file, f'no robot "{robot}" moves here', hint)


def _segments(timed: Sequence[TimedNode], file: str) -> Iterator[Run]:
    for each in timed:
        for segment in sorted(each.node.motion, key=lambda segment: segment.times[0]):
            if segment.trajectory is None:
                hint = "plan it anew: plans of the format kabo-plan/1 say nothing of velocities"
                raise refusal(file, f"{each.name} has no trajectory", hint)
            moved = segment.trajectory.shifted(each.begin)
            yield Run((each.name,), segment.robot, moved, segment.attach, segment.detach)


def _joined(first: Run, second: Run, file: str) -> Run:
    try:
        whole = first.trajectory.joined(second.trajectory)
    except ValueError as error:
        raise refusal(
            file, f"{second.robot} at the beginning of {second.nodes[0]}: {error}", "kabo verify"
        ) from None
    nodes = tuple(dict.fromkeys((*first.nodes, *second.nodes)))
    return replace(second, nodes=nodes, trajectory=whole, detach=(*first.detach, *second.detach))


def _rests(trajectory: Trajectory) -> bool:
    return all(np.abs(trajectory.at(trajectory.times[-1], order)).max(initial=0.0) < AT_REST for order in (1, 2))


def _one_branch(plan: Plan, choice: Choice, file: str) -> list[Step]:
    words = [] if choice.branch is None else choice.branch.split(",")
    if choice.branch is not None and choice.branch.strip() in plan.nodes:
        hint = f"--node {choice.branch.strip()} is its motion alone"
        raise refusal(file, f"{choice.branch} is a node, and a branch is chosen by its outcomes", hint)
    steps = branch_of(plan, choice.branch, file)
    asked = [name for name, outcome in steps if outcome is not None]
    if len(asked) > len(words):
        name = asked[len(words)]
        node = plan.nodes[name]
        outcomes = ",".join([*(word.strip() for word in words), next(iter(node.branches))])
        leaves = plan_statistics(plan).plan_leaves
        message = f"at {name} the plan branches on {node.on} ({', '.join(node.branches)})"
        hint = f"choose one of its {leaves} branches, as by --branch {outcomes}; --node N is one motion alone"
        raise refusal(file, f"{message}, and this format holds one branch", hint)
    return steps


def _one_motion(plan: Plan, name: str, file: str) -> list[Step]:
    if name not in plan.nodes:
        hint = did_you_mean(name, plan.nodes) or f"nodes are {', '.join(list(plan.nodes)[:6])} …"
        raise refusal(file, f'the plan has no node "{name}"', hint)
    before = next((other for other, node in plan.nodes.items() if node.next == name), None)
    if plan.nodes[name].overlap > 0.0 and before is not None:
        hint = f"--node {before} is the motion of both"
        raise refusal(file, f"{name} begins before {before} has ended: they move at once", hint)
    steps: list[Step] = [(name, None)]
    while (after := plan.nodes[name].next) is not None and plan.nodes[after].overlap > 0.0:
        steps.append((after, None))
        name = after
    return steps
