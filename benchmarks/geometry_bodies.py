"""Predicates on two bodies, whatever they hang on: collision and distance beside python-fcl on the original meshes.

Pairs of different links and things of a scene, turned at random, at distances around contact. What kabo answers is
compared with fcl's distance: both sides of [K Table 4.1], and whether the lower bound of a distance holds. The upper
bound, and free answers from epsilon on, are no better than the deviation that enclosures state, and those of these
scenes state one that nobody proved; tests/properties judge both on enclosures that keep theirs.
"""

from collections.abc import Callable
from itertools import combinations
from typing import Any, NamedTuple

import fcl
import numpy as np
from kernel import Contestant, race
from kernel_scenes import Arrangement, Thing, bar
from table import Table, percentile

from kabo.geometry import (
    Budget,
    Enclosure,
    FixedGroup,
    InnerSolid,
    Motion,
    MovingGroup,
    collides,
    distance,
    includes,
    sweep_collides,
    swept_volume,
)

FCL_TOLERANCE = 1e-6  # metres: what fcl's distance of meshes is taken to be good for
STANDING = np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])


class Pair(NamedTuple):
    """Two bodies as they stand, for kabo and for fcl."""

    bodies: tuple[FixedGroup, FixedGroup]
    objects: tuple[fcl.CollisionObject, fcl.CollisionObject]


def body_table(scene: Arrangement, count: int) -> Table:
    """Microseconds of every predicate on pairs of bodies, and how often an answer is on the wrong side."""
    table = Table(f"Predicates on two bodies around contact, {scene.name}, {count} pairs")
    budget, pairs = Budget.share(scene.geometry / 0.4), _pairs(scene, count)
    exact = race({"fcl": Contestant(lambda p: fcl.collide(*p.objects) > 0)}, pairs)["fcl"]
    gaps: list[float] = []
    fcl_seconds = _timed(lambda p: gaps.append(max(0.0, fcl.distance(*p.objects))), pairs)
    gaps = [0.0 if hit else gap for gap, hit in zip(gaps[-count:], exact[1], strict=True)]
    answers: list[Any] = []
    seconds = _timed(lambda p: answers.append(collides(*p.bodies, budget)), pairs)
    wrong = [
        (gap <= 0.0 and not answer) or (gap >= budget.epsilon + FCL_TOLERANCE and answer)
        for gap, answer in zip(gaps, answers[-count:], strict=True)
    ]
    _add(table, "collides, bounded (kabo)", seconds, wrong=sum(wrong))
    _add(table, "collides, python-fcl on the meshes", exact[0], other=seconds)
    bounds: list[Any] = []
    seconds = _timed(lambda p: bounds.append(distance(*p.bodies)), pairs)
    wrong = [gap < b.lower - FCL_TOLERANCE for gap, b in zip(gaps, bounds[-count:], strict=True)]
    _add(table, "distance, both bounds (kabo)", seconds, wrong=sum(wrong))
    _add(table, "distance, python-fcl on the meshes", fcl_seconds, other=seconds)
    return table


def _timed(ask: Callable[[Pair], Any], pairs: list[Pair]) -> list[float]:
    return race({"one": Contestant(ask)}, pairs)["one"][0]


def _add(
    table: Table, name: str, times: list[float], *, other: list[float] | None = None, wrong: int | None = None
) -> None:
    row: dict[str, Any] = {}
    for figure, share in (("p50", 0.5), ("p95", 0.95)):
        row[f"{figure} us"] = percentile(times, share)
        row[f"{figure} x"] = percentile(times, share) / percentile(other, share) if other else 1.0
    table.add(name, **row, wrong=wrong)


def _pairs(scene: Arrangement, count: int) -> list[Pair]:
    rng, kinds = np.random.default_rng(6), {id(thing.mesh[0]): thing for thing in scene.things}
    choices = list(combinations(kinds.values(), 2))
    models = {name: _model(thing) for name, thing in kinds.items()}
    found = []
    for _ in range(count):
        first, second = choices[int(rng.integers(len(choices)))]
        poses = [_turned(rng) for _ in range(2)]
        reach = sum(np.linalg.norm(np.ptp(t.mesh[0], axis=0)) for t in (first, second))
        along = rng.normal(size=3)
        poses[1][9:] += along / np.linalg.norm(along) * reach * rng.uniform(0.1, 0.5)
        for thing, pose in zip((first, second), poses, strict=True):
            pose[9:] -= pose[:9].reshape(3, 3) @ thing.mesh[0].mean(axis=0)
        things = list(zip((first, second), poses, strict=True))
        bodies = tuple(FixedGroup(pose, thing.enclosure) for thing, pose in things)
        objects = tuple(
            fcl.CollisionObject(models[id(t.mesh[0])], fcl.Transform(p[:9].reshape(3, 3), p[9:]))
            for t, p in things
        )
        found.append(Pair(bodies, objects))  # type: ignore[arg-type]
    return found


def _turned(rng: np.random.Generator) -> Any:
    """A pose (12,) at the origin, turned at random."""
    Q, R = np.linalg.qr(rng.normal(size=(3, 3)))
    Q *= np.sign(np.diag(R))
    return np.concatenate([(Q if np.linalg.det(Q) > 0 else -Q).ravel(), np.zeros(3)])


def _model(thing: Thing) -> fcl.BVHModel:
    vertices, faces = thing.mesh
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(faces))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model


def small_bodies() -> dict[str, Callable[[], Any]]:
    """Small tasks that compile the predicates on bodies, each once, in this order."""
    made: dict[str, Any] = {}
    corners = np.array([[i, j, k] for i in (-0.1, 0.1) for j in (-0.1, 0.1) for k in (-0.1, 0.1)])
    small = FixedGroup(STANDING, Enclosure((corners,), 0.0))
    turned = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6]]
        + [[0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )

    def motion() -> Motion:
        if "motion" not in made:
            tree = bar().tree
            q = (tree.lower + tree.upper) / 2
            made["motion"] = Motion(tree, (MovingGroup(3, STANDING, small.enclosure),), np.array([q, q + 0.05]))
        return made["motion"]

    budget = Budget.share(0.01)
    return {
        "collides": lambda: collides(small, small, budget),
        "distance": lambda: distance(small, small),
        "a motion": motion,
        "sweep collides": lambda: sweep_collides(motion(), small, budget),
        "includes": lambda: includes(InnerSolid(STANDING, 3 * corners, turned, 0.0), small, budget),
        "swept volume": lambda: swept_volume(motion(), 0.01).parts,
    }
