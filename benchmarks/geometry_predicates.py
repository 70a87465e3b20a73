"""Proposition 4 and Figure 4.9 of the thesis on our scenes: bounded predicates beside exact ones.

`uniform` and `near` are the configurations of `kernel.py`. Bounded: kabo's view of enclosing convex parts. Exact:
python-fcl's managers on the original meshes, which `--geometry exact` uses; its own speed stands beside trimesh's and
pinocchio's on the same meshes. Figure 4.9 varies the geometry in one library: there, meshes and the hulls of whole
bodies in python-fcl. All take turns on the same inputs; `overlooked` counts hits on the meshes that kabo calls free.
The bars compare distributions, as that figure does: the 95th percentile of one by the 95th percentile of the other.
Beside them stand the percentiles of the ratios that single configurations have, which is another question.
Contestants take turns of a hundred: the first check of a turn finds the caches full of the others' data, which makes
one of 3 us four or five times as long. In turns of twenty those were 5 %, and the 95th percentile showed just them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh
from geometry_bodies import body_table, small_bodies
from geometry_chart import write_chart
from kernel import Contestant, near, race, segments, uniform, view
from kernel_peers import Ask, Kinematics, geometry_data, geometry_model, plain, tree_broad_phase
from kernel_scenes import Arrangement, Thing, bar, scenes
from scipy.spatial import ConvexHull
from table import Table, percentile

from kabo.geometry import Budget, ExactView, contains

MEDIAN_BAR, TAIL_BAR = 10.0, 30.0  # exact to bounded, near configurations
BOUNDED, EXACT = "bounded (kabo)", "exact (python-fcl managers, meshes)"
Times = dict[str, tuple[list[float], list[bool]]]


def predicate_tables(output: Path, which: str, count: int) -> list[Table]:
    """Checks of configurations and of segments; the bars; charts of the distributions."""
    bars = Table("Exact to bounded predicates: what must be reached")
    tables = [table for scene in scenes(which) for table in _scene(scene, output, count, bars)]
    return [*tables, bars]


def _scene(scene: Arrangement, output: Path, count: int, bars: Table) -> list[Table]:
    checks = Table(f"Configuration checks, {scene.name}: {scene.size}")
    sweeps = Table(f"Segments, every joint of the first arm turns by 0.5 rad, {scene.name}")
    shared = Budget.share(scene.geometry / 0.4)
    bounded, exact = view(scene, shared), view(scene, shared, ExactView)
    ask = {BOUNDED: Contestant(lambda v: bounded.configuration_hit(v[0]) >= 0)}
    ask |= {EXACT: Contestant(lambda v: exact.configuration_hit(v[0]) >= 0)}
    ask |= peers(scene)
    swept = {BOUNDED: Contestant(lambda s: bounded.segment_hit(*s) >= 0)}
    swept |= {EXACT: Contestant(lambda s: exact.segment_hit(*s) >= 0)}
    for label, make in (("uniform", uniform), ("near", near)):
        rows = make(scene, count, 5)
        found = race(ask, [(q, scene.expand(q)) for q in rows])
        _add(checks, label, found)
        _distribution(output / f"checks_{scene.name.replace(' ', '_')}_{label}.svg", scene, label, found)
        few = segments(scene, rows, lambda q: bounded.configuration_hit(q) < 0, max(10, count // 20))
        _add(sweeps, label, race(swept, few))
        if label == "near":
            _bars(bars, scene.name, found)
    return [checks, sweeps, body_table(scene, count)]


def peers(scene: Arrangement) -> dict[str, Contestant]:
    """Who else checks the original meshes; and python-fcl on the hulls of whole bodies."""
    model, meshes = Kinematics(scene).model, geometry_model(scene, convex_parts=False)
    hulls = view(hulled(scene), Budget.share(scene.geometry / 0.4), ExactView)
    return {
        "pinocchio TreeBroadPhase, meshes": Contestant(tree_broad_phase(model, meshes)),
        "pinocchio computeCollisions, meshes": Contestant(plain(model, meshes, geometry_data(meshes))),
        "trimesh managers, meshes (no pairs within an arm)": Contestant(trimesh_managers(scene)),
        "python-fcl managers, hulls": Contestant(lambda v: hulls.configuration_hit(v[0]) >= 0),
    }


def hulled(scene: Arrangement) -> Arrangement:
    """The scene with the hull of each thing for its mesh."""

    def hull(thing: Thing) -> Thing:
        made = ConvexHull(thing.mesh[0])
        names = np.full(len(made.points), -1)
        names[made.vertices] = np.arange(len(made.vertices))
        return replace(thing, mesh=(made.points[made.vertices], names[made.simplices]))

    return replace(scene, things=tuple(map(hull, scene.things)))


def trimesh_managers(scene: Arrangement) -> Ask:
    """Trimesh's managers: each arm against the other and against all that stands, its bases left out."""
    model, joints = Kinematics(scene).model, len(scene.tree.parent) // 2
    data = model.createData()
    managers = [trimesh.collision.CollisionManager() for _ in range(3)]
    moving = []
    for thing in scene.things:
        if thing.joint == 0 and "." in thing.name:
            continue
        owner = 2 if thing.joint == 0 else int(thing.joint > joints)
        managers[owner].add_object(thing.name, trimesh.Trimesh(*thing.mesh, process=False), transform=thing.pose)
        if thing.joint:
            moving.append((managers[owner], thing))

    def ask(value: tuple[Any, Any]) -> bool:
        pin.forwardKinematics(model, data, value[1])
        for manager, thing in moving:
            manager.set_transform(thing.name, data.oMi[thing.joint].homogeneous @ thing.pose)
        meetings = ((0, 1), (0, 2), (1, 2))
        return any(managers[a].in_collision_other(managers[b]) for a, b in meetings)

    return ask


