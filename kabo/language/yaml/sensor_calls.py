"""Ground atoms, terms and measurements in the keys of sensor files, such as `empty_bottle(o) when weight(o) < 0.25`.

Names that are no objects are variables: each stands for all objects of the type that the predicate declares there.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from kabo.displays import counted
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.names import NAME
from kabo.language.problem import Problem
from kabo.language.yaml.documents import Scalar

_CALL = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(?:\(([^()]*)\))?\s*")
_MOST_INSTANCES = 100_000


@dataclass(frozen=True)
class Call:
    """A name with arguments in a key, each with its place."""

    name: str
    arguments: tuple[str, ...]
    place: Place
    places: tuple[Place, ...]


def read_call(scalar: Scalar, begin: int, end: int, findings: Findings) -> Call | None:
    """The call in a part of a key's text; None if it is none, which is reported."""
    text = scalar.text[begin:end]
    found = _CALL.fullmatch(text)
    if found is None or (found[2] is not None and not all(word.strip() for word in found[2].split(","))):
        hint = "write a name with its arguments: empty_bottle(o)"
        findings.add(_place(scalar, begin, end), f'"{text.strip()[:60]}" is no call', hint)
        return None
    place = _place(scalar, begin + found.start(1), begin + found.end(1))
    words, places = [], []
    at = 0 if found[2] is None else begin + found.start(2)
    for word in [] if found[2] is None or not found[2].strip() else found[2].split(","):
        first = at + len(word) - len(word.lstrip())
        words.append(word.strip())
        places.append(_place(scalar, first, first + len(word.strip())))
        at += len(word) + 1
    return Call(found[1], tuple(words), place, tuple(places))


def _place(scalar: Scalar, begin: int, end: int) -> Place:
    offset = scalar.start + (1 if scalar.style in ("'", '"') else 0)
    return scalar.source.place(offset + begin, offset + max(end, begin + 1))


@dataclass(frozen=True)
class Asked:
    """A declared predicate or function with arguments; `outcomes` is None if its value is a number."""

    call: Call
    types: tuple[str, ...]
    outcomes: tuple[str, ...] | None
    is_predicate: bool


def read_asked(call: Call, problem: Problem, findings: Findings) -> Asked | None:
    """What a formula or term is by its declaration; None if there is none, which is reported."""
    domain = problem.domain
    if call.name in domain.predicates:
        types, outcomes, predicate = domain.predicates[call.name], ("false", "true"), True
    elif call.name in domain.functions:
        types, predicate = domain.functions[call.name].arguments, False
        outcomes = problem.values_of(call.name)  # type: ignore[assignment]
    else:
        hint = findings.near(call.name, [*domain.predicates, *domain.functions])
        findings.add(call.place, f'the domain has no predicate or function "{call.name}"', hint)
        return None
    if len(types) != len(call.arguments):
        hint = f"it is {call.name}({', '.join(types)})"
        findings.add(
            call.place, f"{call.name} has {counted(len(types), 'argument')}, not {len(call.arguments)}", hint
        )
        return None
    return Asked(call, tuple(types), outcomes, predicate)


def variables_of(asked: Asked, problem: Problem, findings: Findings, used: set[str]) -> dict[str, str] | None:
    """The variables of a call with their types; None after an error: an object of another type, or an unused name."""
    found: dict[str, str] = {}
    right = True
    for word, kind, place in zip(asked.call.arguments, asked.types, asked.call.places, strict=True):
        if word in problem.objects:
            if not problem.domain.is_a(problem.objects[word], kind):
                text = f'"{word}" is a {problem.objects[word]}, and {asked.call.name} is about a {kind}'
                findings.add(place, text)
                right = False
        elif word[-1].isdigit() or not NAME.fullmatch(word):  # so that no mistyped object is a variable
            text = f'there is no {kind} "{word}"; names of variables end with a letter'
            findings.add(place, text, findings.near(word, problem.of_type(kind)))
            right = False
        elif used and word not in used:
            text = f'"{word}" is no object, and no variable: the measurement does not use it'
            findings.add(place, text, findings.near(word, problem.of_type(kind)))
            right = False
        elif word in found:
            findings.add(place, f'the variable "{word}" stands here twice', "give each place a name of its own")
            right = False
        else:
            found[word] = kind
    return found if right else None


def instances(
    asked: Asked, variables: Mapping[str, str], problem: Problem
) -> Iterator[tuple[str, dict[str, str]]]:
    """The ground atom or term for all objects that the variables stand for, with these objects."""
    choices = [problem.of_type(kind) for kind in variables.values()]
    for number, chosen in enumerate(product(*choices)):
        if number >= _MOST_INSTANCES:
            return
        values = dict(zip(variables, chosen, strict=True))
        words = [values.get(word, word) for word in asked.call.arguments]
        yield spelt(asked.call.name, words), values


def spelt(name: str, words: list[str]) -> str:
    """A ground atom or term as plans spell it."""
    return f"{name}({', '.join(words)})" if words else name


def read_things(
    measure: Call | None, values: Mapping[str, str], problem: Problem, findings: Findings, kind: str
) -> tuple[str, ...] | None:
    """What a measurement is of, with the values of variables; None if the scene has no such thing, which is reported."""
    if measure is None:
        return ()
    bodies = {} if problem.scene is None else problem.scene.bodies
    robots = {} if problem.scene is None else problem.scene.robots
    moving = [name for name, body in bodies.items() if body.movable]
    known = moving if kind == "weight" else [*bodies, *robots]
    things = []
    for word, place in zip(measure.arguments, measure.places, strict=True):
        thing = values.get(word, word)
        robot, dot, _ = thing.partition(".")
        if thing not in known and not (kind == "contact" and dot and robot in robots):
            told = f'"{thing}"' if thing == word else f'"{thing}", which "{word}" may be'
            what = "body that moves" if kind == "weight" else "body or robot"
            findings.add(place, f"the scene has no {what} {told}", findings.near(thing, known))
            return None
        things.append(thing)
    return tuple(things)
