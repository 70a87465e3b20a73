"""Translates PKS actions, with a variant for each function whose value a parameter may have at run time.

In PKS, a parameter ?x with the precondition Kv(?x) may be bound to a constant, or to a function whose value will
be known at run time. A run-time variable of kabo belongs to one function, so each possible function gives one
action.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.expressions import Expression
from kabo.language.names import Names
from kabo.language.pks.dialect import bind
from kabo.language.pks.effects import read_effects
from kabo.language.pks.expressions import Broken, tokens_of, typed_names
from kabo.language.pks.formulas import read_formula
from kabo.language.pks.markup import Element, Markup
from kabo.language.problem import Action, Parameter
from kabo.language.resolver import NameResolver
from kabo.language.tree_algebra import nodes
from kabo.language.types import NUMBERS
from kabo.language.vocabulary import Symbol


def read_action(
    here: NameResolver,
    markup: Markup,
    element: Element,
    name: str,
    statements: Callable[[Element], list[Expression]],
    names: Names,
) -> Iterator[Action]:
    """The action of an element, and its variants with run-time variables.

    Args:
        here: the names of the domain.
        markup: the parsed file.
        element: the element <action>.
        name: the name of the action in the file.
        statements: a function that returns the statements in the text of an element.
        names: the namespace of actions, in which the names of the variants are reserved.
    """
    place = markup.place(element)
    bound = _parameters(here, markup, element)
    inner = here.inside(bound)
    asked = [node for part in element.all("preconds") for node in statements(part)]
    formulas = [read_formula(inner, node) for node in asked]
    whole = conjunction([each for each in formulas if each is not None])
    preconditions = whole.parts if isinstance(whole, f.And) else () if whole == f.Truth(True) else (whole,)
    said = [node for part in element.all("effects") for node in statements(part)]
    effects = tuple(each for node in said for each in read_effects(inner, node))
    parameters = tuple(Parameter(each.name, each.type, None, each.place) for each in bound.values())
    cost = f.Number(1.0)
    action = Action(names.take(name), parameters, preconditions, None, effects, (), cost, place)
    yield action
    for variable, asked_at in _asked_for_values(bound, asked):
        for more, term in _sources(inner, action, variable):
            yield from _variant(inner, action, variable, more, term, names, asked_at)


def _parameters(here: NameResolver, markup: Markup, element: Element) -> dict[str, Symbol]:
    found: dict[str, Symbol] = {}
    for part in element.all("params"):
        try:
            variables = typed_names(tokens_of(markup, part.inside, part.end), ("variable",))
        except Broken as broken:
            hint = f"write ?{broken.token.text}" if broken.token.kind == "name" else None
            message = f'unexpected "{broken.token.text}", expected {broken.expected}'
            here.report(broken.token, message, hint)
            continue
        found |= bind(here.inside(found), variables)
    return found


def _asked_for_values(
    bound: dict[str, Symbol], asked: Iterable[Expression]
) -> Iterator[tuple[Symbol, Expression]]:
    """The parameters of which a precondition is Kv(?x)."""
    waiting = list(asked)[::-1]
    while waiting:
        node = waiting.pop()
        if node.kind in ("and", "group"):
            waiting.extend(reversed(node.parts))
        elif node.kind == "call" and node.text == "Kv" and len(node.parts) == 1 and node.parts[0].text in bound:
            yield bound[node.parts[0].text], node


def _sources(
    here: NameResolver, action: Action, variable: Symbol
) -> Iterator[tuple[tuple[Parameter, ...], f.Application]]:
    """The terms whose value the variable may be, with the parameters that they need beside the action's own.

    What the action compares the variable with; if it compares it with nothing, every function that fits.
    """
    own = {parameter.name for parameter in action.parameters} - {variable.name}
    compared = list(dict.fromkeys(_compared(action, variable.variable)))
    usable = [term for term in compared if all(_is_fixed(argument, own) for argument in term.arguments)]
    yield from (((), term) for term in usable)
    for function in [] if compared else here.vocabulary.all_of("function"):
        if function.kind == NUMBERS or not here.vocabulary.types.fits(function.kind, variable.kind):
            continue
        more: list[Parameter] = []
        for each in function.arguments:
            kind = here.vocabulary.types.common(each)
            taken = [parameter.name for parameter in (*action.parameters, *more)]
            more.append(Parameter(here.vocabulary.names.free(kind, taken), kind, None, variable.place))
        arguments = tuple(f.Variable(each.name, each.type, each.place) for each in more)
        yield tuple(more), f.Application(function.name, arguments, variable.place)


def _compared(action: Action, variable: f.Variable) -> Iterator[f.Application]:
    for node in nodes((action.preconditions, action.effects)):
        if isinstance(node, f.Comparison) and node.operator == "=":
            for one, other in ((node.left, node.right), (node.right, node.left)):
                if one == variable and isinstance(other, f.Application):
                    yield other


def _is_fixed(term: f.Term, parameters: set[str]) -> bool:
    return isinstance(term, f.Constant) or (isinstance(term, f.Variable) and term.name in parameters)


def _variant(
    here: NameResolver,
    action: Action,
    variable: Symbol,
    more: tuple[Parameter, ...],
    term: f.Application,
    names: Names,
    asked_at: Expression,
) -> Iterator[Action]:
    """The action with a run-time variable in the place of a parameter."""
    own = variable.variable
    if _inside_an_atom(action, own.name):
        message = f'"{asked_at.parts[0].text}" cannot stand for the value of "{term.function}" here'
        hint = "it is an argument of an atom that an effect changes; only objects are tried"
        here.report(asked_at, message, hint, warning=True)
        return
    at_run_time = Parameter(own.name, own.type, term, own.place)
    others = tuple(parameter for parameter in action.parameters if parameter.name != own.name)
    name = names.take(f"{names.originals[action.name]}_{term.function}")
    yield replace(action, name=name, parameters=(*more, *others, at_run_time))


def _inside_an_atom(action: Action, variable: str) -> bool:
    """Whether an update has the variable as an argument of the atom or term that it changes."""
    for node in nodes(action.effects):
        if not isinstance(node, f.Change):
            continue
        for fact in nodes(node.facts):
            if isinstance(fact, f.Atom | f.Application) and any(
                isinstance(term, f.Variable) and term.name == variable for term in nodes(fact.arguments)
            ):
                return True
    return False
