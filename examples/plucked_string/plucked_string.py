"""A string instrument whose loudness a robot finds out by plucking [T ch. 4]: registers the trial `plucked_string/Pluck`.

kabo explore run exploration.yaml --stages plucked_string.py --trials 300 -o plucks.jsonl

The instrument is simulated (`guzheng/`); whether a pluck is valid comes out of what the robot feels and hears of it,
as it would on a real one: exactly one drop of the pull, and with it the onset of the right note and no other.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from kabo.trials import Invalid, Valid, register

sys.path.append(str(Path(__file__).resolve().parent))  # where the package `guzheng` is

from guzheng import Ear, Finger, Guzheng, Onset, Release, drops, guzheng, pluck, recording, sampled
from guzheng.sound import BEFORE

HARD = 1.8  # the pull above which string or plectrum would suffer [N]
ALIGNED = 0.05  # between a drop of the pull and the onset that it causes [s]
SKEW = 0.008  # between the clocks of finger and microphone, standard deviation [s]


@dataclass(frozen=True)
class Sensed:
    """One pluck: what the robot felt and heard, and, to judge its senses by, what happened."""

    strongest: float  # pull [N]
    drops: Sequence[float]  # [s]
    onsets: Sequence[Onset]
    happened: Sequence[Release]


@lru_cache(maxsize=1)
def ear() -> Ear:
    """The robot's ears, which have listened to the empty room."""
    return Ear()


def play(instrument: Guzheng, string: str, direction: str, eta: float, deflection: float, seed: int) -> Sensed:
    """Plucks a string once and gives what was sensed; times count from the start of the path [s]."""
    rng = np.random.default_rng(seed)
    releases, pulls = pluck(instrument, Finger(), string, direction, eta, deflection, rng)
    felt = sampled(pulls, rng)
    late = BEFORE + rng.normal(0.0, SKEW)
    onsets = [
        Onset(onset.time - late, onset.notes, onset.loudness) for onset in ear().onsets(recording(releases, rng))
    ]
    return Sensed(float(felt.max()), drops(felt), onsets, releases)


def judged(sensed: Sensed, note: int) -> Valid | Invalid:
    """Whether a pluck was a valid one of a note, and how loud; else what was wrong [T 4.2.3]."""
    if sensed.strongest > HARD:
        return Invalid("too_hard", f"pulled with {sensed.strongest:.1f} N")
    if not sensed.onsets:
        return Invalid("no_onset")
    if len(sensed.onsets) > 1:
        return Invalid("several_onsets")
    if len(sensed.drops) > 1:
        return Invalid("felt_twice")
    onset = sensed.onsets[0]
    if not sensed.drops or abs(onset.time - sensed.drops[0]) > ALIGNED:
        return Invalid("not_felt", "the sound came from elsewhere")
    if onset.notes != (note,):
        return Invalid("other_note", f"heard {', '.join(map(str, onset.notes))} where {note} was meant")
    return Valid({"loudness": onset.loudness})


def pluck_string(case: Mapping[str, str], parameters: Mapping[str, float], seed: int) -> Valid | Invalid:
    """Plucks a string of the instrument in a direction, at a share of its reach, with a deflection [m]."""
    instrument = guzheng()
    sensed = play(instrument, case["string"], case["direction"], parameters["eta"], parameters["deflection"], seed)
    return judged(sensed, instrument.strings[case["string"]].note)


register(pluck_string, "plucked_string/Pluck")
