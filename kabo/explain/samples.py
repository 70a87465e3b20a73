"""Chooses refused attempts of a call to be looked at: a few of each reason, as states that differ from the start."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable

from kabo.explain.findings import Sample
from kabo.geometry_server import Pair, Refusal, Situation, whole_state
from kabo.plan import StateChange
from kabo.scene import Scene
from kabo.tasks.robots import changed_between

MAX_PER_ROW, MAX_ROWS = 4, 6  # samples of attempts that were refused alike, and reasons of which there are samples


def chosen_samples(
    scene: Scene,
    attempts: Iterable[Refusal],
    situation: Situation,
    kinds: list[Hashable],
    kind_of: Callable[[Refusal], Hashable],
    pair_of: Callable[[Refusal], Pair | None],
) -> tuple[Sample, ...]:
    """The first attempts of each kind as samples, the kinds in their order.

    Args:
        scene: the scene, whose start is what states differ from.
        attempts: the refused attempts.
        situation: where the call was made; it is shown for attempts that have no configuration of their own.
        kinds: the kinds of refusals, in the order of the rows of a finding.
        kind_of: the kind of an attempt.
        pair_of: the pair that came too close in an attempt, if any.
    """
    of_kind: dict[Hashable, list[Refusal]] = defaultdict(list)
    for each in attempts:
        if len(of_kind[kind_of(each)]) < MAX_PER_ROW:
            of_kind[kind_of(each)].append(each)
    found = []
    for row, kind in enumerate(kinds[:MAX_ROWS]):
        for each in of_kind[kind]:
            at = situation if each.question is None else each.question.sample()
            found.append(Sample(row, _change(scene, at), pair_of(each)))
    return tuple(each for k, each in enumerate(found) if each not in found[:k])


def _change(scene: Scene, situation: Situation) -> StateChange:
    return whole_state(scene, changed_between(Situation.of(scene.start), situation))
