"""What margins permit meets nothing: bodies are displaced as far as is proven, and another program looks for collisions.

Random scenes: boxes stand close to where a gantry takes a mug, carries it over a plate, and puts it down. The judge knows
nothing of certificates: it takes the meshes and many moments of the rest of the plan [tests/support/oracles_motions.py].
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import fcl
import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.execution import Displacement, Margins
from kabo.execution.displacements import displacement
from kabo.execution.looks import rotation
from kabo.plan import Plan
from kabo.scene import Scene
from tests.support.oracles_motions import Judge, Moment, _between, replay_of, states_of
from tests.verify.certified import with_certificate
from tests.verify.counter import Counter, build, write_counter

SEEDS = range(6)
ALMOST = 0.999  # of what is proven
DRAWS = 24  # displacements for each scene


@dataclass(frozen=True, eq=False)
class Known:
    plan: Plan
    scene: Scene
    margins: Margins
    judge: Judge
    corners: dict[str, Array]  # (8, 3) of the boxes around movable bodies


def stones(rng: np.random.Generator) -> str:
    """Boxes that stand a few millimetres beside the ways of hand and mug, as lines of the scene."""
    lines = []
    for number, (x, side) in enumerate([(-0.3, 1.0), (-0.3, -1.0), (0.3, 1.0), (0.3, -1.0)]):
        half, gap, high = rng.uniform(0.01, 0.03), rng.uniform(0.001, 0.012), rng.uniform(0.1, 0.19)
        turn = float(rng.choice([0.0, rng.uniform(-0.5, 0.5)]))
        reach = half * (abs(np.cos(turn)) + abs(np.sin(turn)))
        across = number % 2 and rng.random() < 0.5  # before the hand instead of beside its palm
        place = (x + 0.02 + gap + reach, 0.0) if across else (x, side * (0.07 + gap + reach))
        pose = f"{{position: [{place[0]:.5f}, {place[1]:.5f}, {high / 2:.5f}], rpy: [0, 0, {turn:.4f}]}}"
        size = f"[{2 * half:.5f}, {2 * half:.5f}, {high:.5f}]"
        lines.append(f"  stone_{number}: {{box: {size}, pose: {pose}, movable: true}}")
    return "\n".join(lines)


@cache
def known(seed: int, folder: Path) -> Known:
    """A random scene with a plan made by hand, and what is proven of it."""
    folder.mkdir()
    path, rng = write_counter(folder), np.random.default_rng(seed)
    scene = folder / "scene.yaml"
    scene.write_text(scene.read_text().replace("  mug:\n", f"{stones(rng)}\n  mug:\n", 1))
    problem = kabo.load_problem(path)
    counter = Counter(problem, build(problem))
    plan = with_certificate(counter)
    loaded, report = kabo.load_scene(problem.scene), kabo.verify(problem, plan)
    assert report.ok, report
    corners = {name: loaded.bodies[name].mesh.box_corners for name in loaded.movable}
    return Known(plan, loaded, Margins(plan, report), Judge(loaded), corners)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("margins")


def rest(case: Known, node: str) -> Iterator[tuple[str, Moment, Moment]]:
    """All moments of the motions from a node on, with their nodes, and the first moment of the same segment."""
    states, ahead = states_of(case.plan, case.scene), [node]
    for name in ahead:
        for state in states[name]:
            first: Moment | None = None
            for moment in replay_of(case.scene, state, case.plan.nodes[name]).moments():
                first = moment if first is None or first.segment != moment.segment else first
                yield name, moment, first
        ahead += [after for after in case.plan.nodes[name].successors if after not in ahead]


def test_displaced_bodies_within_their_margins_meet_nothing_in_the_rest_of_the_plan(folder: Path) -> None:
    directed = looked = 0
    for seed in SEEDS:
        case = known(seed, folder / str(seed))
        rng = np.random.default_rng((7, seed))
        for _ in range(DRAWS):
            node = str(rng.choice([name for name, own in case.plan.nodes.items() if own.motion]))
            tolerance = case.margins.rest(node)
            assert tolerance is not None
            drawn = drawn_displacements(case, node, rng)
            slack = min(each.least for each in tolerance.slacks(drawn.claimed).values())
            assert slack >= 0.0
            ball = min(tolerance.radius(name).least for name in drawn.claimed)
            directed += max(each.size for each in drawn.claimed.values()) > 1.02 * ball
            for name, moment, first in rest(case, node):
                looked += 1
                hit = first_hit(case, moment, first, drawn.placed(case, name, moment))
                assert hit is None, f"{hit} at {name} {moment.time:.3f} s, seed {seed}: {drawn.claimed}"
    assert looked > 1000 and directed > DRAWS // 2  # many are larger than any ball that is proven


@dataclass(frozen=True, eq=False)
class Drawn:
    """Displacements: by a shift in the world and a turn until a body is handled, then by others of the same size."""

    claimed: dict[str, Displacement]
    shifts: dict[str, Array]  # (3,)
    turns: dict[str, Array]  # (3, 3) in the frame of the body
    later: dict[str, Array]  # (3,) shifts in the frame of the body
    handled: dict[str, int]  # of each body how many of the nodes, in the order of the plan, come before

    def placed(self, case: Known, node: str, moment: Moment) -> dict[str, Array]:
        """The poses of the displaced bodies."""
        found, number = {}, list(case.plan.nodes).index(node)
        for name in self.claimed:
            pose = moment.poses[name].copy()
            later = number >= self.handled[name]
            pose[:3, 3] += pose[:3, :3] @ self.later[name] if later else self.shifts[name]
            pose[:3, :3] = pose[:3, :3] @ self.turns[name]
            found[name] = pose
        return found


def drawn_displacements(case: Known, node: str, rng: np.random.Generator) -> Drawn:
    """Displacements of one to three bodies, almost as large as is proven."""
    tolerance, order = case.margins.rest(node), list(case.plan.nodes)
    assert tolerance is not None
    names = rng.permutation(list(case.scene.movable))[: int(rng.integers(1, 4))]
    sizes = {name: float(rng.uniform(0.5, 1.0)) for name in names}
    shares = {name: float(rng.choice([0.0, 0.3, 1.0])) for name in names}  # of the size, that is a turn
    shifts = {name: sizes[name] * (1.0 - shares[name]) * unit(rng) for name in names}
    axes = {
        name: sizes[name] * shares[name] / np.linalg.norm(case.corners[name], axis=1).max() * unit(rng)
        for name in names
    }
    at = order.index(node)
    handled = {
        name: next((k for k in range(at, len(order)) if name in case.margins.handled[order[k]]), len(order))
        for name in names
    }
    now = next(rest(case, node))[1].poses

    def scaled(scale: float) -> Drawn:
        turns = {name: rotation(scale * axes[name]) for name in names}
        found, later = {}, {}
        for name in names:
            pose = now[name].copy()
            pose[:3, 3] += scale * shifts[name]
            pose[:3, :3] = pose[:3, :3] @ turns[name]
            found[name] = displacement(now[name], pose, case.corners[name])
            turned = np.linalg.norm(case.corners[name] @ (turns[name] - np.eye(3)).T, axis=1).max()
            later[name] = max(0.0, found[name].size - float(turned))
        moved = {name: scale * shifts[name] for name in names}
        return Drawn(found, moved, turns, {name: size * away[name] for name, size in later.items()}, handled)

    away = {name: unit(rng) for name in names}
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        fits = min(each.least for each in tolerance.slacks(scaled(middle).claimed).values()) >= 0.0
        low, high = (middle, high) if fits else (low, middle)
    return scaled(ALMOST * low)


def unit(rng: np.random.Generator) -> Array:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def first_hit(case: Known, moment: Moment, first: Moment, poses: dict[str, Array]) -> tuple[str, str] | None:
    """Two things that overlap and may not, one of which moves."""
    moved = Moment(moment.time, moment.poses | poses, moment.permitted, moment.moving, moment.segment)
    for pair in case.judge._near(moved):
        if (
            frozenset(pair) in moment.permitted
            or np.abs(_between(pair, moment) - _between(pair, first)).max() < 1e-9
        ):
            continue  # they may touch, or do not move against each other
        if case.judge._overlap(pair, moved):
            return pair
    return None


@pytest.mark.parametrize("seed", SEEDS)
def test_margins_are_not_much_smaller_than_what_is_measured(seed: int, folder: Path) -> None:
    """At least 0.8 of the least distance of what comes nearest to each body, or all that is looked at."""
    case = known(seed, folder / str(seed))
    tolerance = case.margins.rest(case.plan.root)
    assert tolerance is not None
    measured = dict.fromkeys(case.scene.movable, tolerance.near)
    for _, moment, first in rest(case, case.plan.root):
        for pair in near_pairs(case, moment, tolerance.near):
            if np.abs(_between(pair, moment) - _between(pair, first)).max() < 1e-9:
                continue
            distance = fcl.distance(*case.judge._placed(pair, moment), fcl.DistanceRequest(), fcl.DistanceResult())
            for name in pair:
                if name in measured:
                    measured[name] = min(measured[name], distance)
    for name, distance in measured.items():
        assert tolerance.radius(name).least >= 0.8 * distance, name
        assert tolerance.radius(name).least <= distance + 1e-6, name


def near_pairs(case: Known, moment: Moment, near: float) -> Iterator[tuple[str, str]]:
    """Pairs with a movable body that are not permitted to touch, one of which moves, and whose balls are near."""
    judge = case.judge
    poses = np.array([moment.poses[name] for name in judge.names])
    centres = np.einsum("nij,nj->ni", poses[:, :3, :3], np.array(judge.centres)) + poses[:, :3, 3]
    for i, j in judge.pairs:
        first, second = judge.names[i], judge.names[j]
        if not {first, second} & set(case.scene.movable) or not {first, second} & moment.moving:
            continue
        if {first, second} <= moment.moving and "." not in first + second:
            continue  # in one hand
        apart = np.linalg.norm(centres[i] - centres[j]) - judge.radii[i] - judge.radii[j]
        if apart < near and frozenset((first, second)) not in moment.permitted:
            yield first, second
