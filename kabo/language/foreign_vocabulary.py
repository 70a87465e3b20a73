"""What an imported domain declares: types, predicates, functions and objects, by their names in the file.

The names of predicates, functions and objects share one namespace in kabo, types and actions have one each.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from kabo.language.findings import Findings, spell_place
from kabo.language.formulas import Constant, Place, Variable
from kabo.language.names import Names
from kabo.language.problem import Function

OBJECT = "object"
NUMBER = "number"

Kinds = tuple[str, ...]  # kabo's names of types, any of which is right; (NUMBER,) for numbers
ANY: Kinds = ()  # what is unknown because of a mistake that was reported: fits everywhere


class Types:
    """A tree of types, by kabo's names; `object` is the root of all others."""

    def __init__(self) -> None:
        self.names = Names([NUMBER])
        self.known: dict[str, str] = {}  # the name in the file -> kabo's
        self.places: dict[str, Place | None] = {}
        self.parents: dict[str, str | None] = {}

    def declare(self, original: str, place: Place | None) -> str:
        """Declares a type without a parent yet."""
        name = self.known[original] = self.names.take(original)
        self.places[original] = place
        self.parents[name] = None
        return name

    def ancestors(self, kind: str) -> list[str]:
        """The type and its supertypes."""
        found, current = [], kind
        while current is not None and current not in found:
            found.append(current)
            current = self.parents.get(current)  # type: ignore[assignment]
        return found

    def is_a(self, kind: str, ancestor: str) -> bool:
        """Whether `kind` is `ancestor` or one of its subtypes."""
        return kind == ancestor or ancestor in self.ancestors(kind)

    def fits(self, kinds: Kinds, wanted: Kinds) -> bool:
        """Whether a term of `kinds` may stand where `wanted` is asked for."""
        if kinds == wanted or not wanted:
            return True
        return all(any(self.is_a(kind, each) for each in wanted) for kind in kinds)

    def common(self, kinds: Kinds) -> str:
        """The nearest type that contains all of `kinds`."""
        if not kinds:
            return self.known[OBJECT]
        shared = self.ancestors(kinds[0])
        for kind in kinds[1:]:
            others = self.ancestors(kind)
            shared = [each for each in shared if each in others]
        return shared[0] if shared else kinds[0]

    def comparable(self, first: Kinds, second: Kinds) -> bool:
        """Whether terms of these kinds can be equal (as kabo's checker judges it)."""
        if not first or not second:
            return True
        if NUMBER in first or NUMBER in second:
            return first == second
        one, other = self.common(first), self.common(second)
        return self.is_a(one, other) or self.is_a(other, one)

    def in_order(self) -> dict[str, str | None]:
        """Every type with its parent, parents first: as a domain file would list them."""
        children: dict[str | None, list[str]] = {}
        for kind, parent in self.parents.items():
            children.setdefault(parent, []).append(kind)
        ordered: dict[str, str | None] = {}
        waiting = children.get(None, [])[::-1]
        while waiting:
            kind = waiting.pop()
            ordered[kind] = self.parents[kind]
            waiting.extend(children.get(kind, [])[::-1])
        return ordered


@dataclass(frozen=True)
class Signature:
    """A predicate, or a function with what its values are."""

    name: str  # kabo's
    original: str
    arguments: tuple[Kinds, ...]
    value: Kinds | None = None
    place: Place | None = None

    def spell(self, types: Types) -> str:
        """`at(truck, place)`, in kabo's names."""
        kinds = ", ".join(types.common(kinds) for kinds in self.arguments)
        return f"{self.original}({kinds})" if kinds else self.original


@dataclass
class Vocabulary:
    """All names of a domain, and of a problem on top of it."""

    findings: Findings
    types: Types = field(default_factory=Types)
    names: Names = field(default_factory=Names)
    predicates: dict[str, Signature] = field(default_factory=dict)  # by the name in the file
    functions: dict[str, Signature] = field(default_factory=dict)
    objects: dict[str, tuple[str, str]] = field(default_factory=dict)  # name in the file -> kabo's, its type or ""
    places: dict[str, Place | None] = field(default_factory=dict)  # of objects

    def signatures(self) -> dict[str, tuple[str, Place | None]]:
        """Signature and place of every predicate and function, for remedies."""
        if not self.findings.may_suggest:
            return {}
        both = {**self.functions, **self.predicates}
        return {name: (each.spell(self.types), each.place) for name, each in both.items()}

    def near(self, word: str, known: Iterable[str], *, all_if_few: bool = True) -> str | None:
        """The remedy `did you mean …` for an unknown name."""
        return self.findings.near(word, list(known), self.signatures(), all_if_few=all_if_few)

    def kinds_of_object(self, original: str) -> Kinds:
        """The type of an object; ANY if it was declared with one that does not exist."""
        kind = self.objects[original][1]
        return (kind,) if kind else ANY

    def report_renamed(self) -> None:
        """Warns of every name that is not what its spelling lets expect."""
        places = {each.original: each.place for each in (*self.predicates.values(), *self.functions.values())}
        for names, at in ((self.types.names, self.types.places), (self.names, {**places, **self.places})):
            for name, original in names.originals.items():
                place = at.get(original)
                plain = names.plain(original)
                if name == plain or place is None:
                    continue
                owner = names.originals.get(plain)
                reason = (
                    f'"{plain}" is taken by "{owner}"'
                    if owner is not None
                    else f'"{plain}" has a meaning of its own'
                )
                message = f'"{original}" is called "{name}" in kabo and in its plans'
                self.findings.add(place, message, reason, warning=True)

    def declared_at(self, signature: Signature) -> str | None:
        """The remedy that shows a declaration."""
        if signature.place is None:
            return None
        return f"{signature.spell(self.types)} is declared at {spell_place(signature.place)}"

    def kabo_predicates(self) -> dict[str, tuple[str, ...]]:
        """The predicates as a domain has them."""
        common = self.types.common
        return {each.name: tuple(map(common, each.arguments)) for each in self.predicates.values()}

    def kabo_functions(self) -> dict[str, Function]:
        """The functions as a domain has them."""
        found = {}
        for each in self.functions.values():
            value = None if each.value in (None, (NUMBER,)) else self.types.common(each.value or ())
            arguments = tuple(map(self.types.common, each.arguments))
            found[each.name] = Function(each.name, arguments, value, None)
        return found


@dataclass(frozen=True)
class Bound:
    """A variable in scope: what it is called in kabo, and what may be bound to it."""

    variable: Variable
    kinds: Kinds


Scope = Mapping[str, Bound]  # by the name in the file, with its question mark


def term_of_object(vocabulary: Vocabulary, original: str, place: Place | None) -> Constant:
    """An object as a term."""
    return Constant(vocabulary.objects[original][0], place)
