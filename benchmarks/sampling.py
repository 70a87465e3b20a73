"""How many configurations on a constraint are found a second, beside Algorithm 3 in numpy and with pinocchio.

    python benchmarks/sampling.py [--samples N] [--rounds N] [--peers N] [--output FILE]

A sample is *valid* if every row holds within 1e-6 [m, rad], the tool is not upside down, and every joint is within
its limits. Seconds are of the processor. All contestants take turns, so that a slow minute hits all alike, and each
turn counts beside a plain loop of Python (*calibration*, millions of additions a second), as machines differ.

The peers do what [K Algorithm 3] says, with steps capped at 0.5 rad and whole turns taken back, as kabo does: one
with numpy and central differences, one with pinocchio's poses and Jacobians and the same analytic rows. Evenness is
that of 36 bins: of the angle of a rim grasp, and of the place across a table; *even* is with that angle, or place,
aimed at.
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
from kabo.kinematics import FrameFeature, Rows, rows_of, sample, seeds, stacked, values
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


def own(task: Task, count: int, free: Rows | None = None, rows: Rows | None = None) -> Array:
    """The valid ones of so many samples of kabo (N, n)."""
    tree, moving = task.tree, np.ones(task.tree.size, np.bool_)
    wanted = task.rows if rows is None else rows
    found, right = sample(tree, wanted, stream_key("bench"), 0, count, tree.lower, tree.upper, moving, free)
    return found[right]


def theirs(panda: Panda, task: Task, both: Callable[[Array], tuple[Array, Array]], first: int, count: int) -> int:
    """How many of so many seeds lead a peer to a valid configuration."""
    arms = PlainArms(panda, task)
    drawn = seeds(task.tree.lower, task.tree.upper, stream_key("bench"), first, count)
    found = [projected(both, task.tree, seed) for seed in drawn]
    return sum(q is not None and task.right(arms.poses(q)) for q in found)


def speed(panda: Panda, task: Task, table: Table, options: argparse.Namespace) -> None:
    """Three rows: kabo, its two peers."""
    makers = {"numpy, central differences": by_central_differences, "pinocchio's Jacobians": by_pinocchio}
    peers = {name: make(panda, task) for name, make in makers.items()}
    rates: dict[str, list[float]] = {"kabo": [], **{name: [] for name in peers}}
    shares: dict[str, float] = {}
    loops = []
    own(task, 10)
    for number in range(options.rounds):
        loops.append(calibration())
        began = process_time()
        valid = len(own(task, options.samples))
        rates["kabo"].append(valid / (process_time() - began))
        shares["kabo"] = valid / options.samples
        for name, both in peers.items():
            began = process_time()
            valid = theirs(panda, task, both, number * options.peers, options.peers)
            rates[name].append(valid / (process_time() - began))
            shares[name] = shares.get(name, 0.0) + valid / options.peers / options.rounds
    for name, found in rates.items():
        table.add(
            f"{task.name}: {name}",
            valid_share=shares[name],
            valid_per_s=round(median(found), 1),
            best_per_s=round(max(found), 1),
            promised=task.least if name == "kabo" else None,
            kabo_is_faster_by=None if name == "kabo" else median(rates["kabo"]) / max(median(found), 1e-9),
            calibration=round(median(loops), 2),
        )


def evenness(found: Sequence[float], low: float, high: float) -> tuple[float, float]:
    """How full the fullest and the emptiest of the bins are, relative to the mean."""
    counts, _ = np.histogram(found, BINS, (low, high))
    return float(counts.max() / counts.mean()), float(counts.min() / counts.mean())


def spread(every: Sequence[Task], panda: Panda, table: Table, count: int) -> None:
    """Rows with and without evening out, for the two constraints of [K Fig. 5.4]."""
    place, rim, _ = every
    across = rows_of("height", panda.feature("point"), FrameFeature(0, "plane", (0, 0, 0), (0, 1, 0)), -0.5, 0.5)
    ahead = rows_of(
        "height", panda.feature("point"), FrameFeature(0, "plane", (0.45, 0, 0), (1, 0, 0)), -0.15, 0.15
    )
    assert rim.free is not None
    cases = [
        ("place, y on the table", place, place.rows, None, across, 0.5),
        ("place, y on the table, even", place, stacked([place.rows, ahead, across]), None, across, 0.5),
        ("rim grasp, angle", rim, rim.rows, None, rim.free, np.pi),
        ("rim grasp, angle, even", rim, rim.rows, rim.free, rim.free, np.pi),
    ]
    for name, task, rows, free, coordinate, end in cases:
        began = process_time()
        Q = own(task, count, free, rows)
        seconds = process_time() - began
        most, least = evenness([float(values(coordinate, q, task.tree)[0]) for q in Q], -end, end)
        table.add(
            name, max_to_mean=most, min_to_mean=least, valid_share=len(Q) / count, valid_per_s=len(Q) / seconds
        )


def main() -> None:
    """Prints the tables, and writes them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=20_000, help="of kabo in each round")
    parser.add_argument("--peers", type=int, default=60, help="seeds of each peer in each round")
    parser.add_argument("--rounds", type=int, default=7)
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
