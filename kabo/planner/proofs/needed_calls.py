"""Which refused calls every plan needs: without one of them the goal is out of reach, even if nothing is ever lost.

A plan that fails names the call at which it failed; another plan may do without that call. What no plan does without
is what a person wants to hear about first.
"""

from collections.abc import Iterable, Sequence

from kabo.geometry_server.answers import Refusal
from kabo.knowledge import GroundedTask
from kabo.knowledge.reachability import relaxed_reach
from kabo.language.formulas import GroundCall

MAX_WORK = 4000  # actions times refused calls: some hundredths of a second; above, nothing is said


def needed_calls(task: GroundedTask, refused: Sequence[tuple[GroundCall, Refusal]]) -> frozenset[GroundCall]:
    """Those refused calls without which the goal is out of reach in the delete relaxation.

    Calls whose refusal is a proof that depends on nothing are left out of every plan first; if the goal is out of reach
    without these alone, they are the ones that are needed.
    """
    if len(task.actions) * len(refused) > MAX_WORK:
        return frozenset()
    never = frozenset(call for call, refusal in refused if refusal.proof and not refusal.reads)
    if never and not _reachable(task, never):
        return frozenset(call for call in never if not _reachable(task, {call})) or never
    return frozenset(call for call, _ in refused if call not in never and not _reachable(task, {*never, call}))


def needed_first(
    task: GroundedTask, refused: Sequence[tuple[GroundCall, Refusal]]
) -> list[tuple[GroundCall, Refusal]]:
    """The refused calls, those that every plan needs first, and otherwise in their order."""
    needed = needed_calls(task, refused) if len(refused) > 1 else frozenset()
    return sorted(refused, key=lambda item: item[0] not in needed)


def _reachable(task: GroundedTask, without: Iterable[GroundCall]) -> bool:
    """Whether every part of the goal can hold in the delete relaxation if some calls never succeed."""
    gone = frozenset(without)
    actions = [action for action in task.actions if action.call not in gone]
    reach = relaxed_reach(task.initial, actions, task.branchings, task.closure, by_layers=False)
    return all(part.query.possible(reach.ones, reach.zeros) for part in task.goal)
