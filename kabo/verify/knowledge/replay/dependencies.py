"""The atoms and terms that one node of a plan reads, may change, and overwrites regardless of what was known."""

from collections.abc import Iterator
from dataclasses import dataclass

from kabo.language.formulas import Change, Comparison, Literal
from kabo.plan import Node, ValueOf
from kabo.verify.knowledge.ground import Observable, Symbol, is_symbol, read_symbol
from kabo.verify.knowledge.mentions import mentions, reads
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.update_rules import ground
from kabo.verify.knowledge.terms import symbol_of
from kabo.verify.knowledge.updates import unrolled


@dataclass(frozen=True)
class NodeDependencies:
    """The atoms and terms that a node reads, may change (`touched`) and overwrites, each listed once.

    The name of a symbol stands for all its instances.
    """

    read: tuple[Symbol | str, ...] = ()
    touched: tuple[Symbol | str, ...] = ()
    overwritten: tuple[Symbol | str, ...] = ()


def dependencies_of(node: Node, interpreter: Interpreter) -> NodeDependencies:
    """The dependencies of a node, computed once for all nodes with the same action, arguments and observations."""
    key = node.action, tuple(sorted(node.arguments.items(), key=lambda pair: pair[0])), node.on, node.delivers
    if key not in interpreter.dependencies:
        things = [interpreter.read(text) for text in (*([] if node.on is None else [node.on]), *node.delivers)]
        sensed = [symbol for thing in things for symbol in _symbols(thing)]
        if node.action is None:
            interpreter.dependencies[key] = NodeDependencies(tuple(sensed), tuple(sensed))
        else:
            interpreter.dependencies[key] = _of_action(node, interpreter, sensed)
    return interpreter.dependencies[key]  # type: ignore[return-value]


def _of_action(node: Node, interpreter: Interpreter, sensed: list[Symbol]) -> NodeDependencies:
    problem = interpreter.problem
    action, binding = problem.domain.actions[str(node.action)], dict(node.arguments)
    terms = [value.term for value in node.arguments.values() if isinstance(value, ValueOf)]
    run_time = [symbol for symbol in (read_symbol(term, problem) for term in terms) if symbol is not None]
    read = [*sensed, *mentions((action.preconditions, action.sense), problem, binding), *run_time]
    touched = [*sensed, *mentions((action.sense, action.effects), problem, binding)]
    if interpreter.rules.rules:  # rules may find a contradiction in what is written, so they read it
        return NodeDependencies(_once([*read, *touched]), _once(touched))
    for effect in action.effects:
        read.extend(reads(effect, problem, binding))
    return NodeDependencies(_once(read), _once(touched), _once(_overwritten(node, interpreter)))


def _overwritten(node: Node, interpreter: Interpreter) -> Iterator[Symbol]:
    """The atoms and terms that an unconditional `add(Kf, …)` sets."""
    problem, binding = interpreter.problem, dict(node.arguments)
    for effect, more in ground(problem.domain.actions[str(node.action)].effects, problem, binding):
        if not isinstance(effect, Change) or effect.operation != "add" or effect.database != "Kf":
            continue
        for fact in effect.facts:
            for group, inner in unrolled(fact, problem, more):
                for part in group:
                    if isinstance(part, Literal):
                        named = symbol_of(part.atom, problem, inner)
                    elif isinstance(part, Comparison) and part.operator == "=":
                        named = symbol_of(part.left, problem, inner)
                    else:
                        continue
                    if isinstance(named, tuple):
                        yield named


def _once(things: list[Symbol | str] | Iterator[Symbol]) -> tuple[Symbol | str, ...]:
    return tuple(dict.fromkeys(things))


def _symbols(thing: Observable | None) -> tuple[Symbol, ...]:
    if thing is None:
        return ()
    return (thing,) if is_symbol(thing) else tuple(claim[0] for claim in thing)  # type: ignore
