"""Circles of waiting: a monitoring generator whose stage waits, directly or through others, for the generator itself.

A stage needs others before it can have a solution: a propagator the stage beside it, a connector both, a monitoring
generator the stage that it monitors, a container its children. What needs itself in this way never begins.
"""

from collections.abc import Mapping, Sequence

from kabo.tasks.core.model.containers import Container, Merger, Parallel, Serial
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.stages import Monitor, Stage


def circle(task: Container, flows: Mapping[Stage, Flow]) -> str | None:
    """Why no monitoring generator of a circle can begin, in a sentence that names its stages; None without a circle.

    Args:
        task: whose monitoring generators all monitor stages of the task.
        flows: of each of its stages.
    """
    needs = {stage: _needs(stage, flows[stage]) for stage in task.walk()}
    begun = _begun(needs)
    waiting: Stage | None = next(
        (stage for stage in needs if isinstance(stage, Monitor) and stage not in begun), None
    )
    way: list[Stage] = []
    while waiting is not None and waiting not in way:
        way.append(waiting)
        waiting = next(need for need in needs[waiting] if need not in begun)
    return None if waiting is None else _told(way[way.index(waiting) :])


def _needs(stage: Stage, flow: Flow) -> list[Stage]:
    """What must have a solution before a stage can have one; of a stage for which one of several will do, all of them."""
    if stage.children:
        return list(stage.children)
    if isinstance(stage, Monitor):
        return [stage.monitored]
    beside = [_beside(stage, -1)] if flow.reads_start else []
    beside += [_beside(stage, 1)] if flow.reads_end else []
    return [each for each in beside if each is not None]


def _beside(stage: Stage, step: int) -> Stage | None:
    """The stage that ends where this one begins (`step` -1), or begins where it ends (1); None at the task's border."""
    while stage.parent is not None:
        if isinstance(stage.parent, Serial):
            index = stage.parent.children.index(stage) + step
            if 0 <= index < len(stage.parent.children):
                return stage.parent.children[index]
        stage = stage.parent
    return None


def _begun(needs: Mapping[Stage, Sequence[Stage]]) -> set[Stage]:
    """The stages that nothing keeps from having a solution."""
    begun: set[Stage] = set()
    before = -1
    while before != len(begun):
        before = len(begun)
        for stage, needed in needs.items():
            one_does = isinstance(stage, Parallel) and not isinstance(stage, Merger)
            if (any if one_does else all)(need in begun for need in needed):
                begun.add(stage)
    return begun


def _told(around: Sequence[Stage]) -> str:
    """The circle as a sentence that begins at a monitoring generator."""
    first = next(i for i, stage in enumerate(around) if isinstance(stage, Monitor))
    around = [*around[first:], *around[:first]]
    links = [
        f"{'monitors' if isinstance(stage, Monitor) else 'waits for'} {after.path!r}"
        for stage, after in zip(around, [*around[1:], around[0]], strict=True)
    ]
    return (
        f"{around[0].path!r} {', which '.join(links)}: none of them can begin; "
        f"let {around[0].path!r} monitor a stage that needs none of these"
    )
