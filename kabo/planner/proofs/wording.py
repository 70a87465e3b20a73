"""Bits of knowledge states as text: the fact that a bit represents, and the facts missing for a query."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import PurePath
from typing import Literal

from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim, ConjunctionBits, Group, NumberBits, TermBits
from kabo.knowledge.grounding.problem import Grounding
from kabo.knowledge.grounding.temporal import PREFIX
from kabo.knowledge.queries import All, AllOf, AnyOf, Query, Some, bits_of
from kabo.language.formulas import Place

Role = Literal["true", "false", "whether", "equal", "unequal", "known", "number", "entry", "always"]

SHOWN_ITEMS = 3  # items that a list in a sentence shows


@dataclass(frozen=True)
class Meaning:
    """The meaning of a bit: its text in kabo's language, and the atom, term or entry that it represents."""

    text: str
    role: Role
    about: str  # the atom, term or conjunction
    symbol: str  # its predicate or function
    group: Group | None = None


@dataclass(frozen=True)
class MissingFact:
    """A bit that a query requires to be 1 (`is_set`) or 0, and that can never have this value."""

    bit: int
    is_set: bool = True


class BitMeanings:
    """The meanings of all bits of a grounded problem."""

    def __init__(self, whole: Grounding) -> None:
        self._meanings: dict[int, Meaning] = {}
        for name, _, group in whole.compiler.fluents.named(""):
            self._add_group(name.removeprefix(PREFIX), group)
        for entry in whole.closure.propagators:
            if isinstance(entry, Entry):
                self._add_entry(entry)
        held = {monitor.held for monitor in whole.closure.monitors}
        for part in whole.goal:
            if isinstance(part.query, AllOf) and part.query.mask in held:
                self._meanings[part.query.mask] = Meaning(part.text, "always", part.text, part.text)

    def meaning(self, bit: int) -> Meaning:
        """The meaning of a bit."""
        return self._meanings.get(bit) or Meaning("what it remembers", "always", "it", "it")

    def text(self, fact: MissingFact) -> str:
        """A missing fact as a query: `K(p)`, or `not K(p)` for a bit that should be 0."""
        said = self.meaning(fact.bit).text
        return said if fact.is_set else f"not {said}"

    def query(self, query: Query, ones: int, zeros: int) -> str:
        """The parts of an impossible query that can never hold, as text.

        `ones` are the bits that can become 1, `zeros` those that can become 0.
        """
        match query:
            case AllOf() | AnyOf():
                texts = [self.text(fact) for fact in missing_facts(query, ones, zeros)]
                return listed(texts, "and" if isinstance(query, AllOf) else "or")
            case All(parts=parts):
                impossible = [part for part in parts if not part.possible(ones, zeros)]
                return listed([self._part(part, " or ", ones, zeros) for part in impossible], "and")
            case Some(parts=parts):
                return listed([self._part(part, " and ", ones, zeros) for part in parts], "or")
        return "a comparison"

    def _part(self, query: Query, inner: str, ones: int, zeros: int) -> str:
        """A part of a compound query; in parentheses if it is compound itself."""
        text = self.query(query, ones, zeros)
        return f"({text})" if inner in text else text

    def _add_group(self, symbol: str, group: Group) -> None:
        about = group.text.removeprefix(PREFIX)
        starts = group.text != about

        def add(bit: int, text: str, role: Role) -> None:
            self._meanings[bit] = Meaning(f"initially({text})" if starts else text, role, about, symbol, group)

        match group:
            case AtomBits():
                add(group.true, f"K({about})", "true")
                add(group.false, f"K(not {about})", "false")
                add(group.whether, f"Kw({about})", "whether")
            case TermBits():
                for value, bit in group.equal.items():
                    add(bit, f"K({about} = {value})", "equal")
                for value, bit in group.unequal.items():
                    add(bit, f"K({about} != {value})", "unequal")
                add(group.settled, f"a known value of {about}", "known")
                add(group.whether, f"Kv({about})", "whether")
            case NumberBits():
                add(group.known, f"a known number {about}", "number")
                add(group.whether, f"Kv({about})", "whether")
            case ConjunctionBits():
                add(group.whether, f"Kw({about})", "whether")

    def _add_entry(self, entry: Entry) -> None:
        text = f"that {entry_text(entry)}"
        for bit in bits_of(entry.mask):
            self._meanings[bit] = Meaning(text, "entry", text, "an entry")


def missing_facts(query: Query, ones: int, zeros: int) -> Iterator[MissingFact]:
    """The facts whose absence makes a query impossible; a fact that occurs several times is repeated."""
    match query:
        case AllOf(mask, value):
            for bit in bits_of(mask):
                if bit & value & ~ones or bit & ~value & ~zeros:
                    yield MissingFact(bit, bool(bit & value))
        case AnyOf(mask):
            yield from map(MissingFact, bits_of(mask))
        case All(parts=parts) | Some(parts=parts):
            for part in parts:
                if not part.possible(ones, zeros):
                    yield from missing_facts(part, ones, zeros)


def claim_in_words(claim: Claim) -> str:
    """A claim as text in kabo's language."""
    group = claim.group
    about = group.text.removeprefix(PREFIX)
    if isinstance(group, AtomBits):
        said = about if claim.holds == group.true else f"not {about}"
    else:
        assert isinstance(group, TermBits)
        sides = ((group.equal, "="), (group.unequal, "!="))
        said = next(f"{about} {sign} {v}" for bits, sign in sides for v, bit in bits.items() if bit == claim.holds)
    return said if about == group.text else f"initially({said})"


def entry_text(entry: Entry) -> str:
    """An entry of Kx or Kor as text."""
    members = [claim_in_words(member) for member in entry.members]
    return f"{'exactly' if entry.exactly else 'at least'} one holds of {listed(members, 'and')}"


def listed(texts: Iterable[str], word: str, shown: int = SHOWN_ITEMS) -> str:
    """A list for messages, such as `a, b and 5 more`; repeated texts appear once."""
    every = list(dict.fromkeys(texts))
    if len(every) > shown + 1:
        every = [*every[:shown], f"{len(every) - shown} more"]
    return f" {word} ".join(filter(None, [", ".join(every[:-1]), every[-1]])) if every else ""


def where(place: Place) -> str:
    """A place as messages show it: `domain.yaml:31`."""
    return f"{PurePath(place.file).name}:{place.line}"
