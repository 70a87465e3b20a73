"""Draws how an exploration grows its valid set: `python -m scripts.picture_exploration` (extras `pictures`, `explore`).

The example of docs/how-to/exploration.md, whose files are taken from the page itself, after 10, 30 and 90 trials.
"""

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from kabo.arrays import Array
from kabo.exploration import Exploration, Space, trial_seed
from kabo.trials import Valid

mpl.use("Agg")
from matplotlib import pyplot as plt

PAGE = Path(__file__).resolve().parent.parent / "docs" / "how-to" / "exploration.md"
COUNTS = (10, 30, 90)
SPACE = Space({"angle": (0.2, 1.4), "speed": (2.0, 12.0)})
START, RETRY = {"angle": 0.8, "speed": 4.0}, {"hits_fence": {"speed": 1.0}, "too_far": {"speed": -1.0}}
GRID = 120  # points of a map along each parameter


def function_of_page() -> Callable[..., Any]:
    """The trial function that the page shows."""
    (code,) = re.findall(r"```python\n(import math.*?)```", PAGE.read_text(), flags=re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code, str(PAGE), "exec"), names)  # noqa: S102 - our own page
    function: Callable[..., Any] = names["throw"]
    return function


def explored(function: Callable[..., Any], count: int) -> Exploration:
    """The exploration after `count` trials."""
    found = Exploration(SPACE, ["distance"], seed=0, start=START, retry=RETRY)
    for number in range(count):
        question = found.ask()
        answer = function({}, question.parameters, trial_seed(0, {}, number))
        if isinstance(answer, Valid):
            found.tell({}, question.parameters, True, answer.outcomes)
        else:
            found.tell({}, question.parameters, False, reason=answer.reason)
    return found


def maps(function: Callable[..., Any], exploration: Exploration) -> tuple[Array, Array, Array, Array]:
    """Angles and speeds of the grid, V there, and the share of valid trials in truth; (GRID, GRID) each."""
    angles, speeds = np.meshgrid(np.linspace(0.2, 1.4, GRID), np.linspace(2.0, 12.0, GRID))
    points = [{"angle": a, "speed": s} for a, s in zip(angles.ravel(), speeds.ravel(), strict=True)]
    truth = [np.mean([isinstance(function({}, each, seed), Valid) for seed in range(20)]) for each in points]
    return angles, speeds, exploration.validity({}, points).reshape(angles.shape), np.reshape(truth, angles.shape)


def draw(axes: Any, function: Callable[..., Any], count: int) -> None:
    """One map: V shaded, its border, the truth, and the trials."""
    exploration = explored(function, count)
    angles, speeds, validity, truth = maps(function, exploration)
    axes.contourf(angles, speeds, validity, np.linspace(0, 1, 11), cmap="Greens", alpha=0.7)
    axes.contour(angles, speeds, validity, [0.7], colors="darkgreen", linewidths=1.5)
    axes.contour(angles, speeds, truth, [0.5], colors="black", linestyles="dashed", linewidths=1.0)
    for valid, marker, colour in ((True, "o", "black"), (False, "x", "firebrick")):
        told = np.array([list(each.parameters.values()) for each in exploration.trials if each.valid is valid])
        axes.plot(told[:, 0], told[:, 1], marker, color=colour, markersize=4, linestyle="none")
    share = np.mean([not each.valid for each in exploration.trials])
    axes.set_title(f"{count} trials, {share:.0%} invalid", fontsize=10)
    axes.set_xticks([0.4, 0.8, 1.2])
    axes.set_xlabel("angle [rad]")


def main() -> None:
    """Writes the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=PAGE.with_suffix(".png"), help="the picture file")
    function = function_of_page()
    figure, axes = plt.subplots(1, len(COUNTS), figsize=(10, 3.4), sharey=True)
    for each, count in zip(axes, COUNTS, strict=True):
        draw(each, function, count)
    axes[0].set_ylabel("speed [m/s]")
    figure.tight_layout()
    figure.savefig(parser.parse_args().output, dpi=110)


if __name__ == "__main__":
    main()