def _add(table: Table, label: str, found: Times) -> None:
    own, ours = found[BOUNDED]
    for name, (times, hits) in found.items():
        row: dict[str, Any] = {"set": label}
        for figure, share in (("p50", 0.5), ("p95", 0.95), ("max", 1.0)):
            row[f"{figure} us"] = percentile(times, share)
            row[f"{figure} x"] = percentile(times, share) / percentile(own, share)
        row["hits %"] = 100.0 * sum(hits) / len(hits)
        if "meshes" in name and "no pairs" not in name:
            row["overlooked"] = sum(theirs and not our for theirs, our in zip(hits, ours, strict=True))
        table.add(name, **row)


def _bars(bars: Table, scene: str, found: Times) -> None:
    for figure, share, bar_ in (("median", 0.5, MEDIAN_BAR), ("95th percentile", 0.95, TAIL_BAR)):
        ratio = percentile(found[EXACT][0], share) / percentile(found[BOUNDED][0], share)
        met = "yes" if ratio >= bar_ else "NO"
        bars.add(f"{scene}: {figure} of near configurations", bar=f">= {bar_:g}", found=ratio, met=met)
        single = [exact / own for exact, own in zip(found[EXACT][0], found[BOUNDED][0], strict=True)]
        bars.add(f"{scene}: {figure} of the ratios of single configurations", found=percentile(single, share))
        others = [percentile(times, share) for name, (times, _) in found.items() if name.endswith(", meshes")]
        quickest = min(others) / percentile(found[BOUNDED][0], share)
        bars.add(f"{scene}: {figure}, quickest other on the meshes", found=quickest)


def _distribution(path: Path, scene: Arrangement, label: str, found: Times) -> None:
    """What share of the checks took longer than a time, as in [K Fig. 4.9] on a logarithmic axis."""
    lines = {
        name.split(" (no")[0]: [(t, 100.0 * (1 - k / len(times))) for k, t in enumerate(sorted(times))]
        for name, (times, _) in found.items()
    }
    title = f"{scene.name}, {label} configurations"
    write_chart(path, title, "microseconds of a check", "% that take longer", lines, log_y=False)


def small_predicates() -> dict[str, Callable[[], Any]]:
    """Small tasks that compile the predicates, each once, in this order."""
    made: dict[str, Any] = {}

    def prepare() -> None:
        scene = bar()
        made["view"] = view(scene, Budget.share(scene.geometry / 0.4))
        made["q"] = (scene.tree.lower + scene.tree.upper) / 2

    def box() -> Sequence[Any]:
        return (np.vstack([np.eye(3), -np.eye(3)]), np.ones(6))

    return {
        "a scene": prepare,
        "configuration check": lambda: made["view"].configuration_hit(made["q"]),
        "configurations check": lambda: made["view"].configurations_hit(np.array([made["q"]] * 2)),
        "sweep check": lambda: made["view"].segment_hit(made["q"], made["q"] + 0.01),
        "points in a region": lambda: contains(box(), np.zeros((1, 3)), 1e-9),
        **small_bodies(),
    }
