"""Draws the strings of examples/plucked_string as [T Fig. 4.3-4.8] do: `python -m scripts.exploration_figures`.

Five pictures beside the example: paths across a string, what is explored of one string, the error of lines, the growth
of what is known, and the loudness asked for and heard. Needs matplotlib, which comes with the extra `pictures`, and about
three minutes. Prints what each picture shows in figures.
"""

import argparse
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import matplotlib as mpl
import numpy as np

from kabo.arrays import Array
from kabo.exploration import Exploration, fit_line

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples" / "plucked_string"))
sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))

from exploration_plucks import STRINGS, cases, deflection, exploration, explore, truth
from exploration_string import Curve, Played, curve, played
from guzheng import guzheng, path
from guzheng.finger import DEPTH, END, START
from guzheng.instrument import SPACING
from string_lines import contacts, evenly, off

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "plucked_string"
STRING, DIRECTION, TRIALS = "fs4", "in", 120  # of the picture of one string
REASONS = {"no_onset": "#7a6fc0", "not_felt": "#b05fa0", "too_hard": "#c9593f", "other_note": "#c2a23a"}
OTHER, BLUE, ORANGE, GREY = "#4a5260", "#3f7fbf", "#f29f3d", "#9aa3ad"


def draw_paths(figure_of: Callable[..., tuple[plt.Figure, Axes]]) -> tuple[plt.Figure, str]:
    """The plane across a string, with the paths of four deflections [T Fig. 4.3]."""
    figure, axes = figure_of(1, 1, (7.2, 4.2))
    for aside, colour in zip((-0.004, 0.001, 0.006, 0.011), ("#b8c9dd", "#8aa9cc", BLUE, "#1f4f86"), strict=True):
        way = 1e3 * path(aside)
        axes.plot(*way.T, color=colour, linewidth=1.8, label=f"{1e3 * aside:+.0f} mm")
        axes.plot(1e3 * aside, 1e3 * DEPTH, "o", color=colour, markersize=6)
    for y, name in ((0.0, "string"), (1e3 * SPACING, "its neighbour"), (-1e3 * SPACING, "")):
        axes.plot(y, 0.0, "o", color=ORANGE, markersize=11, markeredgecolor=OTHER)
        axes.annotate(name, (y, 0.0), (y, 1.3 if y == 0.0 else -2.2), ha="center", fontsize=9)
    axes.annotate("start", 1e3 * np.array(START), (-8.0, 4.8), ha="center", fontsize=9)
    axes.annotate("end", 1e3 * np.array(END), (25.3, 11.4), fontsize=9)
    axes.annotate("waypoint δ", (11.0, 1e3 * DEPTH), (12.2, 1e3 * DEPTH - 0.4), fontsize=9)
    axes.set(xlabel="across the string, along the pluck [mm]", ylabel="up [mm]", xlim=(-17, 29), ylim=(-8, 14))
    axes.set_aspect("equal")
    axes.legend(title="deflection δ_y", frameon=False, fontsize=8, title_fontsize=9, loc="upper left")
    axes.set_title("Paths of the fingertip: as commanded, before the string holds it back", fontsize=10)
    return figure, f"paths: {len(path(0.0))} steps"


