"""Where a string runs, found out by touching it: the first stage of the chapter [T 4.3], on the simulated instrument.

python string_lines.py

A person shows the ends of a string. Then the robot plucks it here and there, where Halton's sequence says, takes the place
of its fingertip at each valid pluck for a point of the string, and fits a line. Prints how far new contacts are from it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from guzheng import DIRECTIONS, Guzheng, guzheng
from plucked_string import judged, play

from kabo.exploration import Line, fit_line, halton
from kabo.trials import Valid

NOISE = 0.0008  # of a contact, each axis, standard deviation [m]: arm, plectrum, the string's own deflection
OUTLIERS = 0.05  # the share of contacts that are none: a harmonic, a noise in the room
ASTRAY = 0.05  # how far off these are at most, each axis [m]
TRIES, DEFLECTION = 4, 0.003  # of a pluck, and with which deflection it begins [m]
RETRY = {"no_onset": 0.001, "not_felt": 0.001, "too_hard": -0.001}  # by how much the deflection changes [m]


@dataclass(frozen=True)
class Contact:
    """Where the fingertip was at a valid pluck [m]; `astray` only who simulates can know."""

    point: np.ndarray
    astray: bool


def ends(instrument: Guzheng, name: str) -> np.ndarray:
    """The true ends (2, 3) of what the robot reaches of a string: on its right, at eta 0, and on its left [m].

    The robot looks along x. Strings run to its left, fan out a little, and rise from their bridge.
    """
    names = list(instrument.strings)
    index, string = names.index(name), instrument.strings[name]
    away = 0.55 - sum(instrument.strings[each].spacing for each in names[:index])  # low strings are far away
    right = np.array([away, -0.3, 0.75 + 0.004 * index])
    along = np.array([0.02 * (index - 6) / 6, 1.0, 0.04])
    return np.stack([right, right + string.reach * string.length * along / np.linalg.norm(along)])


def contacts(
    instrument: Guzheng, name: str, rng: np.random.Generator, share: Callable[[int], float]
) -> Iterator[Contact]:
    """The contacts of valid plucks at the shares of the string that `share` gives for 0, 1 …; the first two are shown."""
    right, left = ends(instrument, name)
    for eta in (0.0, 1.0):
        yield Contact(_noisy(right + eta * (left - right), rng), False)
    index = 0
    while True:
        eta, direction = share(index), DIRECTIONS[rng.integers(2)]
        index += 1
        if _valid(instrument, name, direction, eta, rng):
            astray = bool(rng.random() < OUTLIERS)
            point = _noisy(right + eta * (left - right), rng)
            yield Contact(point + rng.uniform(-ASTRAY, ASTRAY, 3) if astray else point, astray)


def _noisy(point: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return point + rng.normal(0.0, NOISE, 3)


def _valid(instrument: Guzheng, name: str, direction: str, eta: float, rng: np.random.Generator) -> bool:
    """Whether one of a few plucks is valid; after each that is not the deflection changes by its reason [T 4.3.1]."""
    deflection = DEFLECTION
    for _ in range(TRIES):
        sensed = play(instrument, name, direction, eta, deflection, int(rng.integers(2**31)))
        found = judged(sensed, instrument.strings[name].note)
        if isinstance(found, Valid):
            return True
        deflection += RETRY.get(found.reason, 0.0)
    return False


def evenly(index: int) -> float:
    """Where to pluck next, as a share of the string: Halton's sequence leaves no cluster and no gap."""
    return float(halton(index)[0])


def off(line: Line, points: np.ndarray) -> float:
    """The mean distance of points (N, 3) from a line [m] [T Fig. 4.6]."""
    return float(line.distance(points).mean())


def main() -> None:
    """Finds five strings."""
    instrument = guzheng()
    for name in ("a3", "d4", "fs4", "b4", "fs5"):
        source = contacts(instrument, name, np.random.default_rng(instrument.strings[name].note), evenly)
        known = [next(source) for _ in range(52)]
        new = np.array([each.point for each in (next(source) for _ in range(40)) if not each.astray])
        errors = {n: 1e3 * off(fit_line([each.point for each in known[: n + 2]]), new) for n in (0, 5, 20, 50)}
        line = fit_line([each.point for each in known])
        away = 1e3 * float(np.linalg.norm(line.origin - ends(instrument, name)[0]))
        print(  # noqa: T201 - this is a script
            f"{name}: new contacts are {', '.join(f'{e:.2f} mm after {n}' for n, e in errors.items())} plucks from the "
            f"line; its frame begins {away:.1f} mm from the string's end, {line.inliers.sum()} of 52 are inliers"
        )


if __name__ == "__main__":
    main()
