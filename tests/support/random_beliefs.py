"""Small random contingent problems about the world, as text and as plain data for `oracles_planning.py`.

Seeded and drawn in a fixed order, so that a number names a problem. They have what knowledge finds hard: `when` on
unknown conditions, `or` in preconditions and goals, clauses and `oneof` at the start, sensing, all of it overlapping.
A third of them is mild: there knowledge is often complete, and "there is no plan" should be proved. As PDDL they have
all of this; in kabo's own language, where conditions are about knowledge, none has `or`, and some have a term f with
three values, in the data as three atoms `f=u`, `f=v` and `f=w` of which exactly one holds.
"""

from dataclasses import dataclass
from random import Random

Literal = tuple[str, bool]
TERM = ("f=u", "f=v", "f=w")
Formula = tuple  # ("lit", atom, truth), ("and", formulas...), ("or", formulas...)


@dataclass(frozen=True)
class Act:
    """An action: what must hold in every world, what happens in a world, which atoms are then seen."""

    name: str
    precondition: Formula
    effects: tuple[tuple[tuple[Literal, ...], tuple[Literal, ...]], ...]
    observes: tuple[str, ...] = ()
    whether: tuple[Literal, ...] = ()  # only whether all of these hold is seen


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
    term: tuple[str, ...] = ()  # of these exactly one holds at all times


def random_small(seed: int, *, own: bool = False) -> Small:
    """The problem of a seed; `own`: one that kabo's own language can say."""
    return _Draw(Random(seed), mild=seed % 3 == 0, own=own).problem()  # noqa: S311


class _Draw:
    def __init__(self, random: Random, mild: bool, own: bool) -> None:
        self.random, self.mild, self.own = random, mild, own
        self.atoms = tuple(f"p{number}" for number in range(random.randint(3, 5)))
        self.hidden = tuple(random.sample(self.atoms, random.randint(1, min(4, len(self.atoms)))))
        self.term = TERM if own and random.random() < 0.6 else ()
        self.term_hidden = bool(self.term) and random.random() < 0.8
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
            if not self.own and self.chance(0.1 if self.mild else 0.25):
                other = self.literals(1, 2)
                parts.append(("or", ("lit", atom, truth), *(("lit", *each) for each in other)))
            else:
                parts.append(("lit", atom, truth))
        if self.term and self.chance(0.3):
            parts.append(("lit", self.random.choice(self.term), self.chance(0.7)))
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
        if self.term and self.chance(0.3):
            condition += ((self.random.choice(self.term), True),)
        if self.term and self.chance(0.25):
            value = self.random.choice(self.term)
            outcomes = tuple((other, other == value) for other in self.term)
            self.made.append((value, True))
        return condition, outcomes

    def action(self, number: int) -> Act:
        effects = tuple(self.effect() for _ in range(self.random.choice([1, 1, 2])))
        while self.own and _may_clash(effects):
            effects = effects[1:] or (self.effect(),)
        return Act(f"a{number}", self.formula(0, 2), effects)

    def sensor(self, number: int) -> Act:
        among = self.hidden if self.chance(0.7) else self.atoms
        seen = self.term if self.term and self.chance(0.3) else (self.random.choice(among),)
        if self.own and len(self.hidden) > 1 and self.chance(0.25):
            both = tuple((atom, self.chance(0.6)) for atom in self.random.sample(self.hidden, 2))
            return Act(f"s{number}", self.formula(0, 1), (), (), both)
        return Act(f"s{number}", self.formula(0, 1), (), seen)

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
                if self.term_hidden and self.chance(0.3):
                    clauses[-1] += ((self.random.choice(self.term), True),)
        true = tuple(atom for atom in self.atoms if atom not in self.hidden and self.chance(0.4))
        wanted = [self.random.choice(self.made) for _ in range(self.random.choice([1, 1, 2]))]
        goal: Formula = ("and", *(("lit", *each) for each in dict.fromkeys(wanted)))
        if self.chance(0.3):
            goal = self.formula(1, 2)
        true += () if self.term_hidden else self.term[:1]
        hidden = self.hidden + (self.term if self.term_hidden else ())
        return Small(self.atoms, true, hidden, tuple(oneofs), tuple(clauses), tuple(actions), goal, self.term)


def _may_clash(effects) -> bool:
    """Whether two outcomes may exclude each other: in kabo's language that is a contradiction, and no rule of PDDL."""
    made = {each for _, outcomes in effects for each in outcomes}
    return any((atom, not truth) in made for atom, truth in made)


