"""Repairs: the same skeleton, with other answers of the calls that led to what was refused.

Where plans branch, a search that starts over tells apart all that refusals name, in every branch. Mostly another sample
of one earlier call is all that is needed: another place for a cup, so that the hand that lets go of it has room.
"""

from collections.abc import Collection
from dataclasses import replace

from kabo.language.formulas import GroundCall
from kabo.planner.geometry.evaluation import Refused, in_order
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.search.skeleton import Skeleton, SkeletonNode


def repaired(skeleton: Skeleton, refused: Collection[Refused], ledger: RefusalTable) -> Skeleton | None:
    """The skeleton with the next attempts at the calls that are to blame; None if nothing that was sampled is.

    What failed at a later attempt begins with the first one again: it is given something else now.

    Args:
        skeleton: whose evaluation was refused.
        refused: the calls, noted in the ledger already.
        ledger: knows which call made what a refusal rests on.
    """
    responsible_attempt: set[tuple[GroundCall, int]] = set()
    failed = {(each.call, each.attempt) for each in refused}
    for each in refused:
        for trace in each.traces:
            step = ledger.responsible_attempt(each.call, each.failure, trace)
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
