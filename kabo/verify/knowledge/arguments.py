"""Faults of nodes that do not depend on knowledge: unknown names, wrong arguments, wrong types."""

from collections.abc import Iterable, Iterator

from kabo.errors import did_you_mean
from kabo.language.formulas import Application
from kabo.language.problem import Action, Problem
from kabo.plan import Node, Plan, ValueOf
from kabo.verify.knowledge.ground import read_conjunction, read_symbol, text_of
from kabo.verify.knowledge.terms import symbol_of
from kabo.verify.report import Finding


def check_calls(plan: Plan, order: Iterable[str], problem: Problem) -> list[Finding]:
    """The findings about the calls of all nodes in `order`; calls that are equal are checked only once."""
    found: dict[object, tuple[str, ...]] = {}
    result: list[Finding] = []
    for name in order:
        node = plan.nodes[name]
        key = node.action, tuple(sorted(node.arguments.items(), key=lambda pair: pair[0])), node.on, node.delivers
        if key not in found:
            found[key] = tuple(finding.message for finding in check_call(name, node, problem))
        result.extend(Finding(name, message) for message in found[key])
    return result


def check_call(name: str, node: Node, problem: Problem) -> Iterator[Finding]:
    """The findings about a node's action, its arguments, and what it branches on."""
    if node.action is not None:
        action = problem.domain.actions.get(node.action)
        if action is None:
            hint = did_you_mean(node.action, problem.domain.actions)
            yield Finding(name, f'unknown action "{node.action}"' + (f"; {hint}" if hint else ""))
            return
        yield from _check_arguments(name, node, action, problem)
    for text in (*([] if node.on is None else [node.on]), *node.delivers):
        if read_symbol(text, problem) is None and read_conjunction(text, problem) is None:
            yield Finding(name, f'"{text}" is no ground atom or term of the domain')


def _check_arguments(name: str, node: Node, action: Action, problem: Problem) -> Iterator[Finding]:
    declared = {parameter.name: parameter for parameter in action.parameters}
    for extra in sorted(node.arguments.keys() - declared.keys()):
        yield Finding(name, f'action "{action.name}" has no parameter "{extra}"')
    for parameter in action.parameters:
        if parameter.name not in node.arguments:
            yield Finding(name, f'argument "{parameter.name}" of action "{action.name}" is missing')
            continue
        value = node.arguments[parameter.name]
        if parameter.value_of is not None:
            expected = _term_text(parameter.value_of, node, problem)
            if not isinstance(value, ValueOf) or value.term != expected:
                yield Finding(name, f'argument "{parameter.name}" must be the value of {expected} at run time')
        elif not isinstance(value, str) or value not in problem.of_type(parameter.type):
            shown = value.term if isinstance(value, ValueOf) else value
            yield Finding(name, f'argument "{parameter.name}": {shown} is no {parameter.type}')


def _term_text(term: Application, node: Node, problem: Problem) -> str | None:
    if any(
        getattr(argument, "name", None) not in {*node.arguments, *problem.objects} for argument in term.arguments
    ):
        return None
    symbol = symbol_of(term, problem, dict(node.arguments))
    return text_of(symbol) if isinstance(symbol, tuple) else None