# ------------------------------------------------------------------------------------------------------------ text
def pddl(small: Small) -> str:
    """Domain and problem in one text."""
    lines = ["(define (domain small)", f" (:predicates {' '.join(f'({atom})' for atom in small.atoms)})"]
    for act in small.actions:
        lines.append(f" (:action {act.name} :parameters () :precondition (and {_text(act.precondition)})")
        if act.observes:
            lines.append(f"  :observe ({act.observes[0]}))")
        else:
            lines.append(f"  :effect (and {' '.join(_effect(*each) for each in act.effects)}))")
    facts = [f"({atom})" for atom in small.true] + [f"(unknown ({atom}))" for atom in small.unknown]
    facts += [f"(oneof {' '.join(f'({atom})' for atom in each)})" for each in small.oneofs]
    facts += [f"(or {' '.join(_lit(*each) for each in clause)})" for clause in small.clauses]
    lines.append(
        f")\n(define (problem p) (:domain small)\n (:init {' '.join(facts)})\n (:goal {_text(small.goal)}))\n"
    )
    return "\n".join(lines)


def own_files(small: Small) -> tuple[str, str]:
    """A domain and a problem in kabo's own language."""
    domain = ["domain: small", "types: [thing]", "predicates:", *(f"  {atom}: []" for atom in small.atoms)]
    if small.term:
        domain += ["functions:", "  f: {arguments: [], value: [u, v, w]}"]
    domain.append("actions:")
    for act in small.actions:
        domain.append(f"  {act.name}:")
        wanted = [f"      - K({_claim(*each)})" for each in _literals(act.precondition)]
        domain += ["    preconditions:", *wanted] if wanted else []
        if act.observes:
            domain.append(f"    sense: {act.observes[0] if len(act.observes) == 1 else 'f'}")
        elif act.whether:
            domain += ["    effects:", f"      - add(Kw, {' and '.join(_claim(*each) for each in act.whether)})"]
        else:
            domain += ["    effects:", *(f"      - {_own_effect(*each)}" for each in act.effects)]
    known = [(atom, atom in small.true) for atom in (*small.atoms, *small.term) if atom not in small.unknown]
    start = [f"add(Kf, {', '.join(_claims(known))})"] if known else []
    start += [f"add(Kx, {', '.join(each)})" for each in small.oneofs]
    start += [f"add(Kor, {', '.join(_claim(*each) for each in clause)})" for clause in small.clauses]
    problem = ["problem: small", "domain: domain.yaml"]
    problem += ["initial:", *(f"  - {each}" for each in start)] if start else []
    problem += ["goal:", *(f"  - K({_claim(*each)})" for each in _literals(small.goal))]
    return "\n".join(domain) + "\n", "\n".join(problem) + "\n"


def _literals(formula: Formula) -> list[Literal]:
    if formula[0] == "lit":
        return [(formula[1], formula[2])]
    assert formula[0] == "and", "conditions of knowledge say nothing of disjunctions about the world"
    return [each for part in formula[1:] for each in _literals(part)]


def _claim(atom: str, truth: bool) -> str:
    if atom in TERM:
        return f"f {'=' if truth else '!='} {atom[-1]}"
    return atom if truth else f"not {atom}"


def _claims(literals) -> list[str]:
    """The literals; of a term only the value that it has."""
    return [_claim(atom, truth) for atom, truth in literals if truth or atom not in TERM]


def _own_effect(condition: tuple[Literal, ...], outcomes: tuple[Literal, ...]) -> str:
    if not condition:
        return f"add(Kf, {', '.join(_claims(outcomes))})"
    return f"when {' and '.join(_claim(*each) for each in condition)} then {' and '.join(_claims(outcomes))}"


def _lit(atom: str, truth: bool) -> str:
    return f"({atom})" if truth else f"(not ({atom}))"


def _text(formula: Formula) -> str:
    if formula[0] == "lit":
        return _lit(formula[1], formula[2])
    return f"({formula[0]} {' '.join(map(_text, formula[1:]))})"


def _effect(condition: tuple[Literal, ...], outcomes: tuple[Literal, ...]) -> str:
    made = f"(and {' '.join(_lit(*each) for each in outcomes)})"
    return f"(when (and {' '.join(_lit(*each) for each in condition)}) {made})" if condition else made
