"""Classical problems as PDDL, so that planners of others solve the very same instances.

What is written: positive and negative literals, `f(x) = v`, `!=` (a relation between objects, as plain STRIPS has no
equality), unconditional effects, and effects for the one object that a function's value is. A function is a predicate
with its value as the last argument; an action that gives it a new value gets a parameter for the old one, as the
usual STRIPS form of such problems has. Whatever needs knowledge (sensing, Kx, know-whether goals) is refused: there
is no contingent planner that installs from the package index.
"""

from dataclasses import dataclass, field

from kabo.language import formulas as f
from kabo.language.problem import Action, Problem

DIFFERENT = "different"


class NotClassicalError(ValueError):
    """The problem cannot be written as classical PDDL; says why."""


def to_pddl(problem: Problem) -> tuple[str, str]:
    """The texts of a domain and a problem file.

    Raises:
        NotClassicalError: the problem needs what classical PDDL does not have.
    """
    domain = problem.domain
    types = " ".join(f"{_type(kind)} - {_type(parent)}" for kind, parent in domain.types.items())
    predicates = [_signature(name, kinds) for name, kinds in domain.predicates.items()]
    for function in domain.functions.values():
        if function.value_type is None:
            raise NotClassicalError(f"the values of {function.name} are no objects")
        predicates.append(_signature(function.name, (*function.arguments, function.value_type)))
    actions = "\n".join(_Writer(problem, action).text() for action in domain.actions.values())
    predicates.append(f"({DIFFERENT} ?x - object ?y - object)")
    domain_text = (
        f"(define (domain {domain.name})\n(:requirements :strips :typing)\n(:types {types})\n"
        f"(:predicates {' '.join(predicates)})\n{actions})\n"
    )
    objects = " ".join(f"{name} - {_type(kind)}" for name, kind in problem.objects.items())
    facts = [text for effect in problem.initial for text in _facts(effect)]
    facts += [f"({DIFFERENT} {x} {y})" for x in problem.objects for y in problem.objects if x != y]
    goal = " ".join(_condition(formula) for formula in problem.goal)
    problem_text = (
        f"(define (problem {problem.name})\n(:domain {domain.name})\n(:objects {objects})\n"
        f"(:init {' '.join(facts)})\n(:goal (and {goal})))\n"
    )
    return domain_text, problem_text


def _type(kind: str | None) -> str:
    return "object" if kind is None else f"a_{kind}"


def _signature(name: str, kinds: tuple[str, ...]) -> str:
    return f"({name} {' '.join(f'?x{k} - {_type(kind)}' for k, kind in enumerate(kinds))})"


def _term(term: f.Term) -> str:
    match term:
        case f.Variable(name=name):
            return f"?{name}"
        case f.Constant(name=name):
            return name
    raise NotClassicalError(f"a term like {term}")


def _atom(name: str, terms: tuple[f.Term, ...]) -> str:
    return f"({' '.join([name, *map(_term, terms)])})"


def _claim(claim: f.Claim) -> str:
    match claim:
        case f.Literal(atom=atom, positive=positive):
            text = _atom(atom.predicate, atom.arguments)
            return text if positive else f"(not {text})"
        case f.Comparison(operator="=", left=f.Application() as term, right=value):
            return _atom(term.function, (*term.arguments, value))
        case f.Comparison(operator="!=", left=left, right=right):
            return _atom(DIFFERENT, (left, right))
    raise NotClassicalError(f"a claim like {claim}")


def _condition(formula: f.Formula) -> str:
    match formula:
        case f.Know(claim=claim):
            return _claim(claim)
        case f.And(parts=parts):
            return f"(and {' '.join(map(_condition, parts))})"
    raise NotClassicalError(f"a condition like {type(formula).__name__}")


def _facts(effect: f.Effect) -> list[str]:
    match effect:
        case f.Change(operation="add", database="Kf", facts=facts):
            texts = [_claim(fact) for fact in facts if isinstance(fact, f.Literal | f.Comparison)]
            return [text for text in texts if not text.startswith("(not ")]
    raise NotClassicalError(f"initial knowledge like {type(effect).__name__}")


@dataclass
class _Writer:
    """One action: its effects tell which old values it needs as parameters."""

    problem: Problem
    action: Action
    old: dict[str, str] = field(default_factory=dict)  # function term as text: the variable of its old value
    extra: list[str] = field(default_factory=list)
    needed: list[str] = field(default_factory=list)
    effects: list[str] = field(default_factory=list)

    def text(self) -> str:
        """The action in PDDL."""
        if self.action.sense or any(parameter.value_of for parameter in self.action.parameters):
            raise NotClassicalError(f"{self.action.name} senses, or uses what is known at run time only")
        for effect in sorted(self.action.effects, key=lambda each: isinstance(each, f.Change)):
            self._effect(effect)
        own = " ".join(f"?{parameter.name} - {_type(parameter.type)}" for parameter in self.action.parameters)
        conditions = " ".join([*map(_condition, self.action.preconditions), *self.needed])
        return (
            f"(:action {self.action.name}\n :parameters ({' '.join([own, *self.extra])})\n"
            f" :precondition (and {conditions})\n :effect (and {' '.join(self.effects)}))"
        )

    def _effect(self, effect: f.Effect) -> None:
        match effect:
            case f.ForEach(
                variables=(variable,),
                effects=(
                    f.Conditional(
                        condition=f.Know(
                            claim=f.Comparison(operator="=", left=f.Application() as term, right=value)
                        ),
                        updates=updates,
                    ),
                ),
            ) if isinstance(value, f.Variable) and value.name == variable.name:
                self._take(term, variable)
                for update in updates:
                    self._effect(update)
            case f.Change(operation=operation, database="Kf", facts=facts):
                for fact in facts:
                    self._change(operation, fact)
            case _:
                raise NotClassicalError(f"an effect like {type(effect).__name__}")

    def _take(self, term: f.Application, variable: f.Variable) -> None:
        """Makes the old value of a term a parameter."""
        self.old[_atom(term.function, term.arguments)] = f"?{variable.name}"
        self.extra.append(f"?{variable.name} - {_type(variable.type)}")
        self.needed.append(_atom(term.function, (*term.arguments, variable)))

    def _change(self, operation: str, fact: f.Fact) -> None:
        if isinstance(fact, f.Comparison) and isinstance(fact.left, f.Application) and operation == "add":
            term = fact.left
            if _atom(term.function, term.arguments) not in self.old:
                kind = self.problem.domain.functions[term.function].value_type
                self._take(term, f.Variable(f"old_{len(self.old)}", str(kind)))
            old = self.old[_atom(term.function, term.arguments)]
            head = " ".join([term.function, *map(_term, term.arguments)])
            self.effects += [f"(not ({head} {old}))", f"({head} {_term(fact.right)})"]
        elif isinstance(fact, f.Literal):
            text = _claim(fact)
            self.effects.append(text if operation == "add" else f"(not {text})")
        else:
            raise NotClassicalError(f"a change like {operation} {fact}")
