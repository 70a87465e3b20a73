"""Streams of random numbers without a state: any sample of any stream can be drawn, in any order and by any worker."""

import hashlib
import struct

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array

Key = np.uint64
Words = npt.NDArray[np.uint64]
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FLOAT = struct.Struct("<cqd")  # tag, length in bytes, number
_TO_UNIT = 1.0 / 9007199254740992.0  # 2^-53


def stream_key(*parts: str | int | float | bytes) -> Key:
    """The key of a stream of random numbers: a hash of `parts`, such as seed, procedure, arguments and attempt.

    The same parts give the same key on every machine; parts of different types never coincide.
    """
    whole: list[bytes] = []
    for part in parts:
        if isinstance(part, float):  # most parts are numbers
            whole.append(_FLOAT.pack(b"f", 8, part))
            continue
        if isinstance(part, bytes):
            tag, data = b"b", part
        elif isinstance(part, str):
            tag, data = b"s", part.encode()
        else:
            tag, data = b"i", str(int(part)).encode()
        whole += tag, struct.pack("<q", len(data)), data
    digest = hashlib.blake2b(b"".join(whole), digest_size=8).digest()
    key: Key = np.uint64(int.from_bytes(digest, "little"))
    return key


def uniforms(key: Key, first: int, count: int, dimensions: int) -> Array:
    """Samples from `first` on, (count, dimensions), uniform in [0, 1): the numbers that `kinematics.uniform` gives."""
    steps = np.arange(first + 1, first + count + 1, dtype=np.int64).astype(np.uint64)
    words = _mixed(np.uint64(key) + steps * _GOLDEN)
    axes = np.arange(1, dimensions + 1, dtype=np.uint64) * _GOLDEN
    numbers: Array = (_mixed(words[:, None] + axes) >> np.uint64(11)).astype(float) * _TO_UNIT
    return numbers


def _mixed(words: Words) -> Words:
    """The finaliser of splitmix64 [Steele, Lea, Flood 2014]: every bit of a word reaches every bit of it."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: Words = words ^ (words >> np.uint64(31))
    return mixed
