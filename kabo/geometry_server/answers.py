"""What a procedure answers: a motion and what it changed, or a reason for failure that names bodies."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from kabo.plan import Segment
from kabo.scene import Component

Reason = Literal["out_of_reach", "collision", "constraint", "no_path", "empty_family"]
Pair = tuple[str, str]

MAX_EFFORT = 2  # how often a procedure that was refused without a proof may be asked again with more samples


@dataclass(frozen=True)
class Success:
    """A motion that is proven free, and the components that have new values after it."""

    motion: tuple[Segment, ...]
    changes: Mapping[str, Component]


@dataclass(frozen=True)
class Failure:
    """Why a procedure found no motion.

    `between` counts refusals by the pair of things (`robot.link` or a body) that came too close. `reads` names the
    components on which the failure rests: it holds wherever they have the same values. `proof`: no number of
    samples would have helped. `missing` [m]: how far out of reach.
    """

    reason: Reason
    message: str
    reads: frozenset[str] = frozenset()
    between: tuple[tuple[Pair, int], ...] = ()
    proof: bool = False
    missing: float | None = None


Answer = Success | Failure


@dataclass
class Refusals:
    """Counts, over the samples of one call, why they were refused; says in the end what mattered."""

    reasons: Counter[str] = field(default_factory=Counter)
    pairs: Counter[Pair] = field(default_factory=Counter)

    def add(self, reason: Reason, pair: Pair | None = None) -> None:
        """One sample was refused for this reason, by this pair."""
        self.reasons[reason] += 1
        if pair is not None:
            self.pairs[pair] += 1

    def extend(self, reason: Reason, pairs: Iterable[tuple[Pair, int]]) -> None:
        """One sample was refused for this reason, by several pairs with their counts."""
        self.reasons[reason] += 1
        for pair, count in pairs:
            self.pairs[pair] += count

    def failure(self, what: str, reads: frozenset[str], movable: Iterable[str]) -> Failure:
        """The failure of a call whose samples were all refused; reads every movable thing that was in the way."""
        if not self.reasons:
            self.reasons["out_of_reach"] += 1
        reason = self.reasons.most_common(1)[0][0]
        between = tuple(sorted(self.pairs.items(), key=lambda item: (-item[1], item[0])))
        owners = {name.partition(".")[0] for pair in self.pairs for name in pair}
        named = frozenset(owners & set(movable))
        counts = ", ".join(f"{name} {count}" for name, count in sorted(self.reasons.items()))
        nearest = f"; most often between {between[0][0][0]} and {between[0][0][1]}" if between else ""
        return Failure(reason, f"{what}: {counts}{nearest}", reads | named, between)  # type: ignore[arg-type]


@dataclass
class Statistics:
    """What the geometry did, in counts (LANGUAGE section 7); the only thing of the server that changes."""

    inverse_kinematics_calls: int = 0
    inverse_kinematics_s: float = 0.0
    collision_checks: int = 0
    positive_collision_checks: int = 0
    pair_checks: int = 0
    samples: int = 0
    collision_s: float = 0.0
    calls: Counter[str] = field(default_factory=Counter)
    failures: dict[str, Counter[str]] = field(default_factory=dict)

    def drawn(self, samples: int) -> None:
        """So many samples were drawn and projected on constraints, each an inverse kinematics of its own."""
        self.samples += samples
        self.inverse_kinematics_calls += samples

    def record(self, procedure: str, answer: Answer) -> None:
        """One call of a procedure and its answer."""
        self.calls[procedure] += 1
        if isinstance(answer, Failure):
            self.failures.setdefault(procedure, Counter())[answer.reason] += 1

    @property
    def procedures(self) -> dict[str, dict[str, object]]:
        """Calls and failures of every procedure, by name."""
        names = sorted(self.calls)
        return {
            n: {"calls": self.calls[n], "failures": dict(sorted(self.failures.get(n, {}).items()))} for n in names
        }
