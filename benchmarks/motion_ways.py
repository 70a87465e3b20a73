"""How long it takes kabo to find a proven way: problems of MotionBenchMaker, beside OMPL with pinocchio and coal.

    python benchmarks/motion_ways.py --problems RESOURCES/panda/problems [--every N] [--peer-every N] [--output FOLDER]

RESOURCES are those of VAMP: folders of problems as MoveIt writes them, beside the robot's URDF, SRDF and meshes. Each
problem becomes a scene. Counted are the problems whose ends kabo proves free; of them, how many are solved, the processor
time until the path is proven and shortened (warm: the scene is loaded, its bodies are prepared, and a search has run),
its length, and at how many poses of it the judge finds a collision on the original meshes. The peer is OMPL's
RRT-Connect with simplification, which samples edges and proves nothing, on each N-th of the same problems.
Needs pinocchio and coal; for the peer `pip install ompl`.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import motion_ways_peer as peer
import numpy as np
from motion_problems import MotionProblem, problems, robot_files
from table import Table, finish, percentile

import kabo
from kabo.geometry_server import GeometryServer, Refusal, Situation, Workspace, way_to

EPSILON = 0.01
SAMPLES = 1_000_000
PEER_SECONDS = 10.0  # of processor, after which OMPL gives up


@dataclass
class Outcome:
    """One problem: milliseconds, and the path of kabo; the same of the peer, where it was asked."""

    name: str
    milliseconds: float
    path: np.ndarray | None
    peer_milliseconds: float | None = None
    peer_path: np.ndarray | None = None
    colliding: int = 0
    peer_colliding: int = 0


def workspace(problem: MotionProblem, folder: Path) -> Workspace:
    """The robot among the bodies of a problem."""
    file = folder / "scene.yaml"
    file.write_text(problem.scene(EPSILON))
    scene = kabo.load_scene(file)
    server = GeometryServer(scene)
    return Workspace.of(server.surroundings, problem.robot.name, Situation.of(scene.start))


def solve(problem: MotionProblem, folder: Path, with_peer: bool) -> Outcome | None:
    """The outcome of one problem; None if an end is not free."""
    space = workspace(problem, folder)
    start = np.array(space.surroundings.scene.start.robots[problem.robot.name])
    goal = start.copy()
    goal[: space.robot.planned] = problem.goal
    if space.first_hit(start) or space.first_hit(goal):
        return None
    way_to(space, start, goal, ("warm",), 20)
    began = process_time()
    found = way_to(space, start, goal, ("ways", 0), SAMPLES)
    spent = 1000 * (process_time() - began)
    outcome = Outcome(problem.name, spent, None)
    world = peer.World(problem)
    if not isinstance(found, Refusal):
        outcome.path = np.array(found)[:, : space.robot.planned]
        outcome.colliding = world.colliding_poses(outcome.path)
    if with_peer:
        seconds, path = peer.ompl_way(problem, world, PEER_SECONDS)
        outcome.peer_milliseconds, outcome.peer_path = 1000 * seconds, path
        outcome.peer_colliding = 0 if path is None else world.colliding_poses(path)
    return outcome


def length(path: np.ndarray) -> float:
    """The length of a path [rad, L2]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def row(table: Table, name: str, asked: int, found: list[Outcome]) -> None:
    """One set of problems."""
    solved = [one for one in found if one.path is not None]
    beside = [one for one in found if one.peer_milliseconds is not None]
    both = [one for one in beside if one.path is not None and one.peer_path is not None]
    times, theirs = [one.milliseconds for one in found], [one.peer_milliseconds or 0.0 for one in beside]
    table.add(
        name,
        problems=asked,
        ends_free=len(found),
        solved=len(solved),
        solved_share=len(solved) / max(1, len(found)),
        p50_ms=percentile(times, 0.5) if times else None,
        p95_ms=percentile(times, 0.95) if times else None,
        mean_ms=float(np.mean(times)) if times else None,
        length_rad=float(np.mean([length(one.path) for one in solved])) if solved else None,
        colliding_poses=sum(one.colliding for one in found),
        peer_problems=len(beside),
        peer_solved=sum(one.peer_path is not None for one in beside),
        peer_p50_ms=percentile(theirs, 0.5) if beside else None,
        peer_p95_ms=percentile(theirs, 0.95) if beside else None,
        peer_colliding_poses=sum(one.peer_colliding for one in beside),
        times_faster=percentile([one.peer_milliseconds / one.milliseconds for one in both], 0.5) if both else None,
        peer_length_rad=float(np.mean([length(one.peer_path) for one in both])) if both else None,
        length_beside_rad=float(np.mean([length(one.path) for one in both])) if both else None,
    )


def main() -> None:
    """Solves the problems, set by set, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="each N-th problem of a set")
    parser.add_argument(
        "--peer-every", type=int, default=0, metavar="N", help="OMPL on each N-th of these; 0: never"
    )
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/motion_ways"), metavar="FOLDER")
    options = parser.parse_args()
    table = Table(f"Ways among obstacles: {options.problems.parent.name}")
    sets: dict[str, tuple[int, list[Outcome]]] = {}
    with TemporaryDirectory() as folder:
        urdf = robot_files(options.problems, Path(folder) / "robot")
        for number, problem in enumerate(problems(options.problems, urdf, options.every)):
            with_peer = options.peer_every > 0 and number % options.peer_every == 0
            outcome = solve(problem, Path(folder), with_peer)
            name = problem.name.partition("/")[0]
            asked, found = sets.get(name, (0, []))
            sets[name] = asked + 1, found + ([] if outcome is None else [outcome])
    for name, (asked, found) in sets.items():
        row(table, name, asked, found)
    row(
        table,
        "all",
        sum(asked for asked, _ in sets.values()),
        [one for _, found in sets.values() for one in found],
    )
    options.output.mkdir(parents=True, exist_ok=True)
    output = options.output / f"{options.problems.parent.name}.json"
    finish([table], output, epsilon=EPSILON, samples=SAMPLES, every=options.every, peer_every=options.peer_every)


if __name__ == "__main__":
    main()
