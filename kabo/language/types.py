"""The tree of types of a domain, and kinds: the sets of values that terms may have."""

from dataclasses import dataclass

from kabo.language.formulas import Place
from kabo.language.names import Names

OBJECT = "object"
NUMBER = "number"


@dataclass(frozen=True)
class Values:
    """An enumeration: the values that a function lists."""

    names: tuple[str, ...]

    def __str__(self) -> str:
        return "{" + ", ".join(self.names) + "}"


Kind = tuple[str, ...] | Values  # names of types, any of which is right; or an enumeration
ANY: Kind = ()  # unknown because of a mistake that was reported: fits everywhere
NUMBERS: Kind = (NUMBER,)
TEST: Kind = ("true or false",)  # what an external procedure without a value answers; no name of a type has blanks


class Types:
    """A tree of types, by their names in kabo. In PDDL and PKS `object` is the supertype of all other types."""

    def __init__(self) -> None:
        self.names = Names([NUMBER])
        self.known: dict[str, str] = {}  # the name in the file -> kabo's
        self.places: dict[str, Place | None] = {}
        self.parents: dict[str, str | None] = {}
        self.root = ""  # what a term of unknown kind is in PDDL and PKS

    def declare(self, original: str, place: Place | None) -> str:
        """Declares a type that has no parent yet, under an unused name in kabo, which is returned."""
        name = self.names.take(original)
        self.root = name if original == OBJECT else self.root
        self.add(name, place, None, original)
        return name

    def add(self, name: str, place: Place | None, parent: str | None, original: str | None = None) -> None:
        """Adds a type with exactly the name `name`."""
        original = name if original is None else original
        self.known[original], self.places[original], self.parents[name] = name, place, parent

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

    def fits(self, kind: Kind, wanted: Kind) -> bool:
        """Whether a term of `kind` may be used where kind `wanted` is required."""
        if kind == wanted or ANY in (kind, wanted):
            return True
        if isinstance(kind, Values) or isinstance(wanted, Values):
            return isinstance(kind, Values) and isinstance(wanted, Values) and set(kind.names) <= set(wanted.names)
        return all(any(self.is_a(each, other) for other in wanted) for each in kind)

    def comparable(self, first: Kind, second: Kind) -> bool:
        """Whether terms of these kinds can be equal."""
        if isinstance(first, Values) and isinstance(second, Values):
            return bool(set(first.names) & set(second.names))
        if ANY in (first, second):
            return True
        if isinstance(first, Values) or isinstance(second, Values):
            return False
        if NUMBER in first or NUMBER in second:
            return first == second
        one, other = self.common(first), self.common(second)
        return self.is_a(one, other) or self.is_a(other, one)

    def common(self, kind: Kind) -> str:
        """The nearest common supertype of all types of a kind; for an enumeration its text: `{red, green}`."""
        if isinstance(kind, Values):
            return str(kind)
        if len(kind) < 2:
            return kind[0] if kind else self.root
        shared = self.ancestors(kind[0])
        for each in kind[1:]:
            others = self.ancestors(each)
            shared = [name for name in shared if name in others]
        return shared[0] if shared else kind[0]

    def in_order(self) -> dict[str, str | None]:
        """Every type with its parent or None, in an order in which parents come before their children."""
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


def type_of(kind: Kind) -> str:
    """The text of a kind: the name of its only type, or its enumeration; empty for an unknown kind."""
    return str(kind) if isinstance(kind, Values) else kind[0] if kind else ""


def types_of(kind: Kind) -> tuple[str, ...]:
    """The types of a kind; a value of any of them belongs to the kind."""
    return () if isinstance(kind, Values) else kind
