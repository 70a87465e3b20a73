"""Ground actions and branchings: the two kinds of edge between knowledge states."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from kabo.knowledge.facts import AtomBits, Group, TermBits
from kabo.knowledge.progression import Effects
from kabo.knowledge.queries import GeometricOracle, Query, optimistic
from kabo.language.formulas import GroundCall


@dataclass(frozen=True)
class GroundAction:
    """An action with its arguments; `sense` are the facts that its run-time component delivers, as text."""

    name: str
    arguments: Mapping[str, str] = field(hash=False)
    call: GroundCall | None
    sense: tuple[str, ...]
    precondition: Query
    effects: Effects
    index: int  # its place in the task: order of the file, then of the arguments

    def __str__(self) -> str:
        return f"{self.name}({', '.join(self.arguments.values())})"

    def applicable(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the preconditions hold; geometry is another question."""
        return self.precondition.holds(state, test)

    def after(self, state: int, test: GeometricOracle = optimistic) -> int | None:
        """The state after the action, sensed facts still open; None if its updates contradict each other."""
        return self.effects.after(state, test)

    def needs(self, state: int, needed: int, test: GeometricOracle = optimistic) -> int:
        """Bits of `state` that let the action be applied and fix the bits `needed` of the state after."""
        return self.precondition.support(state, test) | self.effects.needs(state, needed, test)


@dataclass(frozen=True)
class Branching:
    """How knowledge splits on a Kw or Kv entry: one outcome for each truth or possible value, in plan order."""

    entry: int
    mask: int
    fact: str
    choices: tuple[tuple[str, int, int], ...]  # outcome, bit that it makes, bit that would exclude it

    def outcomes(self, state: int) -> Iterator[tuple[str, int]]:
        """Each possible outcome with the state in which it is known."""
        rest = state & ~self.mask
        for outcome, made, excluded in self.choices:
            if not state & excluded:
                yield outcome, rest | made


def branching_of(group: Group) -> Branching | None:
    """How an atom or a term with a finite range is branched on; None for numbers."""
    if isinstance(group, AtomBits):
        choices: tuple[tuple[str, int, int], ...] = (("false", group.false, 0), ("true", group.true, 0))
        return Branching(group.entry, group.mask, group.text, choices)
    if isinstance(group, TermBits):
        choices = tuple((value, bit, group.unequal.get(value, 0)) for value, bit in group.equal.items())
        return Branching(group.entry, group.mask, group.text, choices)
    return None
