"""Finds constructs of the language that kabo's knowledge cannot represent if they concern unknown facts.

Some constructs cannot be represented whenever an atom or term in them is unknown: sums of unknown numbers, sensed
numbers, copies of unknown values, terms inside terms. Other gaps are found on bits [gaps.py]; this module finds
their places in the files.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass

from kabo.knowledge.binding import Binding, plain
from kabo.knowledge.facts import NumberBits
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.grounding.problem import conjuncts
from kabo.knowledge.grounding.schemas import ActionInstance
from kabo.knowledge.grounding.symbols import pieces_of
from kabo.knowledge.grounding.temporal import PREFIX
from kabo.knowledge.queries import bits_of
from kabo.knowledge.runtime import without_runtime_variables
from kabo.language.formulas import (
    Application,
    Arithmetic,
    Atom,
    Change,
    Comparison,
    Constant,
    Exists,
    External,
    Formula,
    Know,
    KnowValue,
    Or,
    Place,
    Temporal,
    Variable,
    WorldEffect,
)
from kabo.language.problem import Action


@dataclass(frozen=True)
class Construct:
    """A construct about unknown atoms or terms: its place in the files, and its description."""

    place: Place | None
    text: str


class Constructs:
    """The constructs of one problem that mention relevant atoms or terms that may be unknown."""

    def __init__(self, compiler: Compiler, open_: int) -> None:
        self.compiler, self.problem = compiler, compiler.problem
        groups = {group.whether: group for group in compiler.fluents}
        keys = {name: compiler.fluents.key_of(groups[name]) for name in bits_of(open_)}
        self._symbol = {name: key[0].removeprefix(PREFIX) for name, key in keys.items()}
        self._arguments = {name: key[1] for name, key in keys.items()}
        self.symbols = {key[0] for key in keys.values()}
        self.numbers = {keys[name][0] for name in keys if isinstance(groups[name], NumberBits)}

    # ------------------------------------------------------------------------------------------------ by form
    def of(self, actions: Iterable[str]) -> Iterator[Construct]:
        """The constructs in the goal and in these actions that kabo's knowledge cannot represent."""
        names = set(actions)
        for declared in self.problem.domain.actions.values():
            if declared.name in names:
                yield from self._of_action(declared)
        for formula in self.problem.goal:
            yield from self._inside(formula, "the goal", ())
            for part in _parts(formula):
                if isinstance(part, Temporal) and part.kind == "initially" and self._open_copies(part):
                    yield Construct(part.place or formula.place, "the goal asks what was so at the start")

    def _open_copies(self, formula: Temporal) -> bool:
        return any(
            PREFIX + name in self.symbols or name in self.symbols
            for part in _parts(formula.body)
            for name in _names(part)
        )

    def _of_action(self, declared: Action) -> Iterator[Construct]:
        action = without_runtime_variables(declared)
        where = f'action "{declared.name}"'
        known = tuple(_known_terms(action.preconditions))
        for sensed in action.sense:
            if isinstance(sensed, Application) and sensed.function in self.numbers:
                yield Construct(
                    sensed.place, f"{where} senses a number, {sensed.function}, of which no values are listed"
                )
            yield from self._inside(sensed, where, known)
        for formula in action.preconditions:
            yield from self._inside(formula, where, known)
        for effect in action.effects:
            yield from self._inside(effect, where, known)
        for piece in pieces_of(action.effects):
            if isinstance(piece, Change):
                yield from self._of_change(piece, where, known)

    def _of_change(self, piece: Change, where: str, known: tuple[Application, ...]) -> Iterator[Construct]:
        for part in _parts(piece.facts):
            if piece.database == "Kv" and isinstance(part, Application) and part.function in self.numbers:
                yield Construct(
                    piece.place, f"{where} senses a number, {part.function}, of which no values are listed"
                )
            right = plain(part.right) if isinstance(part, Comparison) else None
            if isinstance(right, Application | External) and self._is_open(right, known):
                yield Construct(piece.place, f"{where} copies a value that may be unknown")

    def _inside(self, tree: object, where: str, known: tuple[Application, ...]) -> Iterator[Construct]:
        """Sums, calls and terms inside terms, and comparisons of two terms."""
        for part in _parts(tree):
            place = getattr(part, "place", None)
            if isinstance(part, Arithmetic) and self._is_beyond(part, known):
                yield Construct(place, f"{where} computes with a number that may be unknown")
            elif isinstance(part, External) and self._any_open(part.arguments, known):
                yield Construct(place, f"{where} asks a procedure about a value that may be unknown")
            elif isinstance(part, Application | Atom) and self._any_open(part.arguments, known):
                yield Construct(place, f"{where} names something by a value that may be unknown")
            elif isinstance(part, Comparison) and not isinstance(tree, Change):
                sides = plain(part.left), plain(part.right)
                if all(self._is_open(side, known) for side in sides):
                    yield Construct(place, f"{where} compares two values that may be unknown")

    def _is_beyond(self, sum_: Arithmetic, known: tuple[Application, ...]) -> bool:
        """Whether the value of arithmetic on unknown numbers may be known all the same, as of x - x, but not of x + 1."""
        open_ = [self._is_open(plain(side), known) for side in (sum_.left, sum_.right)]
        return all(open_) or (sum_.operator in "*/" and any(open_))

    def _any_open(self, terms: Iterable[object], known: tuple[Application, ...]) -> bool:
        return any(self._is_open(plain(term), known) for term in terms)  # type: ignore[arg-type]

    def _is_open(self, term: object, known: tuple[Application, ...]) -> bool:
        """Whether a term, or what it is made of, may be unknown."""
        if isinstance(term, Arithmetic):
            return self._any_open((term.left, term.right), known)
        if isinstance(term, External):
            return self._any_open(term.arguments, known)
        if not isinstance(term, Application):
            return False
        own = term.function in self.symbols and (term not in known or term.function in self.numbers)
        return own or self._any_open(term.arguments, known)

    # ------------------------------------------------------------------------------------------------- by place
    def change(self, action: str, names: int, *, together: bool = False) -> Place | None:
        """The place where an action changes one of the groups, or with `together` adds an entry about one.

        It is the place of the action itself if there is no such change.
        """
        wanted = {self._symbol[name] for name in bits_of(names) if name in self._symbol}
        declared = self.problem.domain.actions[action]
        for piece in pieces_of(declared.effects):
            facts = piece.outcomes if isinstance(piece, WorldEffect) else piece.facts
            several = isinstance(piece, Change) and piece.database not in ("Kf", "Kw", "Kv")
            if several == together and wanted & {name for part in _parts(facts) for name in _names(part)}:
                return piece.place
        return declared.place

    def together(self, names: int) -> Place | None:
        """The place of an initial Kx, Kor or LCW entry about a group, else about a group's symbol; else None."""
        keys = {(self._symbol[name], self._arguments[name]) for name in bits_of(names) if name in self._symbol}
        wanted = {symbol for symbol, _ in keys}
        found: Place | None = None
        for piece in pieces_of(self.problem.initial):
            if isinstance(piece, Change) and piece.database in ("Kx", "Kor", "LCW"):
                parts = list(_parts(piece.facts))
                exact = any(_key(part) in keys for part in parts)
                if exact:
                    return piece.place
                if found is None and wanted & {name for part in parts for name in _names(part)}:
                    found = piece.place
        return found

    # ---------------------------------------------------------------------------------------------- disjunctions
    def choices(self, instance: ActionInstance) -> Iterator[tuple[Place | None, Sequence[int]]]:
        """The place of each disjunction in an action's preconditions, and the bits that each part reads."""
        declared = self.problem.domain.actions[instance.name]
        binding = {name: str(value) for name, value in instance.arguments.items()}
        return self._choices(declared.preconditions, binding)

    def goal_choices(self) -> Iterator[tuple[Place | None, Sequence[int]]]:
        """The place of each disjunction in the goal, and the bits that each part reads."""
        return self._choices(self.problem.goal, {}) if self.problem.domain.worldly else iter(())

    def _choices(
        self, formulas: tuple[Formula, ...], binding: Binding
    ) -> Iterator[tuple[Place | None, Sequence[int]]]:
        for formula, bound in conjuncts(self.compiler, formulas, binding):
            if isinstance(formula, Or):
                cases = [(part, bound) for part in formula.parts]
            elif isinstance(formula, Exists):
                cases = [(formula.body, inner) for inner in self.compiler.instances(formula.variables, bound)]
            else:
                continue
            yield formula.place, [self.compiler.query(part, inner).reads for part, inner in cases]
            for part, inner in cases:
                yield from self._choices((part,), inner)


