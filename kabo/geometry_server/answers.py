"""Answers of geometric procedures: a motion and its effects, or a refusal with its reason and the bodies involved."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

from kabo.geometry_server.foresight.measures import Measure
from kabo.plan import Learned, Segment
from kabo.scene import Component

Pair = tuple[str, str]

LEARNED_REASONS = (
    "not_explored",
    "nothing_valid",
    "out_of_range",
)  # why no parameters can be inferred from a model
# Why a procedure may be refused.
REASONS = (
    "out_of_reach",
    "collision",
    "constraint",
    "no_path",
    "empty_family",
    "hidden",
    "out_of_view",
    *LEARNED_REASONS,
)
BLOCKED_REASONS = (
    "collision",
    "no_path",
    "hidden",
)  # something else is in the way: the refusal names pairs of things

MAX_EFFORT = 8  # levels of effort, each with four times as many samples as the one before


@dataclass(frozen=True)
class Success:
    """A motion that is proven free, and the components that have new values after it.

    `reads` names the components that blocked earlier samples: if these components had other values, an earlier
    sample might have been the answer. `learned` are the learned parameters that the motion uses; their models are named by
    the paths at which they were opened.
    """

    motion: tuple[Segment, ...]
    changes: Mapping[str, Component]
    reads: frozenset[str] = frozenset()
    learned: tuple[Learned, ...] = ()


class Askable(Protocol):
    """The geometric query on which an attempt was refused, stored so that it can be repeated."""

    @property
    def is_search(self) -> bool:
        """Whether the query needs a path search to be answered."""

    @property
    def streams(self) -> Sequence[Any]:
        """The `Stream`s of candidates from which the attempt was drawn."""

    def passes(self, context: Any, without: str | None = None) -> bool:
        """Whether the query succeeds in `context`, with body `without` removed if it is given; all else is unchanged."""

    def nearness(self, pair: Pair) -> Measure | None:
        """How near two links of the robot that is asked about come; None if they are not both its links."""

    def sample(self) -> Any:
        """The `Situation` that was refused, to be looked at: the robot is where it would have stopped."""


@dataclass(frozen=True)
class Refusal:
    """The failure to find a motion: of one attempt of a stage, or of all attempts of a procedure.

    Args:
        reason: one of `REASONS`, or another reason defined by a stage; counts are grouped by reason.
        comment: a sentence about the refusal for users.
        reads: the components that the refusal depends on; it holds wherever these have the same values.
        pairs: for each pair of things (`robot.link` or a body) the number of times that it came too close.
        proof: whether the refusal is a proof, so that no number of samples would help.
        missing: the distance by which the target is out of reach [m].
        attempts: the number of refused attempts that the refusal summarises; 0 if they were not counted.
        question: the refused query, so that it can be repeated in another situation.
        measures: the numbers on which the refusal rests, each of a constraint or limit that was not met.
    """

    reason: str
    comment: str = ""
    reads: frozenset[str] = frozenset()
    pairs: tuple[tuple[Pair, int], ...] = ()
    proof: bool = False
    missing: float | None = None
    attempts: int = 0
    question: Askable | None = None
    measures: tuple[Measure, ...] = ()

    @classmethod
    def collision(
        cls,
        pair: Pair,
        comment: str = "",
        *,
        reads: frozenset[str] = frozenset(),
        question: Askable | None = None,
    ) -> "Refusal":
        """The refusal of an attempt that brings two things too close."""
        return cls("collision", comment or pair_text(pair), reads, ((pair, 1),), question=question)


def pair_text(pair: Pair) -> str:
    """The text of a pair of things that come too close."""
    return f"{pair[0]} – {pair[1]}"


def owners(pair: Pair) -> tuple[str, str]:
    """The robots or bodies that two things belong to: a link to its robot, a body to itself."""
    return pair[0].partition(".")[0], pair[1].partition(".")[0]


Answer = Success | Refusal


@dataclass
class GeometryStatistics:
    """Counts of the geometric work (docs/reference/plans.md#the-result)."""

    inverse_kinematics_calls: int = 0
    inverse_kinematics_s: float = 0.0
    collision_checks: int = 0
    positive_collision_checks: int = 0
    pair_checks: int = 0
    samples: int = 0
    collision_s: float = 0.0
    calls: Counter[str] = field(default_factory=Counter)
    failures: dict[str, Counter[str]] = field(default_factory=dict)

    def count_samples(self, samples: int) -> None:
        """Adds a number of samples, drawn and projected onto constraints, each counted as a call of inverse kinematics."""
        self.samples += samples
        self.inverse_kinematics_calls += samples

    def record(self, procedure: str, answer: Answer) -> None:
        """Counts one call of a procedure, and a failure if the answer is a refusal."""
        self.calls[procedure] += 1
        if isinstance(answer, Refusal):
            self.failures.setdefault(procedure, Counter())[answer.reason] += 1

    def copy(self) -> "GeometryStatistics":
        """A copy of the present counts."""
        return GeometryStatistics().add(self)

    def add(self, other: "GeometryStatistics") -> "GeometryStatistics":
        """Adds the counts of work done in other processes; returns this object."""
        self._count(other, 1)
        return self

    def since(self, before: "GeometryStatistics") -> "GeometryStatistics":
        """The counts since `before` was copied."""
        counted = self.copy()
        counted._count(before, -1)
        return counted

    def _count(self, other: "GeometryStatistics", sign: int) -> None:
        for each in fields(self):
            value = getattr(other, each.name)
            if isinstance(value, (int, float)):
                setattr(self, each.name, getattr(self, each.name) + sign * value)
        self.calls = _counted(self.calls, other.calls, sign)
        for name, reasons in other.failures.items():
            self.failures[name] = _counted(self.failures.get(name, Counter()), reasons, sign)
        self.failures = {name: reasons for name, reasons in self.failures.items() if reasons}

    @property
    def procedures(self) -> dict[str, dict[str, object]]:
        """Calls and failures of every procedure, by name."""
        names = sorted(self.calls)
        return {
            n: {"calls": self.calls[n], "failures": dict(sorted(self.failures.get(n, {}).items()))} for n in names
        }


def _counted(counts: Counter[str], more: Counter[str], sign: int) -> Counter[str]:
    total = Counter(counts)
    for name, number in more.items():
        total[name] += sign * number
    return +total  # without those that are none
