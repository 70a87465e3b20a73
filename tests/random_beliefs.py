"""Small random contingent problems about the world, as PDDL text and as plain data for `oracles_beliefs.py`.

Seeded and drawn in a fixed order, so that a number names a problem. They have what knowledge finds hard: `when` on
unknown conditions, `or` in preconditions and goals, clauses and `oneof` at the start, sensing, all of it overlapping.
A third of them is mild: there knowledge is often complete, and "there is no plan" should be proved.
"""

from dataclasses import dataclass
from random import Random

Literal = tuple[str, bool]
Formula = tuple  # ("lit", atom, truth), ("and", formulas...), ("or", formulas...)


@dataclass(frozen=True)
class Act:
    """An action: what must hold in every world, what happens in a world, what is then seen."""

    name: str
    precondition: Formula
    effects: tuple[tuple[tuple[Literal, ...], tuple[Literal, ...]], ...]
    observes: str | None = None


@dataclass(frozen=True)
class Small:
    """A problem: of the atoms `unknown` nothing is known but `oneofs` and `clauses`; of all others `true` ones hold."""

    atoms: tuple[str, ...]
    true: tuple[str, ...]
    unknown: tuple[str, ...]
    oneofs: tuple[tuple[str, ...], ...]
    clauses: tuple[tuple[Literal, ...], ...]
    actions: tuple[Act, ...]
    goal: Formula


def random_small(seed: int) -> Small:
    """The problem of a seed."""
    return _Draw(Random(seed), mild=seed % 3 == 0).problem()  # noqa: S311


class _Draw:
    def __init__(self, random: Random, mild: bool) -> None:
        self.random, self.mild = random, mild
        self.atoms = tuple(f"p{number}" for number in range(random.randint(3, 5)))
        self.hidden = tuple(random.sample(self.atoms, random.randint(1, min(4, len(self.atoms)))))
        self.made: list[Literal] = []

    def chance(self, probability: float) -> bool:
        return self.random.random() < probability

    def literal(self, among=None) -> Literal:
        return self.random.choice(among or self.atoms), self.chance(0.6)

    def literals(self, least: int, most: int) -> tuple[Literal, ...]:
        atoms = self.random.sample(self.atoms, min(self.random.randint(least, most), len(self.atoms)))
        return tuple((atom, self.chance(0.6)) for atom in atoms)

    def formula(self, least: int, most: int) -> Formula:
        parts = []
        for atom, truth in self.literals(least, most):
            if self.chance(0.1 if self.mild else 0.25):
                other = self.literals(1, 2)
                parts.append(("or", ("lit", atom, truth), *(("lit", *each) for each in other)))
            else:
                parts.append(("lit", atom, truth))
        return parts[0] if len(parts) == 1 else ("and", *parts)

    def effect(self):
        outcomes = self.literals(1, 2)
        self.made += outcomes
        condition: tuple[Literal, ...] = ()
        if self.chance(0.25 if self.mild else 0.6):
            condition = (self.literal(self.hidden if self.chance(0.6) else None),)
            if self.chance(0.2):
                extra = self.literal()
                condition += (extra,) if extra[0] != condition[0][0] else ()
        return condition, outcomes

    def action(self, number: int) -> Act:
        effects = tuple(self.effect() for _ in range(self.random.choice([1, 1, 2])))
        return Act(f"a{number}", self.formula(0, 2), effects)

    def sensor(self, number: int) -> Act:
        among = self.hidden if self.chance(0.7) else self.atoms
        return Act(f"s{number}", self.formula(0, 1), (), self.random.choice(among))

    def problem(self) -> Small:
        actions = [self.action(number) for number in range(self.random.randint(1, 4))]
        actions += [self.sensor(number) for number in range(self.random.choice([0, 1, 1, 2, 3]))]
        oneofs, clauses = [], []
        if len(self.hidden) > 1 and self.chance(0.5):
            oneofs.append(tuple(self.random.sample(self.hidden, self.random.randint(2, len(self.hidden)))))
        for _ in range(self.random.choice([0, 0, 1] if self.mild else [0, 1, 1, 2, 3])):
            if len(self.hidden) > 1:
                some = self.random.sample(self.hidden, self.random.randint(2, min(3, len(self.hidden))))
                clauses.append(tuple((atom, self.chance(0.5)) for atom in some))
        true = tuple(atom for atom in self.atoms if atom not in self.hidden and self.chance(0.4))
        wanted = [self.random.choice(self.made) for _ in range(self.random.choice([1, 1, 2]))]
        goal: Formula = ("and", *(("lit", *each) for each in dict.fromkeys(wanted)))
        if self.chance(0.3):
            goal = self.formula(1, 2)
        return Small(self.atoms, true, self.hidden, tuple(oneofs), tuple(clauses), tuple(actions), goal)


# ------------------------------------------------------------------------------------------------------------ text
def pddl(small: Small) -> str:
    """Domain and problem in one text."""
    lines = ["(define (domain small)", f" (:predicates {' '.join(f'({atom})' for atom in small.atoms)})"]
    for act in small.actions:
        lines.append(f" (:action {act.name} :parameters () :precondition (and {_text(act.precondition)})")
        if act.observes is not None:
            lines.append(f"  :observe ({act.observes}))")
        else:
            lines.append(f"  :effect (and {' '.join(_effect(*each) for each in act.effects)}))")
    facts = [f"({atom})" for atom in small.true] + [f"(unknown ({atom}))" for atom in small.unknown]
    facts += [f"(oneof {' '.join(f'({atom})' for atom in each)})" for each in small.oneofs]
    facts += [f"(or {' '.join(_lit(*each) for each in clause)})" for clause in small.clauses]
    lines.append(
        f")\n(define (problem p) (:domain small)\n (:init {' '.join(facts)})\n (:goal {_text(small.goal)}))\n"
    )
    return "\n".join(lines)


def _lit(atom: str, truth: bool) -> str:
    return f"({atom})" if truth else f"(not ({atom}))"


def _text(formula: Formula) -> str:
    if formula[0] == "lit":
        return _lit(formula[1], formula[2])
    return f"({formula[0]} {' '.join(map(_text, formula[1:]))})"


def _effect(condition: tuple[Literal, ...], outcomes: tuple[Literal, ...]) -> str:
    made = f"(and {' '.join(_lit(*each) for each in outcomes)})"
    return f"(when (and {' '.join(_lit(*each) for each in condition)}) {made})" if condition else made
