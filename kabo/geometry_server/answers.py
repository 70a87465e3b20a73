"""Answers of geometric procedures: a motion and its effects, or the reason of a failure, with the bodies involved."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

from kabo.plan import Segment
from kabo.scene import Component

Reason = Literal["out_of_reach", "collision", "constraint", "no_path", "empty_family"]
Pair = tuple[str, str]

MAX_EFFORT = 8  # levels of effort, each with four times as many samples as the one before


@dataclass(frozen=True)
class Success:
    """A motion that is proven free, and the components that have new values after it.

    `reads` names the components that blocked earlier samples: with other values of theirs, one of those samples
    might have been the answer.
    """

    motion: tuple[Segment, ...]
    changes: Mapping[str, Component]
    reads: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Failure:
    """Why a procedure found no motion.

    `between` counts refusals by the pair of things (`robot.link` or a body) that came too close. `reads` names the
    components on which the failure depends: it holds wherever they have the same values. `proof`: true if no
    number of samples would have helped. `missing` [m]: how far out of reach. `attempts`: how many samples were
    refused.
    """

    reason: Reason
    message: str
    reads: frozenset[str] = frozenset()
    between: tuple[tuple[Pair, int], ...] = ()
    proof: bool = False
    missing: float | None = None
    attempts: int = 0


Answer = Success | Failure


@dataclass
class GeometryStatistics:
    """Counts of the geometric work (docs/plans.md#the-result); the only part of the server that changes."""

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
        """Counts samples that were drawn and projected onto constraints, each as a call of inverse kinematics."""
        self.samples += samples
        self.inverse_kinematics_calls += samples

    def record(self, procedure: str, answer: Answer) -> None:
        """Counts one call of a procedure, and its failure if it failed."""
        self.calls[procedure] += 1
        if isinstance(answer, Failure):
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
