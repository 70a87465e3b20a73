"""What distance is missing where some is to be kept: for whom, how much there is, and how much is wanted.

What bodies keep from each other is asked for by `--clearance`, and by `uncertain` of scenes.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from math import floor, inf, log10

import numpy as np

from kabo import geometry  # its names load when they are used: python-fcl only here
from kabo.errors import CutOff
from kabo.geometry_server import (
    GeometryServer,
    Pair,
    ProcedureContext,
    Refusal,
    ScenePredicates,
    SceneSurroundings,
    Situation,
    millimetres,
)
from kabo.options import SMALLEST_EPSILON
from kabo.tasks.robots.motion.questions import MotionQuestion

STEPS = 8  # of a straight piece of motion at which the distance is measured
DIGITS = 2  # of an epsilon that is proposed, rounded down


def kept_between(surroundings: SceneSurroundings, situation: Situation | None, pair: Pair) -> float:
    """The distance that two bodies or links are to keep: the clearance, and what the scene says is uncertain [m].

    Args:
        surroundings: where they are asked about. situation: what robots carry; None: nothing. pair: their names.
    """
    robots = () if situation is None else situation.robots
    carriers = {name: robot for robot in robots if situation is not None for name in situation.carried(robot)}
    return sum(surroundings.kept(name, carriers.get(name)) for name in pair)


def told_distance(pair: Pair, apart: float, wanted: float, epsilon: float) -> str:
    """`o1 and o2 are 1.2 mm apart, but 3 mm are to be kept`, or that so much is there, and which epsilon may prove it.

    Args:
        pair: their names.
        apart, wanted: the distance that there is, and the one to be kept [m].
        epsilon: with which nothing was proven [m].
    """
    there, kept = millimetres(apart), millimetres(wanted)
    near = f"too near for a proof with this epsilon that {kept} are kept"
    if there == kept or 0.0 < apart - wanted < SMALLEST_EPSILON:  # no epsilon would do
        why = near
    elif apart < wanted:
        why = f"but {kept} are to be kept"
    else:
        why = f"{near} (try --epsilon {finer_epsilon(apart - wanted, epsilon):g})"
    return f"{pair[0]} and {pair[1]} are {there} apart, {why}"


def finer_epsilon(room: float, epsilon: float) -> float:
    """An epsilon with which the proof may succeed that failed with `epsilon`, where `room` is free [m]."""
    metres = min(room, epsilon / 2)
    unit = 10.0 ** (floor(log10(metres)) - DIGITS + 1)
    return round(floor(metres / unit + 1e-9) * unit, 12)


def least_distance(refusal: Refusal, surroundings: SceneSurroundings) -> float | None:
    """The least distance of the pair that came too close, on its original meshes [m].

    None of searches for a way, and of a hand at a target that no known configuration reaches.
    """
    asked = refusal.question
    if not isinstance(asked, MotionQuestion) or asked.is_search or not refusal.pairs:
        return None
    first, second = refusal.pairs[0][0]
    apart = inf
    for situation in _along(asked):
        things = ScenePredicates(surroundings, situation.first)
        apart = min(apart, float(geometry.exact_distance(things.thing(first), things.thing(second))))
    return None if apart == inf else apart


def _along(asked: MotionQuestion) -> Iterator[Situation]:
    """Where the robot is asked about: along its way points, or once where the hand alone is at a target."""
    path = [np.array(q) for q in asked.waypoints]
    hand = asked.refused_at() if not path else None
    if hand is not None:
        yield asked.scene.at(asked.robot, hand).situation
    for a, b in pairwise(path):
        for share in np.linspace(0.0, 1.0, STEPS, endpoint=False):
            yield asked.scene.at(asked.robot, a + share * (b - a)).situation
    for q in path[-1:]:
        yield asked.scene.at(asked.robot, q).situation


def nothing_kept(given: ProcedureContext) -> ProcedureContext:
    """A context in which bodies keep nothing from each other; all else is as in `given`."""
    own, scene = given.surroundings, replace(given.scene, uncertain={})
    return GeometryServer(scene, own.budget.epsilon, exact=own.exact).context()


def missing_distance(refusal: Refusal, relaxed: ProcedureContext) -> str | None:
    """What the kept distance alone refuses of an attempt, as a clause; None if it is refused without it, too.

    Args:
        refusal: the attempt.
        relaxed: as `nothing_kept` gives it.
    """
    asked = refusal.question
    if not isinstance(asked, MotionQuestion) or not refusal.pairs:
        return None
    pair = refusal.pairs[0][0]
    wanted = kept_between(asked.scene.context.surroundings, asked.scene.situation, pair)
    try:
        if wanted <= 0.0 or not asked.passes(relaxed):
            return None
    except CutOff:
        return None
    apart = least_distance(refusal, relaxed.surroundings)
    if apart is None:
        return f"{pair[0]} and {pair[1]} would be passed if no {millimetres(wanted)} were to be kept"
    return told_distance(pair, apart, wanted, relaxed.surroundings.budget.epsilon)
