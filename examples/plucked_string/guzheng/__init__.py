"""A simulated zither: strings, the finger that plucks them, their sound, and the two senses that judge a pluck [T 4.2].

It needs numpy only. What a robot would know of a pluck comes from the senses alone; what really happened is kept apart
(`Release`), so that the senses can be judged by it.
"""

from guzheng.finger import DIRECTIONS, Finger, Release, path, pluck
from guzheng.hearing import Ear, Onset
from guzheng.instrument import Bias, Guzheng, String, guzheng
from guzheng.sound import RATE, recording
from guzheng.touch import drops, sampled

__all__ = [
    "DIRECTIONS",
    "RATE",
    "Bias",
    "Ear",
    "Finger",
    "Guzheng",
    "Onset",
    "Release",
    "String",
    "drops",
    "guzheng",
    "path",
    "pluck",
    "recording",
    "sampled",
]
