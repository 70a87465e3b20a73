"""What a microphone on the body records: modes of strings that were let go, a resonance, noise, a knock at times."""

from collections.abc import Sequence

import numpy as np

from guzheng.finger import Release

RATE = 22050  # samples a second
DURATION = 0.9  # of a recording [s]
BEFORE = 0.15  # of a recording, before the path starts [s]
NOISE = 0.06  # of the microphone, standard deviation [N at the bridge]
KNOCKS = 0.01  # the share of recordings with a sound from elsewhere
MODES = 24
DAMPING, RISING = 1.6, 0.4  # of the first mode, and how much more by mode [1/s]
STIFFNESS = 2e-5  # of the wire: higher modes are a little too high
CUTOFF = 2500.0  # above which the body gives back less [Hz]
_BLOCK = 128


def recording(releases: Sequence[Release], rng: np.random.Generator, duration: float = DURATION) -> np.ndarray:
    """The sound (N,) of strings that slip off the tip, at RATE, with noise."""
    sound = noise(int(duration * RATE), rng)
    for release in releases:
        begin = int((BEFORE + release.time) * RATE)
        sound[begin:] += _ring(release, len(sound) - begin)
    if rng.random() < KNOCKS:
        begin = int(rng.uniform(0.1, 0.8) * len(sound))
        sound[begin:] += _knock(rng, len(sound) - begin)
    return sound


def noise(samples: int, rng: np.random.Generator) -> np.ndarray:
    """So many samples (N,) of a room in which nothing is played."""
    return rng.normal(0.0, NOISE, samples)


def _ring(release: Release, samples: int) -> np.ndarray:
    """The force of a released string on the bridge, as the body gives it back: (N,).

    A string that is pulled aside by F at the share x has modes whose force on the bridge is 2 F / pi sin(n pi x) / n.
    """
    f = release.string.frequency
    n = np.arange(1, min(MODES, int(0.45 * RATE / f)) + 1)
    frequencies = n * f * np.sqrt(1.0 + STIFFNESS * n**2)
    gain = 10.0 ** (release.string.resonance / 20.0) / (1.0 + (frequencies / CUTOFF) ** 2)
    strengths = 2.0 / np.pi * release.force * np.sin(n * np.pi * release.share) / n * gain
    return _modes(strengths, frequencies, DAMPING + RISING * (n - 1), samples)


def _knock(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Something falls, far from the strings: a few short modes."""
    frequencies = rng.uniform(100.0, 2000.0, 5)
    return _modes(rng.uniform(0.1, 0.6, 5), frequencies, rng.uniform(10.0, 40.0, 5), samples)


def _modes(strengths: np.ndarray, frequencies: np.ndarray, dampings: np.ndarray, samples: int) -> np.ndarray:
    """The sum (N,) of damped sines: sample q b + r of a mode is z^(q b) z^r, so that few powers are computed.

    The product is numpy's own: one by BLAS would depend on the number of its threads.
    """
    z = (2j * np.pi * frequencies - dampings) / RATE
    blocks = np.exp(np.outer(np.arange(-(-samples // _BLOCK)) * _BLOCK, z)) * strengths
    within = np.exp(np.outer(z, np.arange(_BLOCK)))
    return np.einsum("qn,nr->qr", blocks, within).imag.ravel()[:samples]
