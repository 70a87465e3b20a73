"""Repairs: the same skeleton, with other answers of the calls that led to what was refused.

Where plans branch, a search that starts over tells apart all that refusals name, in every branch. Mostly another sample
of one earlier call is all that is needed: another place for a cup, so that the hand that lets go of it has room.
"""

from collections.abc import Iterable
from dataclasses import replace

from kabo.language.formulas import GroundCall
from kabo.planner.evaluation import Refused, in_order
from kabo.planner.ledger import Ledger
from kabo.planner.skeleton import Skeleton, SkeletonNode

REPAIRS = 24  # of one skeleton, before another one is looked for


def repaired(skeleton: Skeleton, refused: Iterable[Refused], ledger: Ledger) -> Skeleton | None:
    """The skeleton with the next attempts at the calls that are to blame; None if nothing that was sampled is.

    Args:
        skeleton: whose evaluation was refused.
        refused: the calls, noted in the ledger already.
        ledger: knows which call made what a refusal rests on.
    """
    blamed: set[tuple[GroundCall, int]] = set()
    for each in refused:
        for trace in each.traces:
            step = ledger.blamed(each.call, each.failure, trace)
            if step is None:
                return None
            blamed.add(step)
    made: dict[SkeletonNode, SkeletonNode] = {}
    for node in reversed(in_order(skeleton.root)):
        call = None if node.action is None else node.action.call
        again = call is not None and (call, node.attempt) in blamed
        made[node] = replace(
            node,
            attempt=node.attempt + again,
            outcomes=tuple((outcome, made[after]) for outcome, after in node.outcomes),
            next=None if node.next is None else made[node.next],
        )
    return Skeleton(made[skeleton.root])
