"""Static facts as tables: the objects that one argument of a static literal can be when its others are given.

Looking parameters up in these tables avoids grounding actions for, say, all pairs of cells that are not adjacent.
"""

from collections.abc import Iterator, Mapping

from kabo.knowledge.binding import Binding
from kabo.knowledge.facts import AtomBits
from kabo.knowledge.grounding.compiler import Compiler
from kabo.language.formulas import Constant, Formula, Know, Literal, Variable

Arguments = tuple[str, ...]


class StaticFacts:
    """The static atoms that are known to hold, in tables indexed by all arguments but those of one variable."""

    def __init__(self, compiler: Compiler) -> None:
        self._compiler = compiler
        self._rows: dict[str, list[Arguments]] = {}
        for name, arguments, group in compiler.statics.named(""):
            if isinstance(group, AtomBits) and group.true & compiler.static:
                self._rows.setdefault(name, []).append(arguments)
        self._tables: dict[tuple[str, tuple[bool, ...]], dict[Arguments, dict[str, None]]] = {}

    def join(self, formula: Formula) -> Literal | None:
        """The literal of a formula K(p(…)) whose objects can be looked up in the tables; else None.

        The predicate p must be static, and its arguments variables or constants.
        """
        if not isinstance(formula, Know) or not isinstance(formula.claim, Literal) or not formula.claim.positive:
            return None
        atom = formula.claim.atom
        plain = all(isinstance(argument, Variable | Constant) for argument in atom.arguments)
        return formula.claim if plain and atom.arguments and self._compiler.is_static(atom.predicate) else None

    def values(self, literal: Literal, variable: str, binding: Binding) -> Mapping[str, None]:
        """The objects for which, as values of `variable`, the literal holds; its other variables must be bound."""
        places, given = [], []
        for argument in literal.atom.arguments:
            is_open = isinstance(argument, Variable) and argument.name == variable
            places.append(is_open)
            if not is_open:
                given.append(binding[argument.name] if isinstance(argument, Variable) else _name(argument))
        key = literal.atom.predicate, tuple(places)
        table = self._tables.get(key)
        if table is None:
            table = self._tables[key] = self._table(*key)
        return table.get(tuple(given), {})

    def _table(self, name: str, places: tuple[bool, ...]) -> dict[Arguments, dict[str, None]]:
        table: dict[Arguments, dict[str, None]] = {}
        for row in self._rows.get(name, ()):
            values = {value for value, is_open in zip(row, places, strict=True) if is_open}
            if len(values) == 1:
                given = tuple(value for value, is_open in zip(row, places, strict=True) if not is_open)
                table.setdefault(given, {})[values.pop()] = None
        return table


def variables_of(literal: Literal) -> Iterator[str]:
    """The names of the literal's variables."""
    for argument in literal.atom.arguments:
        if isinstance(argument, Variable):
            yield argument.name


def _name(argument: object) -> str:
    assert isinstance(argument, Constant)
    return argument.name
