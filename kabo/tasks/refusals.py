"""Combines the refused attempts of a task's stages into one refusal: reasons, colliding pairs, dependencies."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from kabo.geometry_server import REASONS, Askable, Measure, Pair, Refusal, owners
from kabo.scene import Scene
from kabo.tasks.core import Failure, Stage
from kabo.tasks.core.model.results import Refused


def refusal_of(failure: Refused) -> Refusal:
    """A stage's failure as a `Refusal` with the same comment.

    A reason that is not one of `REASONS` becomes `constraint`.
    """
    if isinstance(failure, Refusal) and failure.reason in REASONS:
        return failure
    known = failure if isinstance(failure, Refusal) else _refusal(failure)
    return replace(known, reason=known.reason if known.reason in REASONS else "constraint")


def _refusal(failure: Refused) -> Refusal:
    return Refusal(failure.reason, failure.comment, proof=isinstance(failure, Failure) and failure.proof)


MAX_COMMENTS = 24  # different comments that are counted for each stage and reason
SHOWN_COMMENTS = 2  # of them, that a message tells
TOLD_BY_PAIRS = ("collision", "no_path")  # reasons whose comments are the pairs that are told anyway


@dataclass
class _Tally:
    """The refused attempts of one stage for one reason: their number, what they said, and their nearest values."""

    count: int = 0
    comments: Counter[str] = field(default_factory=Counter)
    nearest: dict[str, Measure] = field(default_factory=dict)  # by name: the one that misses least

    def add(self, refusal: Refusal) -> None:
        """Counts one refused attempt."""
        self.count += 1
        for measure in refusal.measures:
            best = self.nearest.get(measure.name)
            if best is None or measure.missing < best.missing:
                self.nearest[measure.name] = measure
        known = refusal.comment in self.comments or len(self.comments) < MAX_COMMENTS
        if refusal.comment and not refusal.measures and known:
            self.comments[refusal.comment] += 1

    def told(self, reason: str) -> str:
        """What the attempts said, the numbers that came nearest first; empty if they said nothing of their own."""
        numbers = [measure.text for measure in self.nearest.values()]
        if self.count > 1 and numbers:
            numbers[0] = numbers[0] if self._all_proven else f"at best {numbers[0]}"
        others = [] if reason in TOLD_BY_PAIRS else [text for text, _ in self.comments.most_common()]
        shown = others[:SHOWN_COMMENTS]
        more = [f"{len(others) - len(shown)} more"] if len(others) > len(shown) else []
        return "; ".join([*numbers, *shown, *more])

    @property
    def _all_proven(self) -> bool:
        return all(measure.proven for measure in self.nearest.values())


@dataclass
class Refusals:
    """Counts the refused attempts of one task's stages by reason and by colliding pair."""

    tallies: dict[tuple[str, str], _Tally] = field(default_factory=dict)  # by stage and reason
    pairs: Counter[Pair] = field(default_factory=Counter)
    asked: dict[Pair, Askable] = field(
        default_factory=dict
    )  # the first question for each pair of one robot's links
    reads: set[str] = field(default_factory=set)
    proved: bool = True
    missing: float | None = None

    def observe(self, stage: Stage, failure: Refused) -> None:
        """Counts one refused attempt of a stage."""
        refusal = refusal_of(failure)
        self.tallies.setdefault((stage.name, refusal.reason), _Tally()).add(refusal)
        for pair, count in refusal.pairs:
            self.pairs[pair] += count
            if refusal.question is not None and len(set(owners(pair))) == 1:
                self.asked.setdefault(pair, refusal.question)
        self.reads |= refusal.reads
        self.proved = self.proved and refusal.proof
        if refusal.missing is not None:
            self.missing = refusal.missing

    def count(self, reason: str) -> int:
        """The number of attempts that were refused for a reason."""
        return sum(tally.count for (_, other), tally in self.tallies.items() if other == reason)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Of every limit that was not met, the value that came nearest."""
        return tuple(measure for tally in self.tallies.values() for measure in tally.nearest.values())

    def movable(self, scene: Scene) -> frozenset[str]:
        """The robots and movable objects that came too close to something in a refused attempt."""
        met = {owner for pair in self.pairs for owner in owners(pair)}
        return frozenset(met & {*scene.robots, *scene.movable})

    def total(self, what: str, reads: frozenset[str], scene: Scene, *, again: bool = False) -> Refusal:
        """The refusal of a call whose attempts were all refused.

        Args:
            what: the beginning of the message: `right cannot pick bottle_4`.
            reads: the components that the call's samples depend on.
            scene: the scene; unless the refusal is a proof, it also depends on `reads` and on `movable`.
            again: whether the call has succeeded before, so that the refusal is only of a further solution.
        """
        counts = Counter[str]()
        for (_, reason), tally in self.tallies.items():
            counts[reason] += tally.count
        proof = self.proved and bool(counts) and not again
        pairs = tuple(sorted(self.pairs.items(), key=lambda item: (-item[1], item[0])))
        reason = counts.most_common(1)[0][0] if counts else "empty_family"
        own = self._own(pairs)
        text = f"{what}{' in yet another way' if again else ''}: {self._why(pairs, own)}"
        read = frozenset(self.reads) if proof else reads | self.reads | self.movable(scene)
        missing = self.missing if proof else None
        total = sum(counts.values())
        measures = self.measures if own is None else (*self.measures, own)
        return Refusal(reason, text, read, pairs, proof, missing, total, measures=measures)

    def _own(self, pairs: Sequence[tuple[Pair, int]]) -> Measure | None:
        """How near the pair of links comes that blocked most often, if both belong to the robot that moves."""
        question = self.asked.get(pairs[0][0]) if pairs else None
        return None if question is None else question.nearness(pairs[0][0])

    def _why(self, pairs: Iterable[tuple[Pair, int]], own: Measure | None) -> str:
        """What every stage said, each with its numbers: nothing is dropped where there are several."""
        if not self.tallies:
            return "there is none"
        alone = next(iter(self.tallies.items())) if len(self.tallies) == 1 else None
        if alone is not None and alone[1].count == 1 and (said := alone[1].told("")):
            return said
        told = "; ".join(
            _row(stage, reason, tally) for (stage, reason), tally in sorted(self.tallies.items(), key=_order)
        )
        if own is not None:
            return f"{told}; most often {own.text}"
        first = next(iter(pairs), None)
        return told if first is None else f"{told}; most often between {first[0][0]} and {first[0][1]}"


def _order(item: tuple[tuple[str, str], _Tally]) -> tuple[str, str]:
    return item[0]


def _row(stage: str, reason: str, tally: _Tally) -> str:
    said = tally.told(reason)
    return f"{stage}: {reason} {tally.count}" + (f" ({said})" if said else "")
