"""Finds the actions and update rules that mention a symbol, and those that never apply because of static facts."""

from collections.abc import Iterable, Iterator
from itertools import islice

from kabo.knowledge.grounding.problem import Grounding
from kabo.knowledge.grounding.schemas import variables_in
from kabo.knowledge.grounding.symbols import pieces_of
from kabo.knowledge.queries import FALSE
from kabo.knowledge.runtime import without_runtime_variables
from kabo.language import spell_bound
from kabo.language.formulas import (
    And,
    Application,
    Atom,
    Change,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Formula,
    Literal,
    TermFact,
    Variable,
)
from kabo.language.problem import Action
from kabo.planner.proofs.static_false import why_false
from kabo.planner.proofs.wording import Meaning, listed, where

MAX_INSTANCES = 100_000  # instances of a precondition that are checked

Spoken = tuple[str, str]  # a symbol, and the role of what is said of it


class Mentions:
    """An index of the action schemas and update rules of a problem by the symbols they add knowledge about."""

    def __init__(self, whole: Grounding) -> None:
        self.whole = whole
        domain = whole.compiler.problem.domain
        present = {action.name for action in whole.actions}
        self.without_instance = {
            name: self._without_instance(action) for name, action in domain.actions.items() if name not in present
        }
        self._actions = {
            name: {*_spoken(action.effects), *_sensed(action.sense)} for name, action in domain.actions.items()
        }
        self._rules = [
            (number, effect, set(_spoken([effect]))) for number, effect in enumerate(domain.update_rules, start=1)
        ]

    def why_no_achiever(self, meaning: Meaning) -> str:
        """The reason why no action or rule achieves a fact, as a clause that ends a sentence."""
        says = [name for name, spoken in self._actions.items() if _speaks(spoken, meaning)]
        sentences = [
            f"{name} has no instance ({self.without_instance[name]})"
            for name in says
            if name in self.without_instance
        ]
        idle = [name for name in says if name not in self.without_instance]
        if idle:
            sentences.append(f"what never changes rules out every instance of {' or '.join(idle)} that would tell")
        for number, effect, spoken in self._rules:
            if _speaks(spoken, meaning):
                asked = condition_of(effect)
                why = None if asked is None else self.never(asked)
                sentences.append(f"{rule_name(effect, number)} never infers it" + (f" ({why})" if why else ""))
        if sentences:
            return f"and {' and '.join(sentences)}"
        if meaning.role in ("whether", "known", "number"):
            return "and no action adds or senses it"
        return "no action adds or senses it, and no update rule infers it"

    def never(self, formula: Formula) -> str | None:
        """The reason why static facts make a condition false for all objects; None if they do not do so."""
        compiler = self.whole.compiler
        for part in formula.parts if isinstance(formula, And) else ():
            why = self.never(part)
            if why is not None:
                return why
        variables = tuple(_variables(formula))
        for binding in islice(compiler.instances(variables, {}), MAX_INSTANCES):
            if compiler.query(formula, binding) != FALSE:
                return None
        if not variables:
            return " ".join(why_false(compiler, formula, {})).rstrip(".")
        return f"{spell_bound(formula, {})} holds for no objects, and nothing changes that"

    def _without_instance(self, schema: Action) -> str:
        compiler = self.whole.compiler
        for parameter in schema.parameters:
            if parameter.value_of is None and not compiler.of_type(parameter.type):
                return f"there is no object of type {parameter.type}"
        for formula in without_runtime_variables(schema).preconditions:
            why = self.never(formula)
            if why is not None:
                return why
        settled = [spell_bound(formula, {}) for formula in schema.preconditions if self._is_settled(formula)]
        return f"no objects fulfil {listed(settled, 'and')} together, and nothing changes that"

    def _is_settled(self, formula: Formula) -> bool:
        """Whether a precondition depends on static facts only."""
        instances = self.whole.compiler.instances(tuple(_variables(formula)), {})
        return all(self.whole.compiler.query(formula, binding).reads == 0 for binding in islice(instances, 1))


def rule_name(effect: Effect, number: int) -> str:
    """The name of an update rule in messages, which includes its place in the file."""
    return f"update rule {number}" + ("" if effect.place is None else f" ({where(effect.place)})")


def condition_of(effect: Effect) -> Formula | None:
    """The condition of an update rule; None if the rule has no condition or several conditions."""
    while isinstance(effect, ForEach) and len(effect.effects) == 1:
        effect = effect.effects[0]
    return effect.condition if isinstance(effect, Conditional) else None


def _speaks(spoken: Iterable[Spoken], meaning: Meaning) -> bool:
    wanted = {"whether": ("true", "false", "equal", "whether"), "known": ("equal", "whether")}
    roles = (*wanted.get(meaning.role, (meaning.role,)), *(("whether",) if meaning.role != "unequal" else ()))
    return any((meaning.symbol, role) in spoken for role in (*roles, "any"))


def _sensed(sense: Iterable[Atom | Application]) -> Iterator[Spoken]:
    for thing in sense:
        yield thing.predicate if isinstance(thing, Atom) else thing.function, "whether"


def _spoken(effects: Iterable[Effect]) -> Iterator[Spoken]:
    """The symbols, each with its role, that effects may add knowledge about."""
    for piece in pieces_of(effects):
        if not isinstance(piece, Change):
            for claim in piece.outcomes:
                yield from _facts(claim, "")
        elif piece.operation == "add":
            role = {"Kf": "", "Kw": "whether", "Kv": "whether"}.get(piece.database, "any")
            for fact in piece.facts:
                yield from _facts(fact, role)


def _facts(fact: Fact, role: str) -> Iterator[Spoken]:
    match fact:
        case Literal(atom=atom, positive=positive):
            yield atom.predicate, role or ("true" if positive else "false")
        case Comparison(operator=sign):
            for side in (fact.left, fact.right):
                if isinstance(side, Application):
                    yield side.function, role or ("equal" if sign == "=" else "unequal")
                    yield side.function, role or "number"
        case TermFact(term=term):
            yield term.function, role
        case FactAll(parts=parts):
            for part in parts:
                yield from _facts(part, role)
        case FactForall(body=body) | ExactlyOne(body=body):
            yield from _facts(body, role)


def _variables(formula: Formula) -> Iterator[Variable]:
    """The variables of a formula, each once."""
    found: dict[str, Variable] = {}
    for variable in variables_in(formula):
        found.setdefault(variable.name, variable)
    yield from found.values()
