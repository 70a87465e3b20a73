"""Combines the refused attempts of a task's stages into one refusal: reasons, colliding pairs, dependencies."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from kabo.geometry_server import REASONS, Pair, Refusal, owners
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


@dataclass
class Refusals:
    """Counts the refused attempts of one task's stages by reason and by colliding pair."""

    reasons: Counter[tuple[str, str]] = field(default_factory=Counter)  # (stage, reason)
    pairs: Counter[Pair] = field(default_factory=Counter)
    comments: dict[str, None] = field(default_factory=dict)
    reads: set[str] = field(default_factory=set)
    proved: bool = True
    missing: float | None = None

    def observe(self, stage: Stage, failure: Refused) -> None:
        """Counts one refused attempt of a stage."""
        refusal = refusal_of(failure)
        self.reasons[stage.name, refusal.reason] += 1
        if len(self.comments) < 2:
            self.comments[refusal.comment] = None
        for pair, count in refusal.pairs:
            self.pairs[pair] += count
        self.reads |= refusal.reads
        self.proved = self.proved and refusal.proof
        if refusal.missing is not None:
            self.missing = refusal.missing

    def count(self, reason: str) -> int:
        """The number of attempts that were refused for a reason."""
        return sum(n for (_, other), n in self.reasons.items() if other == reason)

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
        for (_, reason), count in self.reasons.items():
            counts[reason] += count
        proof = self.proved and bool(self.reasons) and not again
        pairs = tuple(sorted(self.pairs.items(), key=lambda item: (-item[1], item[0])))
        reason = counts.most_common(1)[0][0] if counts else "empty_family"
        text = f"{what}{' in yet another way' if again else ''}: {self._why(pairs)}"
        read = frozenset(self.reads) if proof else reads | self.reads | self.movable(scene)
        missing = self.missing if proof else None
        return Refusal(reason, text, read, pairs, proof, missing, sum(counts.values()))

    def _why(self, pairs: Iterable[tuple[Pair, int]]) -> str:
        if not self.reasons:
            return "there is none"
        comments = [comment for comment in self.comments if comment]
        if sum(self.reasons.values()) == 1 and comments:
            return comments[0]
        told = "; ".join(f"{stage}: {reason} {n}" for (stage, reason), n in sorted(self.reasons.items()))
        first = next(iter(pairs), None)
        return told if first is None else f"{told}; most often between {first[0][0]} and {first[0][1]}"
