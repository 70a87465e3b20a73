"""Draws what was explored of two bars: `python -m scripts.picture_lifting_a_bar` (extra `pictures`).

Above, three lifts of the steel bar as MuJoCo leaves them, seen from the side. Below, for each bar, the probability of
being valid in contours over all trials, valid ones coloured by the torque at the wrist, and where the model holds it.
Needs the extras `explore` and `simulation`, too.
"""

import argparse
import runpy
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from kabo.exploration import Exploration, load_exploration

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "lifting_a_bar"
LIFTS = (("level", 0.031, 20.0), ("hanging", -0.03, 20.0), ("dropped", 0.031, 4.0))  # title, along [m], force [N]
MARKS = {"dropped": "v", "hanging": "d", "crushed": "x"}
GRID, LEVELS, GREATEST = 60, (0.5, 0.7, 0.95), 0.4  # points a side; of V; torque of the strongest colour [Nm]
STEEL, DARK, PAD, RED = "#9aa3ad", "#4a5260", "#f29f3d", "#c0392b"


def main() -> None:
    """Writes the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=EXAMPLE / "explored.png")
    options = parser.parse_args()
    names, exploration = (
        runpy.run_path(str(EXAMPLE / "lifting_a_bar.py")),
        load_exploration(EXAMPLE / "model.jsonl"),
    )
    figure = plt.figure(figsize=(10, 6.6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 2.1))
    for axes, (title, along, force) in zip(above.subplots(1, len(LIFTS)), LIFTS, strict=True):
        _draw_lift(axes, names, title, along, force)
    cases = exploration.space.cases["bar"]
    panels = below.subplots(1, len(cases), sharey=True)
    for axes, bar in zip(panels, cases, strict=True):
        colours = _draw_map(axes, exploration, bar, names["BARS"][bar].balance)
    panels[-1].legend(loc="upper right", fontsize=8)
    panels[0].set_ylabel("force [N]")
    below.colorbar(colours, ax=panels, label="torque at the wrist [Nm]")
    figure.savefig(options.output, dpi=110)


def _draw_lift(axes: Axes, names: dict[str, Any], title: str, along: float, force: float) -> None:
    """The bar and a pad at the end of a lift, from the side."""
    found = names["simulate"](names["BARS"]["steel"], along, force)
    height, half = names["HEIGHT"], (names["LENGTH"] / 2, names["HEIGHT"] / 2)
    cosine, sine = np.cos(found.tilt), np.sin(found.tilt)
    turn, centre = np.array([[cosine, -sine], [sine, cosine]]), np.array(found.middle)
    corners = centre + np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half @ turn.T
    axes.add_patch(Polygon(corners, facecolor=STEEL, edgecolor=DARK))
    axes.plot(*(centre + turn @ (names["BARS"]["steel"].balance, 0.0)), "o", color=RED, markersize=5)
    hand, pad = height / 2 + names["LIFT"], names["PAD"]
    axes.add_patch(Rectangle((along - pad[0], hand - pad[1]), 2 * pad[0], 2 * pad[1], color=PAD, alpha=0.8))
    axes.add_patch(Rectangle((along - 0.03, hand + 0.06), 0.06, 0.03, color=DARK))
    axes.plot([along, along], [hand, hand + 0.06], color=DARK, linewidth=5)
    axes.axhline(0.0, color=DARK)
    axes.set(
        xlim=(-0.19, 0.19), ylim=(-0.01, 0.24), aspect="equal", title=f"{title}: {force:g} N", xticks=(), yticks=()
    )


def _draw_map(axes: Axes, exploration: Exploration, bar: str, balance: float) -> Any:
    """The trials of a bar over V in contours; returns what the colours of valid trials mean."""
    (left, right), (low, high) = exploration.space.parameters.values()
    along, force = np.meshgrid(np.linspace(left, right, GRID), np.linspace(low, high, GRID))
    points = [{"along": a, "force": f} for a, f in zip(along.ravel(), force.ravel(), strict=True)]
    validity = exploration.validity({"bar": bar}, points).reshape(along.shape)
    axes.contourf(along, force, validity, levels=np.linspace(0.0, 1.0, 21), cmap="Greens", alpha=0.5)
    axes.clabel(axes.contour(along, force, validity, levels=LEVELS, colors=DARK, linewidths=0.8), fmt="%g")
    trials = exploration.trials_of({"bar": bar})
    for reason, mark in MARKS.items():
        there = [each.parameters for each in trials if each.reason == reason]
        at = [[each[name] for each in there] for name in ("along", "force")]
        axes.scatter(*at, marker=mark, color=DARK, s=28, label=reason)
    valid = [each for each in trials if each.valid]
    at = [[each.parameters[name] for each in valid] for name in ("along", "force")]
    torques = [each.outcomes["torque"] for each in valid]
    colours = axes.scatter(*at, c=torques, cmap="coolwarm", vmin=-GREATEST, vmax=GREATEST, s=30, edgecolors=DARK)
    chosen = exploration.infer({"torque": 0.0}, where={"bar": bar}).parameters
    axes.axvline(balance, color=RED, linewidth=1.0, linestyle="--", label="balance")
    axes.plot(
        chosen["along"], chosen["force"], "*", color=PAD, markeredgecolor=DARK, markersize=16, label="held here"
    )
    axes.set(xlabel="along [m]", title=f"{bar}: {len(valid)} of {len(trials)} trials valid")
    return colours


if __name__ == "__main__":
    main()