def draw_explored(figure_of: Callable[..., tuple[plt.Figure, Axes]]) -> tuple[plt.Figure, str]:
    """V and D of one string with the sets of 0.5 and 0.95, beside its trials [T Fig. 4.4, 4.5]."""
    known, case = exploration(STRING, 0), {"string": STRING, "direction": DIRECTION}
    explore(known, case, TRIALS)
    figure, (left, middle, right) = figure_of(1, 3, (13.2, 4.4))
    sides, grid = _grid(90)
    validity = known.validity(case, grid).reshape(90, 90)
    loudness = known.predict(case, grid)["loudness"][0].reshape(90, 90)
    shown = left.pcolormesh(*sides, validity, cmap="Greys_r", vmin=0, vmax=1, shading="gouraud")
    figure.colorbar(shown, ax=left, label="V, probability of being valid")
    left.set_title("Where plucks are believed valid", fontsize=10)
    shown = middle.pcolormesh(
        *sides, np.ma.masked_where(validity <= 0.5, loudness), cmap="viridis", shading="nearest"
    )
    figure.colorbar(shown, ax=middle, label="D, expected loudness [dB]")
    middle.set_title("How loud they are expected to be there", fontsize=10)
    valid = _scatter(right, known)
    figure.colorbar(valid, ax=right, label="loudness heard [dB]")
    right.set_title(f"The {TRIALS} trials: dots are valid, crosses are not", fontsize=10)
    true = truth(STRING, DIRECTION, 24, 5)
    border = np.asarray(true.share).reshape(24, 24).T
    places = (np.arange(24) + 0.5) / 24
    for axes in (left, middle, right):
        axes.contour(*sides, validity, levels=[0.5, 0.95], colors=[ORANGE, "#d6322d"], linewidths=[1.4, 1.8])
        axes.set(
            xlabel="η, place along the string", xlim=(0, 1), ylim=(1e3 * deflection(0.0), 1e3 * deflection(1.0))
        )
    left.contour(
        places, 1e3 * np.array([deflection(y) for y in places]), border, [0.5], colors=[BLUE], linestyles="--"
    )
    for colour, style, label in (
        (ORANGE, "-", "V = 0.5"),
        ("#d6322d", "-", "V = 0.95"),
        (BLUE, "--", "true border"),
    ):
        left.plot([], [], style, color=colour, label=label)
    left.legend(fontsize=8, frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    left.set_ylabel("deflection δ_y [mm]")
    invalid = np.mean([not trial.valid for trial in known.trials])
    return figure, f"{STRING} {DIRECTION}: {TRIALS} trials, {invalid:.0%} invalid"


def _grid(side: int) -> tuple[tuple[Array, Array], list[dict[str, float]]]:
    """The sides of a grid, the second in millimetres, and its points row by row."""
    eta, aside = np.linspace(0, 1, side), np.linspace(deflection(0.0), deflection(1.0), side)
    points = [{"eta": float(x), "deflection": float(y)} for y in aside for x in eta]
    return (eta, 1e3 * aside), points


def _scatter(axes: Axes, known: Exploration) -> mpl.collections.PathCollection:
    """Draws the trials: valid ones by loudness, invalid ones by reason."""
    for reason in dict.fromkeys([*REASONS, *(trial.reason for trial in known.trials if not trial.valid)]):
        at = [trial.parameters for trial in known.trials if not trial.valid and trial.reason == reason]
        if at:
            label = f"{reason} ({len(at)})"
            axes.plot(
                [p["eta"] for p in at],
                [1e3 * p["deflection"] for p in at],
                "x",
                color=REASONS.get(reason, OTHER),
                markersize=5,
                label=label,
            )
    valid = [trial for trial in known.trials if trial.valid]
    axes.legend(fontsize=8, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    return axes.scatter(
        [trial.parameters["eta"] for trial in valid],
        [1e3 * trial.parameters["deflection"] for trial in valid],
        c=[trial.outcomes["loudness"] for trial in valid],
        cmap="viridis",
        s=14,
    )


def draw_lines(figure_of: Callable[..., tuple[plt.Figure, Axes]]) -> tuple[plt.Figure, str]:
    """The distance of new contacts from a string's line as plucks come [T Fig. 4.6]."""
    figure, axes = figure_of(1, 1, (7.2, 4.0))
    after, colours = np.arange(0, 61, 2), plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(STRINGS)))
    last = []
    for string, colour in zip(STRINGS, colours, strict=True):
        for episode in range(5):
            rng = np.random.default_rng([episode, guzheng().strings[string].note])
            known = list(islice(contacts(guzheng(), string, rng, evenly), 2 + 60 + 60))
            errors = []
            for plucks in after:
                ahead = [each.point for each in known[2 + plucks :] if not each.astray][:30]
                errors.append(1e3 * off(fit_line([each.point for each in known[: 2 + plucks]]), np.array(ahead)))
            axes.plot(
                after, errors, color=colour, linewidth=0.9, alpha=0.8, label=string if episode == 0 else None
            )
            last.append(errors[10])
    axes.axhline(1.0, color=OTHER, linestyle=":", label="expected of 0.8 mm noise")
    axes.set(
        xlabel="plucks after the two ends were shown",
        ylabel="distance of the next 30 contacts [mm]",
        ylim=(0, 2.6),
    )
    axes.legend(frameon=False, fontsize=8, ncols=2)
    axes.set_title("How far new contacts are from the line: five episodes of five strings", fontsize=10)
    return figure, f"lines after 20 plucks: mean {np.mean(last):.2f} mm, largest {max(last):.2f} mm"


