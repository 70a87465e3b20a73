"""What a configuration check and a sweep check cost beside pinocchio, coal and python-fcl, on the same two arms.

    python benchmarks/kernel.py [--configurations N] [--takes N] [--segments N] [--scene both|generated|pandas] [--output F]

The scenes have the parts that planning would use, and the meshes that their URDFs name for collisions; peers are
asked with both, and the better counts. All contestants take turns on the same configurations, a hundred at a time;
they share one kinematic tree, and stop at the first hit. `uniform`: random configurations; `near`: both hands low
over the table and close.
Answers are compared: on the original meshes a contestant's hit that kabo calls free is *overlooked* (none may be),
a hit of kabo alone is *cautious* (kabo keeps a clearance around parts that enclose the meshes); on convex parts the
view compared has no clearance, so both counts should be zero.

Sweeps turn every joint of the first arm by 0.5 rad from a free configuration, all pairs checked. The parts stay the
same for every epsilon, those of the scene: a budget made by hand gives each body its scene's share and the sweep a
tenth of epsilon, and every body counts as if it used up its share, so that nothing but the sweep's own share is slack.
One peer samples the same segment on the original meshes, so densely that no corner of a body's box moves more than
2 epsilon between samples (*measured*: the fewest samples it could do with), or by how far the stretched arm would
carry a corner (*bounded*: what can be known without looking at the way). Another advances by distance: python-fcl's
distances of the original meshes prove an interval about its middle, or it is halved (kabo's exact geometry does so).
"""

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from kernel_peers import Kinematics, coal_managers, geometry_data, geometry_model, plain, tree_broad_phase
from kernel_scenes import Arrangement, scenes
from table import Table, finish, interleave, percentile

from kabo.arrays import Array
from kabo.geometry import Budget, CollisionView, ExactView

TURN = 100  # inputs in a row: whoever has a turn finds the caches full of the others' data; 1 % do, no percentile's worth
EPSILONS = (0.02, 0.005, 0.0005)
SAMPLED = 0.005  # the epsilon of the sampled contestants [m]


class Contestant(NamedTuple):
    """Who is asked; how kabo's answers are called that its answers are compared with."""

    ask: Callable[[Any], bool]
    compared: str | None = None


def race(
    contestants: dict[str, Contestant], inputs: Sequence[Any], takes: int = 1
) -> dict[str, tuple[list[float], list[bool]]]:
    """Microseconds and answers of every contestant on every input; they take turns after `TURN` inputs.

    Of several takes the least time of each input counts: what else runs on the machine only adds to it.
    """
    found: dict[str, tuple[list[float], list[bool]]] = {name: ([], []) for name in contestants}

    def turn(name: str) -> Callable[[Sequence[Any]], None]:
        ask, (times, answers) = contestants[name].ask, found[name]

        def go(values: Sequence[Any]) -> None:
            for value in values:
                began = perf_counter()
                answer = ask(value)
                times.append((perf_counter() - began) * 1e6)
                answers.append(bool(answer))

        return go

    for contestant in contestants.values():
        contestant.ask(inputs[0])
    turns, rounds = {name: turn(name) for name in contestants}, range(0, len(inputs), TURN)
    for _ in range(takes):
        interleave(turns, [inputs[i : i + TURN] for i in rounds])
    least = {name: np.reshape(times, (takes, -1)).min(axis=0).tolist() for name, (times, _) in found.items()}
    return {name: (least[name], answers[: len(inputs)]) for name, (_, answers) in found.items()}


def add_rows(
    table: Table,
    label: str,
    found: dict[str, tuple[list[float], list[bool]]],
    contestants: dict[str, Contestant],
    answers: dict[str, list[bool]],
) -> None:
    """One row for each contestant: microseconds, factors to the first one, answers compared."""
    own = next(iter(found.values()))[0]
    for name, (times, hits) in found.items():
        row: dict[str, Any] = {"set": label}
        for figure, share in (("p50", 0.5), ("p95", 0.95)):
            row[f"{figure} us"] = percentile(times, share)
            row[f"{figure} x"] = percentile(times, share) / percentile(own, share)
        row["mean us"] = sum(times) / len(times)
        row["hits"] = sum(hits) / len(hits)
        compared = contestants[name].compared
        if compared is not None:
            ours = answers[compared]
            row["overlooked"] = sum(theirs and not our for theirs, our in zip(hits, ours, strict=True))
            row["cautious"] = sum(our and not theirs for theirs, our in zip(hits, ours, strict=True))
        table.add(name, **row)


