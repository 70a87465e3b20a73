"""From refused attempts of stages to the failure of a procedure: reasons, pairs, and on what it rests."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import get_args

from kabo.geometry_server import Failure, Pair
from kabo.geometry_server.answers import Reason
from kabo.scene import Scene
from kabo.tasks.core import Failure as StageFailure
from kabo.tasks.core import Stage
from kabo.tasks.robots import Details

_REASONS: Mapping[str, Reason] = {reason: reason for reason in get_args(Reason)}


def reason_of(failure: StageFailure) -> Reason:
    """The reason of a stage's failure, as a procedure's failure says it: `constraint` for one of a stage's own."""
    return _REASONS.get(failure.reason, "constraint")


@dataclass
class Refusals:
    """Every refused attempt of one task's stages, counted; bounded by the number of distinct reasons and pairs."""

    reasons: Counter[tuple[str, Reason]] = field(default_factory=Counter)  # (stage, reason)
    pairs: Counter[Pair] = field(default_factory=Counter)
    comments: dict[str, None] = field(default_factory=dict)
    reads: set[str] = field(default_factory=set)
    proved: bool = True
    missing: float | None = None

    def observe(self, stage: Stage, failure: StageFailure) -> None:
        """One attempt of a stage was refused."""
        self.reasons[stage.name, reason_of(failure)] += 1
        if len(self.comments) < 2:
            self.comments[failure.comment] = None
        details = failure.details if isinstance(failure.details, Details) else Details()
        for pair, count in details.pairs:
            self.pairs[pair] += count
        self.reads |= details.reads
        self.proved = self.proved and details.proof
        if details.missing is not None:
            self.missing = details.missing

    def count(self, reason: str) -> int:
        """How many attempts were refused for a reason."""
        return sum(n for (_, other), n in self.reasons.items() if other == reason)

    def movable(self, scene: Scene) -> frozenset[str]:
        """The components that were in the way of an attempt."""
        owners = {name.partition(".")[0] for pair in self.pairs for name in pair}
        return frozenset(owners & {*scene.robots, *scene.movable})

    def failure(self, what: str, reads: frozenset[str], scene: Scene, *, again: bool = False) -> Failure:
        """The failure of a call whose attempts were all refused.

        Args:
            what: the beginning of the sentence: `right cannot pick bottle_4`.
            reads: the components that its samples depend on.
            scene: every movable thing of it that was in the way is read as well.
            again: there were successes before.
        """
        counts = Counter[Reason]()
        for (_, reason), count in self.reasons.items():
            counts[reason] += count
        proof = self.proved and bool(self.reasons) and not again
        between = tuple(sorted(self.pairs.items(), key=lambda item: (-item[1], item[0])))
        reason = counts.most_common(1)[0][0] if counts else "empty_family"
        text = f"{what}{' in yet another way' if again else ''}: {self._why(between)}"
        read = frozenset(self.reads) if proof else reads | self.reads | self.movable(scene)
        missing = self.missing if proof else None
        return Failure(reason, text, read, between, proof, missing, sum(counts.values()))

    def _why(self, between: Iterable[tuple[Pair, int]]) -> str:
        if not self.reasons:
            return "there is none"
        comments = [comment for comment in self.comments if comment]
        if sum(self.reasons.values()) == 1 and comments:
            return comments[0]
        told = "; ".join(f"{stage}: {reason} {n}" for (stage, reason), n in sorted(self.reasons.items()))
        first = next(iter(between), None)
        return told if first is None else f"{told}; most often between {first[0][0]} and {first[0][1]}"
