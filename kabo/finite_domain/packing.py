"""States packed into few machine words: the bits that hold each variable."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

WORD_BITS = 63  # of 64 are used: all 64 set mark a free place of a hash table, and are no state of one word


@dataclass(frozen=True)
class Packing:
    """Variable v takes `bits[v]` bits of word `word[v]` from `shift[v]` on. As a Python int, word w begins at bit 64 w."""

    words: int
    word: tuple[int, ...]
    shift: tuple[int, ...]
    bits: tuple[int, ...]
    mask: tuple[int, ...]  # the bits of the value, not shifted
    place: tuple[int, ...]  # 64 word + shift

    def number(self, values: Sequence[int]) -> int:
        """The packed state in which the variables have these values, as one Python int."""
        return sum(x << p for x, p in zip(values, self.place, strict=True))

    def values(self, number: int) -> tuple[int, ...]:
        """The values of all variables in a packed state, which is given as one Python int."""
        return tuple((number >> p) & m for p, m in zip(self.place, self.mask, strict=True))

    def array(self, number: int) -> NDArray[np.uint64]:
        """(words,) a packed state, which is given as one Python int, as an array for kernels."""
        words: NDArray[np.uint64] = np.frombuffer(number.to_bytes(8 * self.words, "little"), np.uint64).copy()
        return words

    def number_of(self, words: NDArray[np.uint64]) -> int:
        """The packed state in a kernel's array, as one Python int."""
        return int.from_bytes(words.tobytes(), "little")


def pack(sizes: Sequence[int]) -> Packing:
    """The packing of variables of these sizes: large ones first, each into the first word with enough space."""
    bits = [max(1, (n - 1).bit_length()) for n in sizes]
    used: list[int] = [0]
    word, shift = [0] * len(bits), [0] * len(bits)
    for v in sorted(range(len(bits)), key=lambda v: -bits[v]):
        w = next((w for w, taken in enumerate(used) if taken + bits[v] <= WORD_BITS), len(used))
        if w == len(used):
            used.append(0)
        word[v], shift[v] = w, used[w]
        used[w] += bits[v]
    return Packing(
        len(used),
        tuple(word),
        tuple(shift),
        tuple(bits),
        tuple((1 << b) - 1 for b in bits),
        tuple(64 * w + s for w, s in zip(word, shift, strict=True)),
    )
