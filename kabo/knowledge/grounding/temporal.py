"""Goals about other states: `initially(φ)` (K⁰, after postdiction) and `always(φ)` (K*) [P, temporally extended goals].

`initially(φ)` is evaluated on *copies* of the atoms of φ, which no action changes. An entry "exactly one of copy and not
original" binds a copy to its original until an action changes the original. Through these entries, and through copies of
the initial entries, what is learned later is also learned about the initial state.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from kabo.knowledge.binding import Binding
from kabo.knowledge.closure import AlwaysMonitor
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim, Group, NumberBits, TermBits
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.queries import AllOf, Query
from kabo.language.formulas import Application, Atom, Temporal

PREFIX = "initially "


class TemporalGoals:
    """The temporal goals of one problem: their queries, and the monitors and copies that the queries need."""

    def __init__(self, compiler: Compiler) -> None:
        self.compiler = compiler
        self.monitors: list[AlwaysMonitor] = []
        compiler.temporal = self.query

    def query(self, formula: Temporal, binding: Binding) -> Query:
        """The query on the present state that is equivalent to a temporal goal."""
        if formula.kind == "always":
            bit = self.compiler.fluents.bit()
            self.monitors.append(AlwaysMonitor(self.compiler.query(formula.body, binding), bit))
            return AllOf(bit, bit)
        return self.compiler.query(self._of_copies(formula.body), binding)

    def _of_copies(self, tree: Any) -> Any:
        """The formula with every symbol that actions may change replaced by its copy."""
        written = self.compiler.symbols.written
        if isinstance(tree, tuple):
            return tuple(self._of_copies(part) for part in tree)
        if not is_dataclass(tree) or isinstance(tree, type):
            return tree
        changed = {f.name: self._of_copies(getattr(tree, f.name)) for f in fields(tree) if f.name != "place"}
        if isinstance(tree, Atom) and tree.predicate in written:
            changed["predicate"] = PREFIX + tree.predicate
        if isinstance(tree, Application) and tree.function in written:
            changed["function"] = PREFIX + tree.function
        return replace(tree, **changed)

    def bind(self, state: int) -> tuple[int, list[Entry]]:
        """Adds what is known of the copies to the initial state, and entries that bind them to their originals.

        Returns:
            the extended state, and the permanent entries that are not among the compiler's entries.
        """
        copies = _Copies(self.compiler, state)
        return copies.state, copies.entries


@dataclass
class _Copies:
    compiler: Compiler
    state: int

    def __post_init__(self) -> None:
        self.entries: list[Entry] = []
        self._copied: dict[str, Group] = {}
        active = [e for e in self.compiler.entries.values() if e.active and e.active & self.state]
        while True:
            count = len(self._copied)
            for name, arguments, copy in list(self.compiler.fluents.named(PREFIX)):
                if copy.text not in self._copied:
                    self._copied[copy.text] = copy
                    self._bind(self._group(name.removeprefix(PREFIX), arguments), copy)
            for entry in active:
                if any(self._has_copy(member) for member in entry.members):
                    for member in entry.members:
                        self._claim(member)
            if len(self._copied) == count:
                break
        for entry in active:
            if any(self._has_copy(member) for member in entry.members):
                self.entries.append(Entry(entry.exactly, tuple(self._claim(member) for member in entry.members)))

    def _group(self, name: str, arguments: tuple[str, ...]) -> Group:
        plain = name.removeprefix(PREFIX)
        if plain in self.compiler.problem.domain.predicates:
            return self.compiler.atom(name, arguments)
        if self.compiler.problem.values_of(plain) is None:
            return self.compiler.number_term(name, arguments)
        return self.compiler.term(name, arguments)

    def _bind(self, original: Group, copy: Group) -> None:
        known = isinstance(original, NumberBits) or self.state & (
            original.settled if isinstance(original, TermBits) else original.known
        )
        if known:
            self.state |= _moved(self.state, original, copy)
            return
        for own, other in _pairs(copy, original):
            if self.state & other.fails:
                self.state |= own.denied.makes
            entry = self.compiler.entry(True, [own, other.denied])
            self.state |= entry.active

    def _has_copy(self, member: Claim) -> bool:
        return PREFIX + member.group.text in self._copied

    def _claim(self, member: Claim) -> Claim:
        """The same claim about the copy; the claim itself if no action changes its group."""
        name, arguments = self.compiler.fluents.key_of(member.group)
        if name not in self.compiler.symbols.written:
            return member
        copy = self._group(PREFIX + name, arguments)
        return next(
            own if other.holds == member.holds else own.denied
            for own, other in _pairs(copy, member.group)
            if member.holds in (other.holds, other.fails)
        )


def _pairs(copy: Group, original: Group) -> Iterator[tuple[Claim, Claim]]:
    """The pairs of positive claims about a copy and its original."""
    if isinstance(copy, AtomBits) and isinstance(original, AtomBits):
        yield copy.claim(True), original.claim(True)
    elif isinstance(copy, TermBits) and isinstance(original, TermBits):
        for value in copy.equal:
            yield copy.claim(value, True), original.claim(value, True)


def _moved(state: int, original: Group, copy: Group) -> int:
    """The bits of the copy that say of it what is known of the original."""
    if isinstance(original, NumberBits) and isinstance(copy, NumberBits):
        value = original.decode(state)
        return 0 if value is None else copy.encode(value)
    made = 0
    for own, other in _pairs(copy, original):
        made |= own.makes if state & other.holds else 0
        made |= own.denied.makes if state & other.fails else 0
    return made
