"""The sense of touch: pull at the finger, a hundred times a second, and the sudden drops that tell a pluck [T 4.2.3]."""

import numpy as np

from guzheng.finger import STEP

PERIOD = 0.01  # between samples [s]
NOISE = 0.007  # of a sample, standard deviation [N]
DROP = 0.05  # what the pull has to lose within two samples [N]
APART = 0.1  # a second drop within this time is that of the string's swinging [s]


def sampled(pulls: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """What the finger feels (M,): the mean pull over each period, with noise [N]."""
    each = round(PERIOD / STEP)
    means = pulls[: len(pulls) // each * each].reshape(-1, each).mean(1)
    return means + rng.normal(0.0, NOISE, len(means))


def drops(felt: np.ndarray) -> list[float]:
    """The times of sudden drops of the pull [s], at least APART."""
    fall = felt[:-2] - felt[2:]
    found: list[float] = []
    for index in np.flatnonzero(fall > DROP):
        near = fall[max(0, index - 2) : index + 3]
        time = (index + 1.5) * PERIOD
        if fall[index] == near.max() and (not found or time - found[-1] >= APART):
            found.append(float(time))
    return found
