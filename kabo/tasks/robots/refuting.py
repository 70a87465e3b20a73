"""Proofs before any search that stages of a task fail, and what they mean for the containers around these stages."""

from collections.abc import Callable, Iterable

from kabo.geometry_server import ProcedureContext, Refusal, Situation
from kabo.tasks.core import Container, Stage, fails_given
from kabo.tasks.robots.declaring import RobotStage, is_optional
from kabo.tasks.robots.stages.states import FixedState


def refuted_stages(task: Container, context: ProcedureContext, situation: Situation) -> dict[Stage, Refusal]:
    """The stages of a task that are proven to fail if the task begins in a situation, each with its proof."""
    stages = (stage for stage in task.walk() if isinstance(stage, RobotStage))
    told = ((stage, stage.refute(context, situation)) for stage in stages)
    return {stage: why for stage, why in told if why is not None and _holds(why, stage, situation)}


def first_failing(
    stages: Iterable[RobotStage], why: Callable[[RobotStage], Refusal | None], situation: Situation
) -> tuple[RobotStage, Refusal] | None:
    """The first of a task's stages for whose refusal the whole task fails, with the refusal; None if there is none.

    Args:
        stages: those that may be refused, in order of time.
        why: the refusal of a stage in the situation, before any search; None if there is none.
        situation: that in which the task begins.
    """
    refused: set[Stage] = set()
    for stage in stages:
        refusal = why(stage)
        if refusal is None or not _holds(refusal, stage, situation):
            continue
        refused.add(stage)
        if not is_optional(stage) or fails_given(_task(stage), refused):
            return stage, refusal
    return None


def _holds(refusal: Refusal, stage: Stage, situation: Situation) -> bool:
    """Whether what a refusal reads is still as in the situation when the stage begins: no stage before moves it."""
    if not refusal.reads:
        return True
    names = refusal.reads | situation.carriers(refusal.reads)
    for before in _task(stage).walk():
        if before is stage:
            return True
        if _may_move(before, names):
            return False
    return True


def _task(stage: Stage) -> Container:
    """The task of a stage inside it."""
    above = stage.parent
    while above is not None and above.parent is not None:
        above = above.parent
    if not isinstance(above, Container):
        raise TypeError("a stage that is refused is part of a task")
    return above


def _may_move(stage: Stage, names: frozenset[str]) -> bool:
    if isinstance(stage, RobotStage):
        unknown = "object" in stage.MOVES and stage.undecided("object")
        return unknown or isinstance(stage, FixedState) or bool(names & {*stage.moves()})
    return not type(stage).__module__.startswith("kabo.")  # what stages of others do is not known