def _known_terms(preconditions: Iterable[Formula]) -> Iterator[Application]:
    """The terms whose value is known whenever the preconditions hold."""
    for formula in preconditions:
        if isinstance(formula, KnowValue):
            yield formula.term
        claim = formula.claim if isinstance(formula, Know) else None
        if not isinstance(claim, Comparison) or claim.operator != "=":
            continue
        if isinstance(claim.left, Application) and isinstance(claim.right, Variable | Constant):
            yield claim.left


def _parts(tree: object) -> Iterator[object]:
    """A formula, a fact or an effect, and everything inside it."""
    if isinstance(tree, tuple):
        for part in tree:
            yield from _parts(part)
    elif is_dataclass(tree) and not isinstance(tree, Place):
        yield tree
        for item in fields(tree):
            if item.name != "place":
                yield from _parts(getattr(tree, item.name))


def _names(part: object) -> tuple[str, ...]:
    if isinstance(part, Atom):
        return (part.predicate,)
    return (part.function,) if isinstance(part, Application) else ()


def _key(part: object) -> tuple[str, tuple[str, ...]] | None:
    """The symbol and arguments of a ground atom or term; None for anything else."""
    if isinstance(part, Atom | Application) and all(isinstance(each, Constant) for each in part.arguments):
        return _names(part)[0], tuple(each.name for each in part.arguments if isinstance(each, Constant))
    return None
