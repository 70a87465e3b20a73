"""In which order goals are reasonably reached: A before B if whatever makes A must undo B first [Koehler, Hoffmann 2000].

A goal that holds counts as reached only when those that come before it hold, too. So a search does not cling to goals
that it has to give up.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo.finite_domain.mutexes import Condition, FactTask, Mutexes


@dataclass(frozen=True)
class Agenda:
    """Of each goal the ones that come before it; of two that demand each other neither does."""

    before: tuple[tuple[int, ...], ...]

    def open_goals(self, reached: Sequence[bool]) -> int:
        """How many goals do not count as reached."""
        return sum(
            not done or any(not reached[j] for j in before)
            for done, before in zip(reached, self.before, strict=True)
        )


def agenda(task: FactTask, mutexes: Mutexes, goals: Sequence[tuple[int, ...]]) -> Agenda:
    """The reasonable orders of goals, each given as the facts one of which must hold."""
    count = len(goals)
    ways = _ways(task, {f for goal in goals for f in goal})
    undoes = [_undone(task, mutexes, [c for f in goal for c in ways[f]]) for goal in goals]
    later = [
        {b for b in range(count) if b != a and all(undoes[a] >> f & 1 for f in goals[b])} for a in range(count)
    ]
    for _ in range(count):  # what comes before what comes before
        grown = [set().union(after, *(later[b] for b in after)) for after in later]
        if grown == later:
            break
        later = grown
    before = (
        tuple(a for a in range(count) if b in later[a] and a not in later[b] and a != b) for b in range(count)
    )
    return Agenda(tuple(before))


def _ways(task: FactTask, wanted: set[int]) -> dict[int, list[tuple[Condition, ...]]]:
    """Of each wanted fact the conditions of everything that makes it."""
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
    """The facts that are false just before, whichever way is gone."""
    undone = (1 << task.facts) - 1
    for conditions in ways:
        never = mutexes.never_with(conditions)
        if all(any(not never >> f & 1 for f in facts) for facts in conditions):  # it can be done at all
            undone &= never
    return undone
