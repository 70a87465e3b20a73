"""The worlds that the initial knowledge allows: every one of them, or a stated number drawn at random.

A world gives a value to every atom and term that matters. It must agree with Kf, with every entry of Kx and Kor, and
with the update rules: what they conclude when all of the world is known must be true in it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from kabo.verify.ground import Symbol, Value, claim_text
from kabo.verify.linked import Linked
from kabo.verify.streams import Stream


@dataclass(frozen=True)
class PossibleWorlds:
    """Worlds, each as the values of what was unknown; `exhaustive` if these are all."""

    worlds: tuple[Mapping[Symbol, Value], ...]
    exhaustive: bool


def possible_worlds(groups: Sequence[Linked], limit: int, samples: int, seed: int) -> PossibleWorlds:
    """All worlds if there are at most `limit`, else about `samples` different ones, drawn at random."""
    everything = all_worlds(groups, limit)
    if everything is not None:
        return PossibleWorlds(tuple(everything), True)
    found: dict[tuple[Value, ...], Mapping[Symbol, Value]] = {}
    for index in range(2 * samples):
        values = _sample(groups, Stream(seed, index))
        if values is not None:
            found.setdefault(tuple(values.values()), values)
        if len(found) == samples:
            break
    return PossibleWorlds(tuple(found.values()), False)


def all_worlds(groups: Sequence[Linked], limit: int) -> list[dict[Symbol, Value]] | None:
    """Every world; None if there are more than `limit`, or they are not found in time."""
    choices: list[list[dict[Symbol, Value]]] = []
    count = 1
    for group in groups:
        choice = group.all(limit)
        if choice is None or (count := count * len(choice)) > limit:
            return None
        choices.append(choice)
    return [_joined(parts) for parts in product(*choices)]


def _sample(groups: Sequence[Linked], stream: Stream) -> dict[Symbol, Value] | None:
    parts = []
    for group in groups:
        part = group.sample(stream)
        if part is None:
            return None
        parts.append(part)
    return _joined(parts)


def _joined(parts: Iterable[Mapping[Symbol, Value]]) -> dict[Symbol, Value]:
    world: dict[Symbol, Value] = {}
    for part in parts:
        world.update(part)
    return world


def in_words(values: Iterable[tuple[Symbol, Value]], most: int = 12) -> str:
    """A world as literals: `not p(a), q, f = v`; of many only the first."""
    texts = [claim_text((symbol, value, True)) for symbol, value in values]
    shown = ", ".join(texts[:most])
    return shown + (f", and {len(texts) - most} more" if len(texts) > most else "")
