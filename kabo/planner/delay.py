"""Sensing is put off to where it is needed, so that fewer steps are repeated in several branches.

Late steps (branchings, and actions that only sense) let other steps pass if nothing that one writes is read or
written by the other, and if at most one of them calls a procedure: procedures do not commute. A step that must
wait for a late one takes it along. Independence is judged by all that a step *could* touch, so it holds for every
outcome.
"""

from collections.abc import Iterable

from kabo.knowledge.queries import union
from kabo.planner.space import Act, Decide, Step


def delay_sensing(steps: Iterable[Step], entries: int) -> list[Step]:
    """The steps in an order that senses as late as possible and reaches the same node.

    Args:
        steps: a weak plan.
        entries: all Kw and Kv bits; an action that writes nothing else only senses.
    """
    result: list[Step] = []
    late: list[Step] = []
    for step in steps:
        if is_late(step, entries):
            late.append(step)
            continue
        block = [step]
        waiting: list[Step] = []
        for sensing in reversed(late):
            (waiting if all(independent(sensing, other) for other in block) else block).insert(0, sensing)
        late = waiting
        result += block
    return result + late


def is_late(step: Step, entries: int) -> bool:
    """Whether a step may wait: it changes nothing but what is known at run time."""
    return isinstance(step, Decide) or bool(step.action.sense) and not step.action.effects.writes & ~entries


def independent(first: Step, second: Step) -> bool:
    """Whether two neighbouring steps may change places, whatever is sensed."""
    if _calls(first) and (_calls(second) or _tests(second)) or _tests(first) and _calls(second):
        return False
    return not (_writes(first) & (_reads(second) | _writes(second)) or _reads(first) & _writes(second))


def _writes(step: Step) -> int:
    return step.branching.mask if isinstance(step, Decide) else step.action.effects.writes


def _reads(step: Step) -> int:
    if isinstance(step, Decide):
        return step.branching.mask
    return step.action.precondition.reads | union(update.reads for update in step.action.effects.updates)


def _calls(step: Step) -> bool:
    return isinstance(step, Act) and step.action.call is not None


def _tests(step: Step) -> bool:
    return isinstance(step, Act) and (
        step.action.precondition.has_tests
        or any(update.condition.has_tests for update in step.action.effects.updates)
    )
