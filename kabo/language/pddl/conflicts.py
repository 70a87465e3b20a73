"""PDDL's rule that additions win if an action adds and deletes the same atom, made explicit in conditions.

In kabo it is a contradiction to add p and (not p) at once. So every deletion gets a condition that excludes the
cases in which the same atom is added. Mostly this condition is only an inequality of arguments.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from kabo.language import formulas as f
from kabo.language.connectives import conjunction, denied, disjunction, negated
from kabo.language.pddl.effects import ConditionalEffect
from kabo.language.tree_algebra import rebound, renaming, substituted, variable_names
from kabo.language.types import Types

_MOST_PARTS = 64  # of one deletion
_MOST_MEETINGS = 20_000  # of one action


@dataclass(frozen=True)
class ConflictContext:
    """Facts about an action that decide whether one of its deletions conflicts with one of its additions.

    Attributes:
        types: the types of the domain.
        sorts: the type of every object.
        assumed: the action's preconditions.
        known: a function that returns whether everything in a condition is always known.
        report: called with a deletion for which it is unknown whether the same atom is added, and with True if the
            deletion cannot be expressed or False if it stays unchanged.
    """

    types: Types
    sorts: Mapping[str, str]
    assumed: tuple[f.Formula, ...]
    known: Callable[[object], bool]
    report: Callable[[ConditionalEffect, bool], None]

    def sort(self, term: f.Term) -> str | None:
        """The type of a term that is a variable or an object; None for other terms."""
        if isinstance(term, f.Variable):
            return term.type
        return self.sorts.get(term.name) if isinstance(term, f.Constant) else None

    def comparable(self, first: f.Term, second: f.Term) -> bool:
        """Whether the terms may be the same object."""
        one, other = self.sort(first), self.sort(second)
        return one is None or other is None or self.types.is_a(one, other) or self.types.is_a(other, one)

    def narrower(self, first: f.Term, variable: f.Variable) -> bool:
        """Whether every possible value of `first` is also a possible value of the variable."""
        sort = self.sort(first)
        return sort is not None and self.types.is_a(sort, variable.type)

    def different(self, first: f.Term, second: f.Term) -> bool:
        """Whether one of the preconditions states that the terms differ."""
        both = ((first, second), (second, first))
        return any(f.Know(f.Comparison("!=", one, other)) in self.assumed for one, other in both)


def additions_win(pieces: list[ConditionalEffect], around: ConflictContext) -> list[ConditionalEffect]:
    """The effects of one action, in which each deletion happens only if the action does not add the same atom."""
    additions: dict[str, list[ConditionalEffect]] = {}
    pieces = list(dict.fromkeys(pieces))
    for piece in pieces:
        if isinstance(piece.outcome, f.Literal) and piece.outcome.positive:
            additions.setdefault(piece.symbol, []).append(piece)
    resolved: list[ConditionalEffect] = []
    meetings = 0
    for piece in pieces:
        if not isinstance(piece.outcome, f.Literal) or piece.outcome.positive:
            resolved.append(piece)
            continue
        parts = [piece]
        avoided = variable_names((piece.variables, piece.condition, piece.outcome))
        for rival in additions.get(piece.symbol, ()):
            if _differ_plainly(piece, rival):
                continue
            meetings += len(parts)
            if len(parts) > _MOST_PARTS or meetings > _MOST_MEETINGS:
                around.report(piece, True)
                return resolved
            parts = [each for part in parts for each in _apart(part, _renamed(rival, avoided), around)]
        resolved += parts
    return resolved


def _differ_plainly(deletion: ConditionalEffect, addition: ConditionalEffect) -> bool:
    """Whether some argument is one object here and another one there."""
    for first, second in zip(deletion.arguments, addition.arguments, strict=True):
        if first != second and isinstance(first, f.Constant) and isinstance(second, f.Constant):
            return True
    return False


def _renamed(addition: ConditionalEffect, avoided: set[str]) -> ConditionalEffect:
    """The addition with variables of its own, none of which is to be avoided."""
    own = variable_names((addition.variables, addition.condition, addition.outcome))
    renamed = renaming(addition.variables, avoided, avoided | own)
    return replace(
        addition,
        variables=tuple(renamed.get(variable.name, variable) for variable in addition.variables),
        condition=rebound(substituted(addition.condition, renamed), avoided),
        outcome=substituted(addition.outcome, renamed),
    )


def may_be_same(first: ConditionalEffect, second: ConditionalEffect, around: ConflictContext) -> bool:
    """Whether two effects may change the same atom or term."""
    return _equalities(first, second, around) is not None


def _equalities(
    deletion: ConditionalEffect, addition: ConditionalEffect, around: ConflictContext
) -> list[tuple[f.Term, f.Term]] | None:
    """The pairs of arguments that must be equal for the two to meet; None if they never do."""
    pairs = []
    for first, second in zip(deletion.arguments, addition.arguments, strict=True):
        if isinstance(first, f.Constant) and isinstance(second, f.Constant):
            if first != second:
                return None
        elif not around.comparable(first, second) or around.different(first, second):
            return None
        elif first != second:
            pairs.append((first, second))
    return pairs


def _apart(
    deletion: ConditionalEffect, addition: ConditionalEffect, around: ConflictContext
) -> Iterator[ConditionalEffect]:
    """The deletion, restricted to where the addition does not happen."""
    pairs = _equalities(deletion, addition, around)
    if pairs is None:
        yield deletion
        return
    # A variable of the addition's own that must equal a term of the deletion is that term.
    own: dict[str, f.Term] = {}
    rest: list[tuple[f.Term, f.Term]] = []
    for first, second in pairs:
        mine = isinstance(second, f.Variable) and second in addition.variables and second.name not in own
        if mine and isinstance(second, f.Variable) and around.narrower(first, second):
            own[second.name] = first
        else:
            rest.append((first, second))
    claims = [f.Comparison("!=", first, substituted(second, own), deletion.place) for first, second in rest]
    condition = substituted(addition.condition, own)
    meeting = _Meeting(
        tuple(variable for variable in addition.variables if variable.name not in own),
        [f.Know(claim, deletion.place) for claim in claims],
        condition.parts if isinstance(condition, f.And) else (condition,),
    )
    yield from _restricted(deletion, meeting, around)


@dataclass(frozen=True)
class _Meeting:
    """When an addition happens to a deletion's atom: for some of the variables none of `different` holds, and all parts."""

    variables: tuple[f.Variable, ...]
    different: list[f.Know]
    parts: tuple[f.Formula, ...]


