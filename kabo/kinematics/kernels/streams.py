"""Random numbers without a state: number `dimension` of sample `index` of stream `key`, in any order."""

import numpy as np

from kabo.compilation import lean_kernel


@lean_kernel  # u8 -> u8
def mixed(word):
    """The finaliser of splitmix64 [Steele, Lea, Flood 2014]: every bit of `word` reaches every bit of it."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


@lean_kernel  # u8, i8, i8 -> f8 in [0, 1)
def uniform(key, index, dimension):
    """A number that depends on its three arguments only, uniform in [0, 1), a multiple of 2^-53."""
    golden = np.uint64(0x9E3779B97F4A7C15)
    word = mixed(np.uint64(key) + (np.uint64(index) + np.uint64(1)) * golden)
    word = mixed(word + (np.uint64(dimension) + np.uint64(1)) * golden)
    return np.float64(word >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@lean_kernel  # i8, i8 -> f8
def step_of(dimension, dimensions):
    """By how much `stratified` moves along one of so many dimensions from one index to the next."""
    root = 1.5
    for _ in range(40):
        root = (1.0 + root) ** (1.0 / (dimensions + 1.0))
    return 1.0 / root ** (dimension + 1.0)


@lean_kernel  # u8, i8, i8, i8 -> f8 in [0, 1)
def stratified(key, index, dimension, dimensions):
    """A number in [0, 1) as from `uniform`, except that consecutive indices fill [0, 1)^dimensions evenly.

    An additive recurrence with the powers of the generalised golden ratio (the root of x^(d+1) = x + 1), which
    starts at a point that the key draws.
    """
    place = uniform(key, np.int64(-1), dimension) + index * step_of(dimension, dimensions)
    return place - np.floor(place)


@lean_kernel  # u8, i8, (N, n) f8, (n,) f8, (n,) f8 -> writes seeds
def draw(key, first, seeds, lower, upper):
    """Writes samples `first`, `first` + 1 … of the stream, uniform between the bounds."""
    for i in range(seeds.shape[0]):
        for k in range(seeds.shape[1]):
            seeds[i, k] = lower[k] + uniform(key, first + i, k) * (upper[k] - lower[k])
