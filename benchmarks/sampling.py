"""How many configurations on a constraint are found a second, beside Algorithm 3 in numpy and with pinocchio.

    python benchmarks/sampling.py [--samples N] [--rounds N] [--peers N] [--output FILE]

A sample is *valid* if every row holds within 1e-6 [m, rad], the tool is not upside down, and every joint is within
its limits. Seconds are of the processor. All contestants take turns, so that a slow minute hits all alike, and each
turn counts beside a plain loop of Python (*calibration*, millions of additions a second), as machines differ.

*kabo, evened out* draws the pose first, the coordinates named below evenly, and solves the arms in closed form;
*kabo, projected* is what other rows and other arms get: random seeds, projected. One sample gives one configuration.

The peers do what [K Algorithm 3] says, with steps capped at 0.5 rad and whole turns taken back, as kabo does: one
with numpy and central differences, one with pinocchio's poses and Jacobians and the same analytic rows. Evenness is
that of 36 bins: of places on the table in a rectangle, of the angle of a rim grasp, and of where two arms hold a thing,
in a box. What is valid, and where it lies, is computed anew from pinocchio's poses.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
import pinocchio as pin
from sampling_tasks import APART, Panda, Task, tasks
from table import Table, finish

from kabo.arrays import Array
from kabo.kinematics import ClosedArm, Rows, drawn, drawn_together, sample, seeds, stacked, values
from kabo.kinematics.kernels.rows import LOWER, UPPER
from kabo.scene import KinematicTree
from kabo.streams import stream_key

STEP, TOLERANCE, ITERATIONS = 0.5, 1e-6, 50
BINS = 36


def calibration() -> float:
    """Millions of additions a second of a plain loop."""
    began, total = process_time(), 0
    for i in range(400_000):
        total += i
    return 0.4 / (process_time() - began)


# Peers --------------------------------------------------------------------------------------------------------------


class PlainArms:
    """Poses of the tools by numpy alone."""

    def __init__(self, panda: Panda, task: Task) -> None:
        self.count = task.tree.size // 7
        self.steps = [m.homogeneous for m in panda.model.jointPlacements][1:]
        self.tool = panda.joint_T_tool

    def poses(self, q: Array) -> list[Array]:
        """world_T_tool (4, 4) of each arm."""
        found = []
        for arm in range(self.count):
            pose = np.eye(4)
            pose[1, 3] = arm * APART
            for step, value in zip(self.steps, q[7 * arm :], strict=False):
                c, s = np.cos(value), np.sin(value)
                turn = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
                pose = pose @ step @ turn
            found.append(pose @ self.tool)
        return found


class PinocchioArms:
    """Poses and Jacobians of the tools by pinocchio."""

    def __init__(self, panda: Panda, task: Task) -> None:
        self.panda, self.count = panda, task.tree.size // 7
        self.data = [panda.model.createData() for _ in range(self.count)]

    def poses(self, q: Array) -> list[Array]:
        """world_T_tool (4, 4) of each arm; what `jacobians` needs is computed with them."""
        found = []
        for arm, data in enumerate(self.data):
            pin.computeJointJacobians(self.panda.model, data, q[7 * arm : 7 * arm + 7])
            pose = data.oMi[self.panda.joint].homogeneous @ self.panda.joint_T_tool
            pose[1, 3] += arm * APART
            found.append(pose)
        return found

    def jacobians(self) -> list[Array]:
        """(6, 7) of each tool: velocity of its centre, then turn."""
        found = []
        for data in self.data:
            J = pin.getJointJacobian(self.panda.model, data, self.panda.joint, pin.LOCAL_WORLD_ALIGNED)
            arm = data.oMi[self.panda.joint].rotation @ self.panda.joint_T_tool[:3, 3]
            found.append(np.vstack([J[:3] + np.cross(J[3:].T, arm).T, J[3:]]))
        return found


def by_central_differences(panda: Panda, task: Task) -> Callable[[Array], tuple[Array, Array]]:
    """Cost and Jacobian of a configuration as in [K Algorithm 3]."""
    arms = PlainArms(panda, task)

    def cost(q: Array) -> Array:
        poses = arms.poses(q)
        return np.array([row.value(poses) for row in task.costs])

    def both(q: Array) -> tuple[Array, Array]:
        steps = 1e-6 * np.eye(len(q))
        return cost(q), np.stack([(cost(q + s) - cost(q - s)) / 2e-6 for s in steps], axis=1)

    return both


def by_pinocchio(panda: Panda, task: Task) -> Callable[[Array], tuple[Array, Array]]:
    """Cost and Jacobian of a configuration by pinocchio and analytic rows."""
    arms = PinocchioArms(panda, task)

    def both(q: Array) -> tuple[Array, Array]:
        poses, jacobians = arms.poses(q), arms.jacobians()
        J = np.zeros((len(task.costs), len(q)))
        for i, row in enumerate(task.costs):
            for arm, (force, moment) in enumerate(row.wrenches(poses)):
                J[i, 7 * arm : 7 * arm + 7] = force @ jacobians[arm][:3] + moment @ jacobians[arm][3:]
        return np.array([row.value(poses) for row in task.costs]), J

    return both


def projected(both: Callable[[Array], tuple[Array, Array]], tree: KinematicTree, seed: Array) -> Array | None:
    """[K Algorithm 3] from one seed, with capped steps and whole turns taken back; None if it does not get there."""
    q = seed.copy()
    for _ in range(ITERATIONS):
        error, J = both(q)
        if np.abs(error).max() <= 0.15 * TOLERANCE:
            q = np.where(q > tree.upper, q - 2 * np.pi, np.where(q < tree.lower, q + 2 * np.pi, q))
            return q if np.all((tree.lower <= q) & (q <= tree.upper)) else None
        step = np.linalg.pinv(J) @ error
        q = q - step * min(1.0, STEP / max(float(np.abs(step).max()), 1e-12))
    return None


# Figures ------------------------------------------------------------------------------------------------------------


def own(task: Task, count: int, free: Rows | None = None) -> Array:
    """The valid ones of so many samples of kabo, projected (N, n); they aim at the coordinates `free`."""
    tree, moving = task.tree, np.ones(task.tree.size, np.bool_)
    found, right = sample(tree, task.rows, stream_key("bench"), 0, count, tree.lower, tree.upper, moving, free)
    return found[right]


def even(task: Task, arms: Sequence[ClosedArm], count: int) -> Array:
    """The valid ones of so many samples of kabo, drawn pose first (N, n)."""
    key = stream_key("bench")
    if len(arms) == 1:
        made = drawn(arms[0], task.rows, key, 0, count, free=task.free)
        return np.empty((0, task.tree.size)) if made is None else made[0]
    found = drawn_together(arms, task.joined, task.rows, key, 0, count, free=task.free)
    return np.empty((0, task.tree.size)) if found is None else found[0][found[1]]


def proven(panda: Panda, task: Task, Q: Array) -> float:
    """The share of configurations that are valid by pinocchio: costs, the way up, limits."""
    arms, tree = PinocchioArms(panda, task), task.tree

    def valid(q: Array) -> bool:
        poses = arms.poses(q)
        within = bool(np.all((tree.lower <= q) & (q <= tree.upper)))
        return within and task.right(poses) and all(abs(cost.value(poses)) <= TOLERANCE for cost in task.costs)

    return float(np.mean([valid(q) for q in Q]))


def theirs(panda: Panda, task: Task, both: Callable[[Array], tuple[Array, Array]], first: int, count: int) -> int:
    """How many of so many seeds lead a peer to a valid configuration."""
    arms = PlainArms(panda, task)
    drawn = seeds(task.tree.lower, task.tree.upper, stream_key("bench"), first, count)
    found = [projected(both, task.tree, seed) for seed in drawn]
    return sum(q is not None and task.right(arms.poses(q)) for q in found)


def speed(panda: Panda, task: Task, table: Table, options: argparse.Namespace) -> None:
    """Five rows: kabo evened out, evened out and projected by projection, its two peers."""
    makers = {"numpy, central differences": by_central_differences, "pinocchio's Jacobians": by_pinocchio}
    peers = {name: make(panda, task) for name, make in makers.items()}
    arms = [panda.arm(k * APART) for k in range(len(task.joined.values))]
    ways: dict[str, Callable[[int], Array]] = {
        "kabo, evened out": lambda count: even(task, arms, count),
        "kabo, projected": lambda count: own(task, count),
        "kabo, projected onto aims": lambda count: own(task, count, task.free),
    }
    rates: dict[str, list[float]] = {name: [] for name in (*ways, *peers)}
    shares: dict[str, float] = {}
    loops = []
    for make in ways.values():
        make(10)
    for number in range(options.rounds):
        loops.append(calibration())
        for name, make in ways.items():
            began = process_time()
            valid = len(make(options.samples))
            rates[name].append(valid / (process_time() - began))
            shares[name] = valid / options.samples
        for name, both in peers.items():
            began = process_time()
            valid = theirs(panda, task, both, number * options.peers, options.peers)
            rates[name].append(valid / (process_time() - began))
            shares[name] = shares.get(name, 0.0) + valid / options.peers / options.rounds
    best = median(rates["kabo, evened out"])
    for name, found in rates.items():
        table.add(
            f"{task.name}: {name}",
            valid_share=shares[name],
            valid_per_s=round(median(found), 1),
            best_per_s=round(max(found), 1),
            promised=task.least if name == "kabo, evened out" else None,
            evened_out_is_faster_by=None if name == "kabo, evened out" else best / max(median(found), 1e-9),
            proven_by_pinocchio=proven(panda, task, ways[name](options.proofs)) if name in ways else None,
            calibration=round(median(loops), 2),
        )


def evenness(found: Sequence[float], low: float, high: float) -> tuple[float, float]:
    """How full the fullest and the emptiest of the bins are, relative to the mean."""
    counts, _ = np.histogram(found, BINS, (low, high))
    return float(counts.max() / counts.mean()), float(counts.min() / counts.mean())


COORDINATES = {
    "place on a plane": ("x on the table", "y on the table"),
    "rim grasp of a cylinder": ("angle",),
    "one thing held by two arms": ("x of the thing", "y of the thing", "z of the thing"),
}


def spread(every: Sequence[Task], panda: Panda, table: Table, count: int) -> None:
    """How evenly the coordinates lie: evened out, and projected onto the same rows without aims."""
    for task in every:
        arms = [panda.arm(k * APART) for k in range(len(task.joined.values))]
        for way, Q in (("even", even(task, arms, count)), ("projected", own(task, count))):
            for name, row in zip(COORDINATES[task.name], task.free, strict=True):
                at = [float(values(stacked([row[None]]), q, task.tree)[0]) for q in Q]
                most, least = evenness(at, float(row[LOWER]), float(row[UPPER]))
                table.add(f"{task.name}, {name}: {way}", max_to_mean=most, min_to_mean=least)


def main() -> None:
    """Prints the tables, and writes them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=20_000, help="of kabo in each round")
    parser.add_argument("--peers", type=int, default=60, help="seeds of each peer in each round")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--proofs", type=int, default=2000, help="samples of each kind that pinocchio looks at")
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    panda = Panda.load()
    every = tasks(panda)
    rates = Table("Valid samples a second of the processor (median of the rounds), on Panda arms")
    for task in every:
        speed(panda, task, rates, options)
    even = Table(f"Evenness over {BINS} bins: how full the fullest and the emptiest bin is, relative to the mean")
    spread(every, panda, even, options.samples)
    finish([rates, even], options.output, samples=options.samples, peers=options.peers, rounds=options.rounds)


if __name__ == "__main__":
    main()
