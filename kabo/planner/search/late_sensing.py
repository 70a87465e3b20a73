"""Delays sensing until its result is needed, so that fewer steps are repeated in several branches.

A late step (a branching, or an action that only senses) moves behind the next step if neither step writes what the
other reads or writes, and if at most one of the two calls a procedure, since procedures do not commute. A late
step on which the next step depends stays in front of that step. A step that changes a goal conjunct stays behind
all sensing that this conjunct depends on: a bottle is looked at before it is carried to where only empty bottles
belong. A branching writes everything that it changed in this plan, including inferred facts, so the new order is
executed once as a test before it is used. Other outcomes of the branchings are not considered here.
"""

from typing import NamedTuple

from kabo.knowledge.queries import All, Some, union
from kabo.planner.search.nodes import Act, Assume, Node, SearchSpace, Step


class _OrderedStep(NamedTuple):
    """A step with masks of the bits that it reads and writes."""

    step: Step
    reads: int
    writes: int


def delay_sensing(space: SearchSpace, node: Node, steps: list[Step]) -> list[Step]:
    """The steps of a weak plan, reordered to sense as late as possible; they reach the same node.

    Args:
        space: the search space of the task.
        node: the node at which the steps begin.
        steps: a weak plan.
    """
    pieces, end = _pieces(space, node, steps)
    result: list[_OrderedStep] = []
    late: list[_OrderedStep] = []
    for piece in pieces:
        if is_late(piece.step, space.task.whether):
            late.append(piece)
            continue
        block = [piece]
        waiting: list[_OrderedStep] = []
        for sensing in reversed(late):
            (waiting if all(_independent(sensing, other) for other in block) else block).insert(0, sensing)
        late = waiting
        result += block
    delayed = [piece.step for piece in result + late]
    return delayed if delayed != steps and _reaches(space, node, delayed, end) else steps


def _pieces(space: SearchSpace, node: Node, steps: list[Step]) -> tuple[list[_OrderedStep], Node]:
    pieces = []
    together = [part.query.reads for part in space.task.goal if isinstance(part.query, Some | All)]
    for step in steps:
        after = space.after(node, step)
        changed = node[0] ^ after[0]
        if isinstance(step, Assume):
            reads = step.branching.mask | step.branching.reasons(node[0], step.outcome)
            pieces.append(_OrderedStep(step, reads, changed | step.branching.mask))
        else:
            reads = step.action.reads | step.action.reasons(node[0])
            reads |= union(weighed for weighed in together if weighed & step.action.effects.writes)
            pieces.append(_OrderedStep(step, reads, changed | step.action.effects.writes))
        node = after
    return pieces, node


def _reaches(space: SearchSpace, node: Node, steps: list[Step], end: Node) -> bool:
    for step in steps:
        after = space.possible(node, step)
        if after is None:
            return False
        node = after
    return node == end


def is_late(step: Step, entries: int) -> bool:
    """Whether a step may be delayed: a branching, or an action that senses and changes nothing else."""
    return isinstance(step, Assume) or bool(step.action.sense) and not step.action.effects.writes & ~entries


def _independent(first: _OrderedStep, second: _OrderedStep) -> bool:
    """Whether two neighbouring steps may be swapped."""
    one, other = first.step, second.step
    if _calls(one) and (_calls(other) or _tests(other)) or _tests(one) and _calls(other):
        return False
    return not (first.writes & (second.reads | second.writes) or first.reads & second.writes)


def _calls(step: Step) -> bool:
    return isinstance(step, Act) and step.action.call is not None


def _tests(step: Step) -> bool:
    return isinstance(step, Act) and (
        step.action.precondition.has_tests
        or any(update.condition.has_tests for update in step.action.effects.updates)
    )
