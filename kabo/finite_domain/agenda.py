"""Reasonable orders of goals: A before B if B is false just before A is achieved [Koehler, Hoffmann 2000].

A goal that holds counts as reached only when all goals ordered before it hold, too. So a search gains nothing by
achieving early a goal that it has to give up again.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo.finite_domain.mutexes import Condition, FactTask, Mutexes


@dataclass(frozen=True)
class Agenda:
    """The goals ordered before each goal; two goals that would each precede the other are left unordered."""

    before: tuple[tuple[int, ...], ...]

    def open_goals(self, reached: Sequence[bool]) -> int:
        """The number of goals that do not count as reached; `reached` says of each goal whether it holds."""
        return sum(
            not done or any(not reached[j] for j in before)
            for done, before in zip(reached, self.before, strict=True)
        )


def agenda(task: FactTask, mutexes: Mutexes, goals: Sequence[tuple[int, ...]]) -> Agenda:
    """The reasonable orders of `goals`; each goal is given by the facts of which one must hold."""
    count = len(goals)
    ways = _achievers(task, {f for goal in goals for f in goal})
    undoes = [_undone(task, mutexes, [c for f in goal for c in ways[f]]) for goal in goals]
    later = [
        {b for b in range(count) if b != a and all(undoes[a] >> f & 1 for f in goals[b])} for a in range(count)
    ]
    for _ in range(count):
        grown = [set().union(after, *(later[b] for b in after)) for after in later]
        if grown == later:
            break
        later = grown
    before = (
        tuple(a for a in range(count) if b in later[a] and a not in later[b] and a != b) for b in range(count)
    )
    return Agenda(tuple(before))


def _achievers(task: FactTask, wanted: set[int]) -> dict[int, list[tuple[Condition, ...]]]:
    """For each wanted fact the conditions of all its achievers."""
    ways: dict[int, list[tuple[Condition, ...]]] = {f: [] for f in wanted}
    for o in task.operators:
        for f in wanted.intersection(o.always):
            ways[f].append(o.needs)
        for group in o.depends:
            for conditions, made in group:
                for f in made:
                    if f in wanted:
                        ways[f].append((*o.needs, *conditions))
    return ways


def _undone(task: FactTask, mutexes: Mutexes, ways: Sequence[tuple[Condition, ...]]) -> int:
    """The facts that are false just before, whichever of these achievers is used."""
    undone = (1 << task.facts) - 1
    for conditions in ways:
        never = mutexes.never_with(conditions)
        if all(
            any(not never >> f & 1 for f in facts) for facts in conditions
        ):  # else the achiever is never applicable
            undone &= never
    return undone
