"""Repairs a skeleton: tries other answers of the earlier calls that a refused call depends on.

Where plans branch, a new search must distinguish in every branch everything that refusals name. Often another
sample for one earlier call is enough: for example another place for a cup, so that the hand can release it without
collision.
"""

from collections.abc import Collection
from dataclasses import replace

from kabo.language.formulas import GroundCall
from kabo.planner.geometry.evaluation import RefusedCall, in_order
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.search.skeleton import Skeleton, SkeletonNode


def repaired(skeleton: Skeleton, refused: Collection[RefusedCall], table: RefusalTable) -> Skeleton | None:
    """The skeleton with the next attempts at the calls responsible for the refusals; None if one has no such call.

    A refused call itself restarts at its first attempt, because its input has changed.

    Args:
        skeleton: the skeleton in which calls were refused.
        refused: the refused calls, already recorded in the table.
        table: the refusal table, which knows the call that produced each component.
    """
    responsible_attempt: set[tuple[GroundCall, int]] = set()
    failed = {(each.call, each.attempt) for each in refused}
    for each in refused:
        for trace in each.traces:
            step = table.responsible_attempt(each.call, each.refusal, trace)
            if step is None:
                return None
            responsible_attempt.add(step)
    made: dict[SkeletonNode, SkeletonNode] = {}
    for node in reversed(in_order(skeleton.root)):
        call = None if node.action is None else node.action.call
        step = None if call is None else (call, node.attempt)
        made[node] = replace(
            node,
            attempt=node.attempt + 1 if step in responsible_attempt else 0 if step in failed else node.attempt,
            outcomes=tuple((outcome, made[after]) for outcome, after in node.outcomes),
            next=None if node.next is None else made[node.next],
        )
    return Skeleton(made[skeleton.root])
