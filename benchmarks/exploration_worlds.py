"""What is found in worlds whose truth is known, by questions, by the same trials in random order, and by uniform ones."""

import argparse
from collections.abc import Callable, Sequence

import numpy as np
from table import Table

from kabo.exploration import Exploration, NoParametersError, Space, Trial, Validity

Points = np.ndarray  # (n, d) in the unit cube
TRIALS, LEVEL, JUDGED, NOISE = 120, 0.75, 12_000, 0.3
SCALES = {2: 0.12, 3: 0.2, 4: 0.2}


def disc(points: Points) -> np.ndarray:
    """A ball in the middle."""
    return np.linalg.norm(points - 0.5, axis=1) < 0.25 + 0.06 * (points.shape[1] - 2)


def banana(points: Points) -> np.ndarray:
    """A bent strip."""
    bent = np.abs(points[:, 1] - 0.38 - 1.8 * (points[:, 0] - 0.5) ** 2) < 0.13
    return bent & (np.abs(points - 0.5)[:, [0, *range(2, points.shape[1])]].max(axis=1) < 0.4)


def lobes(points: Points) -> np.ndarray:
    """Two balls with a bridge."""
    apart = np.abs(points - 0.5)
    off = np.sqrt((apart[:, 0] - 0.2) ** 2 + (apart[:, 1:] ** 2).sum(axis=1))
    return (off < 0.12 + 0.06 * (points.shape[1] - 2)) | ((apart[:, 0] < 0.2) & (apart[:, 1:].max(axis=1) < 0.08))


def ridge(points: Points) -> np.ndarray:
    """A thin strip across."""
    return np.abs(points[:, 0] + points[:, 1] - 1.0) < 0.13


WORLDS: dict[str, Callable[[Points], np.ndarray]] = {
    "disc": disc,
    "banana": banana,
    "lobes": lobes,
    "ridge": ridge,
}


def outcome(points: Points) -> np.ndarray:
    """A smooth outcome, (n,)."""
    found: np.ndarray = 10 * np.sin(2.5 * points[:, 0]) + 6 * points[:, 1] * points[:, -1]
    return found


def explore(
    world: str, dimensions: int, seed: int, budget: float | None, uniform: bool, trials: int
) -> Exploration:
    """An exploration after so many trials; it begins in the middle."""
    space = Space({f"p{k}": (0.0, 1.0) for k in range(dimensions)})
    validity = Validity(scale=SCALES[dimensions])
    start = dict.fromkeys(space.names, 0.5)
    if world == "lobes":
        start["p0"] = 0.3
    found = Exploration(space, ["o"], seed=seed, validity=validity, invalid_budget=budget, start=start)
    rng = np.random.default_rng([seed, dimensions])
    for number in range(trials):
        try:
            at = space.named(rng.random(dimensions)) if uniform and number else found.ask().parameters
        except NoParametersError:
            break
        point = np.array([list(at.values())])
        valid = bool(WORLDS[world](point)[0])
        found.tell({}, at, valid, {"o": float(outcome(point)[0] + NOISE * rng.normal())} if valid else None)
    return found


def judged(found: Exploration, trials: Sequence[Trial], world: str) -> dict[str, float]:
    """Overlap of Φ^0.75 with the true set, and mean error of D in that, after such trials."""
    again = Exploration(found.space, found.outcomes, seed=found.seed, validity=found.validity_options)
    for each in trials:
        again.tell(each.case, each.parameters, each.valid, each.outcomes, each.reason)
    points = np.random.default_rng(0).random((JUDGED, len(found.space.names)))
    true, named = WORLDS[world](points), [found.space.named(row) for row in points]
    believed = again.validity({}, named) > LEVEL
    inside = [point for point, is_true in zip(named, true, strict=True) if is_true]
    if not any(each.valid for each in trials):
        return {"overlap": 0.0, "error": float("nan")}
    error = np.abs(again.predict({}, inside)["o"][0] - outcome(points[true])).mean()
    return {"overlap": float((believed & true).sum() / (believed | true).sum()), "error": float(error)}


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each number of parameters and way of choosing trials: means over worlds and seeds."""
    shown = Table(
        f"Means over worlds: overlap with the true set, error of the outcome (noise {NOISE}), invalid trials"
    )
    ways = [("questions", None, False), ("uniform", None, True)]
    ways += [
        (f"questions, budget {budget}", budget, False) for budget in ((0.1,) if options.small else (0.1, 0.2, 0.3))
    ]
    after = (10, 20) if options.small else (20, 40, 70, TRIALS)
    seeds = range(1 if options.small else options.seeds)
    for dimensions in (2,) if options.small else SCALES:
        for name, budget, uniform in ways:
            runs = [(world, seed) for world in WORLDS for seed in seeds]
            explored = [
                (world, explore(world, dimensions, seed, budget, uniform, after[-1])) for world, seed in runs
            ]
            _add(shown, f"{dimensions} parameters, {name}", explored, after, shuffled=False)
            if name == "questions":
                _add(shown, f"{dimensions} parameters, the same in random order", explored, after, shuffled=True)
    return [shown]


def _add(
    shown: Table, name: str, explored: list[tuple[str, Exploration]], after: Sequence[int], shuffled: bool
) -> None:
    figures: dict[str, float] = {}
    for count in after:
        seen = []
        for world, found in explored:
            trials = found.trials
            if shuffled:
                order = np.random.default_rng(found.seed).permutation(len(trials))
                trials = tuple(trials[index] for index in order)
            seen.append(judged(found, trials[:count], world))
        figures |= {
            f"{key} {count}": float(np.nanmean([each[key] for each in seen])) for key in ("overlap", "error")
        }
    invalid = [np.mean([not each.valid for each in found.trials]) for _, found in explored]
    shown.add(name, **figures, invalid=float(np.mean(invalid)))
