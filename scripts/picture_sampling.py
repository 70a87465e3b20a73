"""Draws how evenly samples lie on two constraints: `python -m scripts.picture_sampling` (extra `pictures`).

[K Fig. 5.4] with the six-axis arm of BARTENDER: an object put down anywhere on a table, by its place across it, and a
cylinder grasped at its rim with one finger inside, by the angle. First as [K Algorithm 3] is printed, with full steps
and whatever limits say; then as kabo projects random seeds; last with the place, or the angle, aimed at. Prints how
full the fullest and the emptiest bin is.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np

import kabo
from kabo.arrays import Array
from kabo.geometry_server import Frame, tool_frame
from kabo.kinematics import FrameFeature, Rows, jacobian, rows_of, sample, seeds, stacked, values
from kabo.kinematics.kernels import rows as columns
from kabo.language.scene_description import Feature
from kabo.scene import KinematicTree, Robot
from kabo.streams import stream_key

mpl.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
PROBLEM, ARM = ROOT / "domains" / "bartender" / "four_bottles.yaml", "left"
SAMPLES, FEWER, BINS = 30_000, 8_000, 24
AHEAD, ASIDE = (0.2, 0.7), 0.5  # the table before the arm: from and to, and half its width [m]
RADIUS, CYLINDER = 0.04, (0.7, 0.1)  # how wide it is, and where it stands before the arm [m]


@dataclass(frozen=True)
class Histogram:
    """Samples along one coordinate of a constraint: as in the thesis, from random seeds, and aimed at."""

    title: str
    label: str
    end: float  # the coordinate goes from -end to end
    printed: Array
    plain: Array
    even: Array

    def fullness(self, found: Array) -> Array:
        """How full each bin is, relative to the mean."""
        counts, _ = np.histogram(found, BINS, (-self.end, self.end))
        return np.asarray(counts / counts.mean())


def printed(tree: KinematicTree, moving: Array, rows: Rows) -> Array:
    """What [K Algorithm 3] as printed makes of fewer seeds (N, n): Gauss-Newton by the pseudo-inverse, full steps."""
    found = []
    for seed in seeds(tree.lower, tree.upper, stream_key("printed"), 0, FEWER):
        q = np.where(moving, seed, 0.0)
        for _ in range(30):
            error = rows[:, columns.SCALE] * (values(rows, q, tree) - rows[:, columns.LOWER])
            if np.abs(error).max() < 1e-7:
                found.append(q)
                break
            J = rows[:, columns.SCALE, None] * jacobian(rows, q, tree) * moving
            q = q - np.linalg.pinv(J, rcond=1e-6) @ error
    return np.array(found)


def drawn(tree: KinematicTree, moving: Array, rows: Rows, free: Rows | None = None) -> Array:
    """The valid configurations of so many samples (N, n)."""
    key = stream_key("picture")
    found, right = sample(tree, rows, key, 0, SAMPLES, tree.lower, tree.upper, moving, free)
    return found[right]


def histograms(robot: Robot) -> tuple[Histogram, Histogram]:
    """Place on a table, and rim grasp of a cylinder, before the arm."""
    tool, tree = tool_frame(robot), robot.tree
    moving = np.arange(tree.size) < robot.planned
    base = robot.links["base_link"].joint_T_link[:3, 3]
    tip, approach, closing = (tool.feature(name) for name in ("tcp", "approach", "closing"))
    across = _across(tool, tip)
    table = FrameFeature(0, "plane", (0.0, 0.0, float(base[2])), (0.0, 0.0, 1.0))
    over = stacked([rows_of("height", tip, table, 0.1, 0.1), rows_of("opposed", approach, table)])
    forward = rows_of("height", tip, _plane(base, 0), *AHEAD)
    sideways = rows_of("height", tip, _plane(base, 1), -ASIDE, ASIDE)
    axis = FrameFeature(
        0, "line", (float(base[0] + CYLINDER[0]), float(base[1] + CYLINDER[1]), float(base[2])), (0.0, 0.0, 1.0)
    )
    rim = stacked(
        [
            rows_of("distance", tip, axis, RADIUS, RADIUS),
            rows_of("height", tip, table, 0.15, 0.15),
            rows_of("opposed", approach, axis),
            rows_of("coincident", FrameFeature(0, "point", axis.origin), across),
        ]
    )
    angle = rows_of("azimuth", closing, axis)

    def along(row: Rows, found: Array) -> Array:
        return np.array([values(row, q, tree)[0] for q in found])

    def before(found: Array) -> Array:
        depth = along(forward, found)
        return found[(depth >= AHEAD[0]) & (depth <= AHEAD[1]) & (np.abs(along(sideways, found)) <= ASIDE)]

    return (
        Histogram(
            "An object put down on a table",
            "place across the table [m]",
            ASIDE,
            along(sideways, before(printed(tree, moving, over))),
            along(sideways, before(drawn(tree, moving, over))),
            along(sideways, drawn(tree, moving, stacked([over, forward, sideways]))),
        ),
        Histogram(
            "A cylinder grasped at its rim",
            "angle of the grasp [rad]",
            float(np.pi),
            along(angle, printed(tree, moving, rim)),
            along(angle, drawn(tree, moving, rim)),
            along(angle, drawn(tree, moving, rim, angle)),
        ),
    )


def _plane(base: Array, axis: int) -> FrameFeature:
    x, y, z = (float(v) for v in base)
    normal = (1.0, 0.0, 0.0) if axis == 0 else (0.0, 1.0, 0.0)
    return FrameFeature(0, "plane", (x, y, z), normal)


def _across(tool: Frame, tip: FrameFeature) -> FrameFeature:
    """The plane in which the fingers close: its normal is the tool's x."""
    turned = tool.moved(Feature("plane", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    return FrameFeature(tip.joint, "plane", tip.origin, turned.direction)


def draw(picture: Path) -> list[str]:
    """Draws both constraints, plain above and even below; returns a line of figures for each."""
    description = kabo.load_problem(PROBLEM).scene
    assert description is not None
    robot = kabo.load_scene(description).robots[ARM]
    figure, axes = plt.subplots(3, 2, figsize=(10, 7), sharex="col", sharey=True)
    lines = []
    for column, shown in enumerate(histograms(robot)):
        for row, (found, colour, how) in enumerate(
            (
                (shown.printed, "#c9593f", "Algorithm 3 as printed"),
                (shown.plain, "#9aa3ad", "random seeds"),
                (shown.even, "#3f7fbf", "aimed at"),
            )
        ):
            fullness, plot = shown.fullness(found), axes[row][column]
            edges = np.linspace(-shown.end, shown.end, BINS + 1)
            plot.bar(
                edges[:-1], fullness, np.diff(edges), align="edge", color=colour, edgecolor="white", linewidth=0.4
            )
            plot.axhline(1.0, color="#4a5260", linewidth=0.7)
            said = f"max/mean {fullness.max():.2f}, min/mean {fullness.min():.2f}"
            plot.set_title(f"{shown.title}\n{how}: {said}" if row == 0 else f"{how}: {said}", fontsize=9)
            lines.append(f"{shown.title}, {how}: {said}; {len(found)} samples")
        axes[2][column].set_xlabel(shown.label)
    for plots in axes:
        plots[0].set_ylabel("samples / mean")
    figure.tight_layout()
    figure.savefig(picture, dpi=110, metadata={"Software": None})
    plt.close(figure)
    return lines


def main() -> None:
    """Draws the picture and prints its figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "pictures" / "sampling.png")
    for line in draw(parser.parse_args().output):
        print(line)


if __name__ == "__main__":
    main()
