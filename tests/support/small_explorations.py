"""Small worlds whose truth is known, and explorations of them."""

import math
from collections.abc import Mapping

import numpy as np

from kabo.exploration import Exploration, Space, Validity

CASES = {"bar": ["steel", "wood"], "end": ["left", "right", "both"]}


def space(dimensions: int = 2, **options: object) -> Space:
    """Parameters a, b … with bounds of different size."""
    bounds = {
        "a": (0.0, 1.0),
        "b": (-0.08, 0.08),
        "c": (1.0, 40.0),
        "d": (-5.0, -1.0),
        "e": (0.0, 1e-3),
        "f": (9.0, 11.0),
    }
    return Space(dict(list(bounds.items())[:dimensions]), **options)


def share(space: Space, parameters: Mapping[str, float]) -> np.ndarray:
    """Parameters as shares of their bounds, (d,)."""
    return np.array([(parameters[name] - low) / (high - low) for name, (low, high) in space.parameters.items()])


def answer(
    space: Space, parameters: Mapping[str, float], radius: float = 0.35
) -> tuple[bool, dict[str, float], str]:
    """What comes of parameters: valid in a ball around the middle, with two outcomes; else `left` or `right` of it."""
    at = share(space, parameters)
    if float(np.linalg.norm(at - 0.5)) > radius:
        return False, {}, "left" if at[0] < 0.5 else "right"
    return (
        True,
        {
            "torque": 3.0 * at[0] + 0.5 * float(np.sin(5 * at[-1])),
            "noise": 40.0 - 9.0 * float(np.sin(20 * at[-1])),
        },
        "",
    )


def exploration(dimensions: int = 2, outcomes: tuple[str, ...] = ("torque",), **options: object) -> Exploration:
    """An exploration of such a space, without trials."""
    cases = options.pop("cases", {})
    return Exploration(space(dimensions, cases=cases), outcomes, **{"seed": 5, **options})


def tell(exploration: Exploration, parameters: Mapping[str, float], case: Mapping[str, str] | None = None) -> None:
    """Tries parameters in the world, and tells what came of it."""
    valid, outcomes, reason = answer(exploration.space, parameters)
    told = {name: outcomes[name] for name in exploration.outcomes} if valid else None
    exploration.tell(case, parameters, valid, told, reason)


def tell_random(
    exploration: Exploration, count: int, seed: int = 0, case: Mapping[str, str] | None = None, spread: float = 1.0
) -> None:
    """Tells `count` trials drawn around the middle of the space; the first is the middle, which is valid."""
    generator = np.random.default_rng(seed)
    for number in range(count):
        at = 0.5 + (generator.random(len(exploration.space.names)) - 0.5) * spread * (number > 0)
        pairs = zip(exploration.space.parameters.items(), at, strict=True)
        tell(exploration, {name: float(low + u * (high - low)) for (name, (low, high)), u in pairs}, case)


def run(exploration: Exploration, count: int, case: Mapping[str, str] | None = None) -> None:
    """Asks and tells, `count` times."""
    for _ in range(count):
        question = exploration.ask(case)
        tell(exploration, question.parameters, question.case)


def grid(space: Space, steps: int) -> list[dict[str, float]]:
    """All parameters on a grid."""
    axes = [np.linspace(low, high, steps) for low, high in space.parameters.values()]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    return [dict(zip(space.names, map(float, each), strict=True)) for each in points]


def caution(validity: Validity, budget: float, valid: list[bool]) -> float:
    """α after trials, written out from the formula: z begins at the greater of both quantiles, α = Φ(z), 0 ≤ z ≤ 4."""
    from statistics import NormalDist

    z = max(NormalDist().inv_cdf(max(validity.alpha, 1 - budget)), 0.0)
    for each in valid:
        z = z + 0.5 * ((0 if each else 1) - budget)
        z = 0.0 if z < 0.0 else 4.0 if z > 4.0 else z
    return 0.5 * (1 + math.erf(z / math.sqrt(2)))