def uniform(scene: Arrangement, count: int, key: int) -> Array:
    """Random configurations (N, n) within the limits."""
    return np.random.default_rng(key).uniform(scene.tree.lower, scene.tree.upper, (count, scene.tree.size))


def near(scene: Arrangement, count: int, key: int) -> Array:
    """Configurations with both hands low over the table, in front of the bases and within 0.4 m of each other."""
    rng, kinematics, found = np.random.default_rng(key), Kinematics(scene), []
    half, waiting = scene.tree.size // 2, ([], [])  # each arm's low configurations, and where its hand is then
    while len(found) < count:
        q = rng.uniform(scene.tree.lower, scene.tree.upper)
        for arm, hand in enumerate(kinematics.points(q, scene.hands)):
            if 0 < hand[2] < 0.35 and hand[0] > scene.front:
                waiting[arm].append((q[arm * half : (arm + 1) * half], hand))
        while waiting[0] and waiting[1]:
            (first, at), (second, other) = waiting[0].pop(), waiting[1].pop()
            if np.linalg.norm(at - other) < 0.4:
                found.append(np.concatenate([first, second]))
    return np.array(found[:count])


def budget(scene: Arrangement, epsilon: float) -> Budget:
    """The parts' share as the scene has it, and for the sweep what `epsilon` gives it."""
    fixed = Budget.share(scene.geometry / 0.4)
    return Budget(fixed.geometry, 0.1 * epsilon, fixed.clearance, fixed.numeric)


def view(scene: Arrangement, spent: Budget, kind: Any = CollisionView) -> Any:
    """A view of all things and pairs."""
    return kind(scene.tree, *scene.groups, scene.pairs, spent)


def peers(scene: Arrangement) -> dict[str, Contestant]:
    """Everyone else, on convex parts and on the original meshes; they get (q, values of all joints)."""
    exact = view(scene, Budget.share(scene.geometry / 0.4), ExactView)
    found = {}
    for what, compared in (("meshes", "with clearance"), ("convex parts", "without")):
        models = Kinematics(scene).model, geometry_model(scene, what == "convex parts")
        found |= {
            f"pinocchio TreeBroadPhase, {what}": Contestant(tree_broad_phase(*models), compared),
            f"pinocchio BroadPhase, {what}": Contestant(tree_broad_phase(*models, "BroadPhaseManager"), compared),
            f"pinocchio computeCollisions, {what}": Contestant(plain(*models, geometry_data(models[1])), compared),
            f"coal managers, {what} (no pairs within an arm)": Contestant(coal_managers(scene, *models), None),
        }
    found["python-fcl managers, meshes"] = Contestant(
        lambda v: exact.configuration_hit(v[0]) >= 0, "with clearance"
    )
    return found


def check_table(scene: Arrangement, count: int, takes: int) -> Table:
    """The configuration check."""
    table = Table(f"Configuration check, {scene.name}: {scene.size}")
    shared = Budget.share(scene.geometry / 0.4)
    kabo, bare = view(scene, shared), view(scene, Budget(shared.geometry, shared.sweep, 0.0))
    others = peers(scene)
    for label, rows in (("uniform", uniform(scene, count, 1)), ("near", near(scene, count, 2))):
        inputs = [(q, scene.expand(q)) for q in rows]
        contestants = {"kabo": Contestant(lambda v: kabo.configuration_hit(v[0]) >= 0), **others}
        found = race(contestants, inputs, takes)
        answers = {"with clearance": found["kabo"][1], "without": (bare.configurations_hit(rows) >= 0).tolist()}
        add_rows(table, label, found, contestants, answers)
        began = perf_counter()
        kabo.configurations_hit(rows)
        table.add("kabo, batch", set=label, **{"mean us": (perf_counter() - began) / len(rows) * 1e6})
        own = {figure: percentile(found["kabo"][0], share) for figure, share in (("p50", 0.5), ("p95", 0.95))}
        best = {
            figure: min(
                percentile(times, share) / own[figure] for name, (times, _) in found.items() if name != "kabo"
            )
            for figure, share in (("p50", 0.5), ("p95", 0.95))
        }
        table.add(
            "best peer, whether on meshes or on parts",
            set=label,
            **{f"{figure} x": value for figure, value in best.items()},
        )
    return table


def segments(
    scene: Arrangement, starts: Array, free: Callable[[Array], bool], count: int
) -> list[tuple[Array, Array]]:
    """Segments from free configurations: every joint of the first arm turns by 0.5 rad, to the side that has room."""
    rng, found = np.random.default_rng(3), []
    for start in starts:
        if len(found) < count and free(start):
            step = np.zeros(scene.tree.size)
            step[scene.swept] = 0.5 * rng.choice([-1.0, 1.0], len(scene.swept))
            beyond = (start + step < scene.tree.lower) | (start + step > scene.tree.upper)
            found.append((start, start + np.where(beyond, -step, step)))
    return found


