"""Errors for initial knowledge that contradicts itself: they name every place involved, and the remedy."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product

from kabo.errors import Diagnostic, InputError
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, Claim, Group, TermBits
from kabo.knowledge.queries import union
from kabo.language import spell_bound
from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Comparison,
    Constant,
    Effect,
    Fact,
    FactAll,
    Literal,
    Number,
    Place,
    Term,
)
from kabo.language.problem import Problem

MAX_WORLDS = 4096  # worlds of atoms and terms that entries tie together; more are left to unit propagation
_ONE_TIME = "the initial knowledge holds all at once: remove one of the two, or write del(Kf, …) between them"
_Key = tuple[str, tuple[Term, ...]]


def refuse_opposites(problem: Problem) -> None:
    """Refuses two initial facts about one atom or term that exclude each other, so that no fact wins silently.

    A fact about all instances (`forall …`) is a default, which facts about single instances may replace.

    Raises:
        InputError: two facts exclude each other; the error names both places of each such pair.
    """
    if problem.domain.worldly:
        return  # in PDDL what is false comes first, and its reader has compared the facts
    said: dict[_Key, Literal | Comparison] = {}
    found: list[Diagnostic] = []
    for piece in problem.initial:
        if not isinstance(piece, Change) or piece.database != "Kf":
            continue
        for fact in _single(piece.facts):
            key = _key(fact)
            if key is None or not isinstance(fact, Literal | Comparison):
                continue
            if piece.operation == "del":
                said.pop(key, None)
                continue
            before = said.setdefault(key, fact)
            if _excludes(before, fact):
                found.append(_opposites(before, fact, str(problem.path)))
    if found:
        raise InputError(found)


def explained(problem: Problem, contradicts: Callable[[Problem], bool]) -> InputError:
    """The error for initial knowledge that contradicts itself: it names the parts that contradict each other.

    Args:
        problem: the problem whose initial knowledge contradicts itself.
        contradicts: a function that says whether the initial knowledge of a problem contradicts itself.
    """
    pieces = [piece for effect in problem.initial for piece in _pieces(effect)]

    def holds_apart(some: Sequence[Effect]) -> bool:
        return not contradicts(replace(problem, initial=tuple(some)))

    first, last = 0, len(pieces)  # the pieces before `first` agree, those before `last` do not
    while last - first > 1:
        middle = (first + last) // 2
        first, last = (middle, last) if holds_apart(pieces[:middle]) else (first, middle)
    kept = _needed(pieces[: last - 1], lambda some: not holds_apart([*some, pieces[last - 1]]))
    culprit = pieces[last - 1]
    places = [place for piece in kept if _takes_part(piece) and (place := getattr(piece, "place", None))]
    message = "the initial knowledge contradicts itself: nothing can be as it says"
    if places:
        others = ", ".join(f"{place.file}:{place.line}:{place.column}" for place in dict.fromkeys(places))
        message += f"; this part of it does not go with what stands at {others}"
    hint = "remove one of them, or what it says too much"
    return InputError([_diagnostic(getattr(culprit, "place", None), message, hint, str(problem.path))])


def has_world(state: int, entries: Iterable[tuple[Entry, tuple[Claim, ...]]]) -> bool:
    """Whether some world agrees with all entries; also True if there are too many worlds to try.

    Args:
        state: the known bits.
        entries: each entry with its members that are not known to be false.
    """
    waiting = list(entries)
    while waiting:
        some = [waiting.pop()]
        groups = {member.group for member in some[0][1]}
        while True:
            near = [each for each in waiting if any(member.group in groups for member in each[1])]
            if not near:
                break
            some += near
            waiting = [each for each in waiting if each not in near]
            groups |= {member.group for each in near for member in each[1]}
        if not _agrees(state, some, sorted(groups, key=lambda group: group.mask)):
            return False
    return True


def _agrees(state: int, entries: list[tuple[Entry, tuple[Claim, ...]]], groups: list[Group]) -> bool:
    ranges, count = [], 1
    for group in groups:
        ranges.append(_range(group, state))
        count *= len(ranges[-1])
        if count > MAX_WORLDS:
            return True
    for values in product(*ranges):
        world = union(values)
        if all(_holds(entry, members, world) for entry, members in entries):
            return True
    return False


def _range(group: Group, state: int) -> list[int]:
    """The possible truths or values of an atom or a term, each as the bits that are set when it is known."""
    if isinstance(group, AtomBits):
        return [group.claim(value).makes for value in (False, True) if not state & group.claim(value).fails]
    assert isinstance(group, TermBits)
    return [group.learned(value) for value in group.equal if not state & group.unequal.get(value, 0)]


def _holds(entry: Entry, members: tuple[Claim, ...], world: int) -> bool:
    true = sum(1 for member in members if world & member.holds)
    return true == 1 if entry.exactly else true > 0


# ----------------------------------------------------------------------------------------------------- single facts
def _single(facts: tuple[Fact, ...]) -> Iterator[Fact]:
    for fact in facts:
        yield from _single(fact.parts) if isinstance(fact, FactAll) else (fact,)


def _key(fact: Fact) -> _Key | None:
    """The ground atom or term of a fact; None if it is about several."""
    about: object = fact.atom if isinstance(fact, Literal) else fact.left if isinstance(fact, Comparison) else None
    if isinstance(about, Atom | Application) and all(isinstance(each, Constant) for each in about.arguments):
        return (about.predicate if isinstance(about, Atom) else about.function), about.arguments
    return None


def _excludes(one: Fact, other: Fact) -> bool:
    if isinstance(one, Literal) and isinstance(other, Literal):
        return one.positive != other.positive
    if not (isinstance(one, Comparison) and isinstance(other, Comparison)):
        return False
    if not all(isinstance(each.right, Constant | Number) for each in (one, other)):
        return False
    same, operators = one.right == other.right, {one.operator, other.operator}
    return operators == {"="} and not same or operators == {"=", "!="} and same


def _opposites(before: Literal | Comparison, fact: Literal | Comparison, path: str) -> Diagnostic:
    where = "" if before.place is None else f" at {before.place.file}:{before.place.line}:{before.place.column}"
    message = f'"{spell_bound(fact, {})}" contradicts "{spell_bound(before, {})}"{where}'
    return _diagnostic(fact.place, message, _ONE_TIME, path)


def _diagnostic(place: Place | None, message: str, hint: str, path: str) -> Diagnostic:
    if place is None:
        return Diagnostic(path, 1, 1, message, hint)
    return Diagnostic(place.file, place.line, place.column, message, hint, place.length)


# --------------------------------------------------------------------------------------------- several facts together
def _pieces(effect: Effect) -> Iterator[Effect]:
    """An initial update, split into one for each fact where it is about single facts."""
    if isinstance(effect, Change) and effect.database == "Kf":
        for fact in effect.facts:
            yield replace(effect, facts=(fact,), place=fact.place or effect.place)
    else:
        yield effect


def _takes_part(effect: Effect) -> bool:
    """Whether the update can be part of a contradiction: it adds, and is not about all instances at once."""
    return isinstance(effect, Change) and effect.operation == "add"


def _needed(pieces: list[Effect], is_enough: Callable[[list[Effect]], bool]) -> list[Effect]:
    """A minimal part of the pieces that is still enough: pieces are left out as long as it is, larger parts first."""
    size = max(1, len(pieces) // 2)
    while True:
        start = 0
        while start < len(pieces):
            part = pieces[start : start + size]
            rest = pieces[:start] + [each for each in part if not _takes_part(each)] + pieces[start + size :]
            if len(rest) < len(pieces) and is_enough(rest):
                pieces = rest
            else:
                start += size
        if size == 1:
            return pieces
        size //= 2
