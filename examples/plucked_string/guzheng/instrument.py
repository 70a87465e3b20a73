"""The strings of a guzheng and what the robot does not know of them: stiffness, place, resonance, errors of the arm."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

#: The thirteen upper strings, D major pentatonic, as numbers of MIDI notes; a4 is 69.
NOTES = {
    "a3": 57,
    "b3": 59,
    "d4": 62,
    "e4": 64,
    "fs4": 66,
    "a4": 69,
    "b4": 71,
    "d5": 74,
    "e5": 76,
    "fs5": 78,
    "a5": 81,
    "b5": 83,
    "d6": 86,
}
SPACING = 0.015  # between neighbouring strings [m]


@dataclass(frozen=True)
class String:
    """One string: shares of its length count from the bridge."""

    name: str
    note: int
    length: float  # [m]
    tension: float  # [N]
    first: float  # share of the length at eta = 0
    reach: float  # share of the length from eta = 0 to eta = 1
    spacing: float  # to the next higher string [m]
    height: float  # above the next lower string [m]: the body is curved
    resonance: float  # of the body at this note [dB]

    @property
    def frequency(self) -> float:
        """The fundamental [Hz]."""
        return float(440.0 * 2.0 ** ((self.note - 69) / 12))

    def share(self, eta: float) -> float:
        """Where on the string eta is, as a share of its length."""
        return self.first + eta * self.reach

    def stiffness(self, eta: float) -> float:
        """The force for a deflection at eta [N/m]: T / (L x (1 - x)) of an ideal string."""
        x = self.share(eta)
        return self.tension / (self.length * x * (1.0 - x))


@dataclass(frozen=True)
class Bias:
    """The error of the arm over a string in one direction, the same for each pluck: polynomials in 2 eta - 1 [m]."""

    across: tuple[float, ...]
    up: tuple[float, ...]

    def at(self, eta: float) -> tuple[float, float]:
        """How far the string lies from where the arm takes it to be: across, along the pluck, and up [m]."""
        s = 2.0 * eta - 1.0
        return sum(c * s**i for i, c in enumerate(self.across)), sum(c * s**i for i, c in enumerate(self.up))


@dataclass(frozen=True)
class Guzheng:
    """An instrument in front of a robot: strings from low to high, and the errors of the arm over each."""

    strings: Mapping[str, String]
    biases: Mapping[tuple[str, str], Bias]

    def neighbour(self, name: str, direction: str) -> tuple[String, float, float] | None:
        """The string behind `name` as the tip moves, how far it is and how much higher [m]; None at the rim.

        `in` goes to the player and thus to higher notes.
        """
        names = list(self.strings)
        index = names.index(name) + (1 if direction == "in" else -1)
        if not 0 <= index < len(names):
            return None
        behind, this = self.strings[names[index]], self.strings[name]
        if direction == "in":
            return behind, this.spacing, behind.height
        return behind, behind.spacing, -this.height


@lru_cache(maxsize=8)
def guzheng(seed: int = 0) -> Guzheng:
    """One of many instruments: tension, bridges and errors of the arm differ with the seed."""
    rng = np.random.default_rng(seed)
    strings = {}
    for name, note in NOTES.items():
        octaves = (note - 57) / 29  # 0 at the lowest string, 1 at the highest
        strings[name] = String(
            name,
            note,
            length=0.9 * (0.4 / 0.9) ** octaves * rng.uniform(0.95, 1.05),
            tension=80.0 * rng.uniform(0.85, 1.15),
            first=rng.uniform(0.06, 0.09),
            reach=rng.uniform(0.45, 0.55),
            spacing=SPACING * rng.uniform(0.95, 1.05),
            height=rng.normal(0.0, 0.001),
            resonance=rng.normal(0.0, 3.0),
        )
    biases = {
        (name, direction): Bias(
            across=tuple(rng.normal(0.0, (0.8e-3, 0.5e-3))), up=tuple(rng.normal(0.0, (0.5e-3, 0.4e-3, 0.4e-3)))
        )
        for name in strings
        for direction in ("in", "out")
    }
    return Guzheng(strings, biases)