def sampler(scene: Arrangement, ask: Callable[[Any], bool], counts: dict[bytes, int]) -> Callable[[Any], bool]:
    """Whether any sample of a segment collides; the number of samples is known beforehand, at no cost."""

    def sampled(segment: tuple[Array, Array]) -> bool:
        start, end = segment
        first, last, count = scene.expand(start), scene.expand(end), counts[start.tobytes()]
        return any(ask((None, first + (last - first) * (i / count))) for i in range(count + 1))

    return sampled


def sample_counts(scene: Arrangement, chosen: Sequence[tuple[Array, Array]]) -> dict[str, dict[bytes, int]]:
    """How many steps of at most 2 epsilon of motion every segment has, by measure and by bound."""
    kinematics = Kinematics(scene)
    paths = {"measured": kinematics.longest_path, "bounded": kinematics.path_bound}
    return {
        how: {start.tobytes(): max(1, int(np.ceil(path(start, end) / (2 * SAMPLED)))) for start, end in chosen}
        for how, path in paths.items()
    }


def sweep_table(scene: Arrangement, count: int) -> Table:
    """The sweep check."""
    table = Table(
        f"Sweep check, {scene.name}: the first arm's joints turn by 0.5 rad, all {len(scene.pairs)} pairs"
    )
    full = scene.full()
    views = {epsilon: view(full, budget(scene, epsilon)) for epsilon in EPSILONS}
    ask = tree_broad_phase(Kinematics(scene).model, geometry_model(scene, convex_parts=False))
    for label, make in (("uniform", uniform), ("near", near)):
        starts = make(scene, 8 * count, 4)
        chosen = segments(scene, starts, lambda q: views[SAMPLED].configuration_hit(q) < 0, count)
        contestants = {f"kabo, epsilon {SAMPLED:g}": _sweeper(views[SAMPLED])}
        contestants |= {f"kabo, epsilon {e:g}": _sweeper(views[e]) for e in EPSILONS if e != SAMPLED}
        for how, counts in sample_counts(scene, chosen).items():
            typical = int(np.median(list(counts.values())))
            name = f"TreeBroadPhase, meshes, {typical} samples ({how})"
            contestants[name] = Contestant(sampler(scene, ask, counts), "swept")
        advancing = view(full, Budget.share(full.geometry / 0.4), ExactView)
        contestants["python-fcl distances, meshes, advancing"] = _sweeper(advancing)._replace(compared="swept")
        found = race(contestants, chosen)
        answers = {"swept": found[f"kabo, epsilon {SAMPLED:g}"][1]}
        add_rows(table, label, found, contestants, answers)
        clear = [i for i, hit in enumerate(answers["swept"]) if not hit]
        only = {
            name: ([times[i] for i in clear], [hits[i] for i in clear]) for name, (times, hits) in found.items()
        }
        if clear:
            add_rows(table, f"{label}, free", only, contestants, {"swept": [answers["swept"][i] for i in clear]})
        coarse, fine = (found[f"kabo, epsilon {e:g}"][0] for e in (0.005, 0.0005))
        dearer = {
            f: 100 * (percentile(fine, s) / percentile(coarse, s) - 1) for f, s in (("p50", 0.5), ("p95", 0.95))
        }
        dearer["mean"] = 100 * (sum(fine) / sum(coarse) - 1)
        table.add(
            "epsilon ten times finer costs, %", set=label, **{f"{f} us": value for f, value in dearer.items()}
        )
    return table


def _sweeper(asked: Any) -> Contestant:
    return Contestant(lambda segment: asked.segment_hit(*segment) >= 0)


def main() -> None:
    """Measures what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--configurations", type=int, default=400, metavar="N", help="of each set")
    parser.add_argument(
        "--takes", type=int, default=5, metavar="N", help="of each configuration; the least counts"
    )
    parser.add_argument("--segments", type=int, default=200, metavar="N", help="of each set")
    parser.add_argument("--scene", choices=("both", "generated", "pandas"), default="both")
    parser.add_argument("--output", type=Path, default=Path("kernel.json"), metavar="FILE")
    options = parser.parse_args()
    load, tables = os.getloadavg(), []
    for scene in scenes(options.scene):
        tables += [check_table(scene, options.configurations, options.takes), sweep_table(scene, options.segments)]
    settings = {name: value for name, value in vars(options).items() if name != "output"}
    finish(tables, options.output, **settings, load_before=[round(value, 2) for value in load])


if __name__ == "__main__":
    main()