def _restricted(
    deletion: ConditionalEffect, meeting: _Meeting, around: ConflictContext
) -> Iterator[ConditionalEffect]:
    own = deletion.condition.parts if isinstance(deletion.condition, f.And) else (deletion.condition,)
    own = own + around.assumed
    meeting = replace(meeting, parts=tuple(part for part in meeting.parts if part not in own))
    if not meeting.variables and any(_denied(part) in own for part in meeting.parts):
        yield deletion  # never both
    elif around.known(meeting.parts):
        guard = disjunction([*meeting.different, *map(negated, meeting.parts)], deletion.place)
        if meeting.variables and not isinstance(guard, f.Truth):
            guard = f.Forall(meeting.variables, guard, deletion.place)
        if guard in own:
            yield deletion
        elif guard != f.Truth(False):
            yield _under(deletion, [guard])
    elif not around.known(deletion.condition):
        around.report(deletion, False)
        yield deletion
    else:
        yield from _by_unknown(deletion, meeting, around)


def _by_unknown(
    deletion: ConditionalEffect, meeting: _Meeting, around: ConflictContext
) -> Iterator[ConditionalEffect]:
    """Where the addition depends on what may be unknown: one copy for each claim that may fail."""
    claims = [part for part in meeting.parts if isinstance(part, f.Know)]
    if meeting.variables or len(claims) < len(meeting.parts):
        around.report(deletion, True)
        return
    if meeting.different:
        yield _under(deletion, [disjunction(meeting.different, deletion.place)])
    same = [negated(each) for each in meeting.different]
    for claim in claims:
        yield _under(deletion, [*same, f.Know(denied(claim.claim), claim.place)])


def _under(piece: ConditionalEffect, parts: Iterable[f.Formula]) -> ConditionalEffect:
    return replace(piece, condition=conjunction([piece.condition, *parts], piece.place))


def _denied(formula: f.Formula) -> f.Formula | None:
    return f.Know(denied(formula.claim)) if isinstance(formula, f.Know) else None