def draw_growth(figure_of: Callable[..., tuple[plt.Figure, Axes]]) -> tuple[plt.Figure, str]:
    """The overlap of the valid set with its final one and the error of D, also in random order [T Fig. 4.7]."""
    active, mixed = [], []
    after = [*range(1, 10), *range(10, 121, 5)]
    for string in STRINGS:
        known = exploration(string, 0)
        for number, case in enumerate(cases([string])):
            explore(known, case, 120)
            made, true = known.trials_of(case), truth(string, case["direction"], 12, 2)
            order = np.random.default_rng([0, number]).permutation(len(made))
            active.append(curve(case, made, true, exploration(string, 0), after, 1000))
            mixed.append(curve(case, [made[i] for i in order], true, exploration(string, 0), after, 1000))
    figure, (left, right) = figure_of(1, 2, (10.4, 4.0))
    for curves, colour, label in ((active, BLUE, "explored"), (mixed, ORANGE, "the same trials in random order")):
        _band(left, curves, "final", colour, label)
        _band(right, curves, "error", colour, label)
    left.axhline(0.5, color=GREY, linestyle=":")
    right.axhline(3.0, color=GREY, linestyle=":")
    left.set(xlabel="trials", ylabel="IoU of the valid set with its final one", ylim=(0, 1))
    right.set(xlabel="trials", ylabel="mean error of the expected loudness [dB]", ylim=(0, 10))
    left.legend(frameon=False, fontsize=8, loc="lower right")
    figure.suptitle("Five strings in both directions: mean, and from the least to the most", fontsize=10)
    half = max(each.first_above(0.5) or 0.0 for each in active)
    return figure, f"growth: half of the final set after {half:.0f} trials at most"


def _band(axes: Axes, curves: list[Curve], figure: str, colour: str, label: str) -> None:
    values = np.array([getattr(each, figure) for each in curves])
    axes.fill_between(
        curves[0].after, np.nanmin(values, 0), np.nanmax(values, 0), color=colour, alpha=0.15, linewidth=0
    )
    axes.plot(curves[0].after, np.nanmean(values, 0), color=colour, label=label)


def draw_loudness(figure_of: Callable[..., tuple[plt.Figure, Axes]]) -> tuple[plt.Figure, str]:
    """Loudness of all strings, and what was heard where a loudness was asked for [T Fig. 4.8]."""
    found: dict[str, tuple[list[float], Played]] = {}
    for string in guzheng().strings:
        known = exploration(string, 0)
        for case in cases([string]):
            explore(known, case, 80)
        found[string] = [t.outcomes["loudness"] for t in known.trials if t.valid], played(known, string)
    figure, (left, right) = figure_of(1, 2, (11.6, 4.4))
    for body in left.violinplot([loud for loud, _ in found.values()], widths=0.85, showextrema=True)["bodies"]:
        body.set_facecolor(BLUE)
        body.set_alpha(0.45)
    left.set_xticks(range(1, len(found) + 1), list(found))
    left.set(xlabel="string", ylabel="loudness of valid plucks [dB above noise, A]")
    left.set_title("What was explored: 160 plucks of each string", fontsize=10)
    share = np.array([(p.target - p.low) / (p.high - p.low) for _, p in found.values()])
    off_by = np.array([p.heard - p.target for _, p in found.values()])
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(found)))
    for own, errors, colour in zip(share, off_by, colours, strict=True):
        right.plot(100 * own + np.linspace(-1, 1, len(own)), errors, ".", color=colour, markersize=3, alpha=0.5)
    levels = np.unique(np.round(share[0], 6))
    means = [np.nanmean(off_by[np.isclose(share, level, atol=1e-6)]) for level in levels]
    right.plot(100 * levels, means, color=OTHER, linewidth=1.6, label="mean of all strings")
    right.axhspan(-3, 3, color=GREY, alpha=0.25, linewidth=0, label="within 3 dB")
    right.set(
        xlabel="loudness asked for [% of the string's range]", ylabel="heard − asked for [dB]", ylim=(-12, 20)
    )
    right.legend(frameon=False, fontsize=8)
    right.set_title("20 loudnesses of each string, five plucks each", fontsize=10)
    near = np.mean([p.near() for _, p in found.values()])
    ranges = [p.high - p.low for _, p in found.values()]
    return figure, f"loudness: ranges {min(ranges):.0f} to {max(ranges):.0f} dB, {near:.0%} within 3 dB"


PICTURES = {
    "paths": draw_paths,
    "explored": draw_explored,
    "lines": draw_lines,
    "growth": draw_growth,
    "loudness": draw_loudness,
}


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[plt.Figure, Axes]:
    return plt.subplots(rows, columns, figsize=size, layout="constrained")


def main() -> None:
    """Draws the pictures that the command line names; all of them without a name."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", metavar="PICTURE", help=f"of {', '.join(PICTURES)}")
    parser.add_argument("--output", type=Path, default=EXAMPLE, metavar="FOLDER")
    options = parser.parse_args()
    unknown = set(options.pictures) - set(PICTURES)
    if unknown:
        parser.error(f"no picture {', '.join(sorted(unknown))}; there are {', '.join(PICTURES)}")
    for name in options.pictures or PICTURES:
        figure, told = PICTURES[name](_figure)
        figure.savefig(options.output / f"{name}.png", dpi=90, metadata={"Software": None})
        plt.close(figure)
        print(told)


if __name__ == "__main__":
    main()
