"""Small random problems in the language's own text: every construct of knowledge, on five atoms and one or two terms.

Seeded and drawn in a fixed order, so that a number names a problem. Most of them hide something, let some of it be
sensed, and ask for something that depends on it; the rest is noise.
"""

from random import Random

ATOMS = ("p(x)", "p(y)", "q", "r", "s")
VALUES = ("u", "v", "w")


def random_problem(seed: int) -> tuple[str, str]:
    """The text of a domain file and of a problem file."""
    draw = _Draw(Random(seed))  # noqa: S311
    return draw.files()


class _Draw:
    """One problem while it is drawn: `atoms` are those in use, `term` whether there is a function."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.atoms = sorted(random.sample(ATOMS, random.randint(2, 5)))
        self.term = random.random() < 0.5
        self.copy = self.term and random.random() < 0.4
        self.hidden = self.some(self.atoms, 1, 3)
        self.made: list[str] = []  # what some action can bring about: goals like to ask for it

    # ------------------------------------------------------------------------------------------------- pieces
    def chance(self, probability: float) -> bool:
        return self.random.random() < probability

    def some(self, things, least: int, most: int) -> list:
        things = list(things)
        return self.random.sample(things, min(len(things), self.random.randint(least, most)))

    def literal(self, atom: str | None = None) -> str:
        atom = atom or self.random.choice(self.atoms)
        return atom if self.chance(0.6) else f"not {atom}"

    def claim(self, operators=("=",)) -> str:
        if self.term and self.chance(0.3):
            name = "g" if self.copy and self.chance(0.3) else "f"
            return f"{name} {self.random.choice(operators)} {self.random.choice(VALUES)}"
        return self.literal()

    def query(self, depth: int = 1) -> str:
        kind = self.random.random()
        if depth and kind < 0.15:
            joint = self.random.choice(["or", "and", "xor"])
            return f"({self.query(0)} {joint} {self.query(0)})"
        if kind < 0.22:
            return f"not K({self.claim(('=', '!='))})"
        if kind < 0.32:
            return "Kv(f)" if self.term and self.chance(0.4) else f"Kw({self.random.choice(self.atoms)})"
        if kind < 0.36 and {"p(x)", "p(y)"} <= set(self.atoms):
            return self.random.choice(["forall(thing z) K(p(z))", "exists(thing z) K(not p(z))"])
        return f"K({self.claim(('=', '=', '!='))})"

    # ------------------------------------------------------------------------------------------------ effects
    def change(self) -> str:
        kind = self.random.random()
        if kind < 0.62:
            facts = list(dict.fromkeys(self.literal() for _ in range(self.random.randint(1, 2))))
            self.made += facts
            return f"add(Kf, {', '.join(facts)})"
        if kind < 0.74:
            atom = self.random.choice(self.atoms)
            return self.random.choice([f"del(Kf, {self.literal(atom)})", f"del(Kf, {atom}, not {atom})"])
        if self.term and kind < 0.86:
            operator = self.random.choice(["=", "=", "!="])
            return f"add(Kf, f {operator} {self.random.choice(VALUES)})"
        if kind < 0.93:
            return self.entry()
        return f"del(Kw, {self.random.choice(self.atoms)})"

    def entry(self) -> str:
        """A new entry of Kx or Kor: it is about values that are unknown, so they are forgotten with it."""
        database = self.random.choice(["Kx", "Kor"])
        atoms = self.some(self.atoms, 2, 3)
        forget = ", ".join(f"{atom}, not {atom}" for atom in atoms)
        return f"del(Kf, {forget}), add({database}, {', '.join(map(self.literal, atoms))})"

    def effect(self) -> str:
        kind = self.random.random()
        if kind < 0.5:
            return self.change()
        if kind < 0.65:
            return f"{self.query(0)} => {self.change()}"
        conditions = " and ".join(self.claim() for _ in range(self.random.choice([1, 1, 1, 2])))
        outcomes = " and ".join(self.literal() for _ in range(self.random.choice([1, 1, 1, 2])))
        return f"when {conditions} then {outcomes}"

    # ------------------------------------------------------------------------------------------------ actions
    def sensing_action(self) -> list[str]:
        if self.term and self.chance(0.35):
            lines = ["sense: f"]
        elif len(self.atoms) > 1 and self.chance(0.15):
            first, second = self.some(self.atoms, 2, 2)
            lines = ["effects:", f"  - add(Kw, {first} and {self.literal(second)})"]
        else:
            lines = [f"sense: {self.random.choice([*self.hidden, self.random.choice(self.atoms)])}"]
        if lines[0].startswith("sense") and self.chance(0.15):
            lines = [*lines, "effects:", f"  - {self.effect()}"]
        return [*self.conditions(0.25), *lines]

    def world_action(self) -> list[str]:
        """Something that depends on what is hidden."""
        cause, result = self.random.choice(self.hidden), self.literal()
        self.made.append(result)
        lines = ["effects:", f"  - when {self.literal(cause)} then {result}"]
        if self.chance(0.5):
            lines = ["preconditions:", f"  - K({self.literal(cause)})", "effects:", f"  - add(Kf, {result})"]
        if self.chance(0.4):
            lines.append(f"  - {self.effect()}")
        return lines if lines[0] == "preconditions:" else [*self.conditions(0.2), *lines]

    def plain_action(self) -> list[str]:
        lines = ["effects:", *(f"  - {self.effect()}" for _ in range(self.random.randint(1, 2)))]
        return [*self.conditions(0.6), *lines]

    def value_action(self) -> list[str]:
        """One with a run-time variable."""
        self.made.append(self.literal())
        effects = [f"  - add(Kf, {self.made[-1]})"]
        if self.copy:
            effects.append("  - add(Kf, g = c)")
        if self.chance(0.4):
            effects.append(f"  - when f = c then {self.literal()}")
        return ["parameters: {c: {value_of: f}}", *self.conditions(0.4), "effects:", *effects]

    def thing_action(self) -> list[str]:
        """One with a parameter."""
        start = ["parameters: {t: thing}"]
        if self.chance(0.4):
            return [*start, "sense: p(t)"]
        other = self.literal()
        effect = self.random.choice(
            ["add(Kf, p(t))", "add(Kf, not p(t))", f"when p(t) then {other}", f"K(p(t)) => add(Kf, {other})"]
            + ["forall(thing z) (K(z != t) => add(Kf, not p(z)))"]
        )
        return [*start, *self.conditions(0.4), "effects:", f"  - {effect}"]

    def conditions(self, probability: float) -> list[str]:
        if not self.chance(probability):
            return []
        return ["preconditions:", *(f"  - {self.query()}" for _ in range(self.random.choice([1, 1, 2])))]

    def action(self, number: int) -> list[str]:
        kinds = [self.sensing_action, self.world_action, self.plain_action, self.plain_action]
        if self.term:
            kinds.append(self.value_action)
        if {"p(x)", "p(y)"} <= set(self.atoms):
            kinds.append(self.thing_action)
        lines = self.sensing_action() if number == 0 else self.random.choice(kinds)()
        return [f"  a{number}:", *("    " + line for line in lines)]

    # -------------------------------------------------------------------------------------------------- files
    def rules(self) -> list[str]:
        if not self.chance(0.2):
            return []
        cause = f"K({self.claim()})"
        if self.chance(0.3):
            cause += f" and K({self.claim()})"
        return ["update_rules:", f"  - {cause} => add(Kf, {self.claim()})"]

    def initial(self) -> list[str]:
        known = [atom for atom in self.atoms if atom not in self.hidden]
        facts = [self.literal(atom) for atom in known if self.chance(0.7)]
        lines = [f"  - add(Kf, {', '.join(facts)})"] if facts else []
        members = [self.literal(atom) for atom in self.hidden]
        if self.term and self.chance(0.3):
            members.append(f"f = {self.random.choice(VALUES)}")
        if len(members) > 1 and self.chance(0.6):
            lines.append(f"  - add({self.random.choice(['Kx', 'Kx', 'Kor'])}, {', '.join(members)})")
        if self.term and self.chance(0.5):
            lines.append(f"  - add(Kf, f {self.random.choice(['=', '!=', '!='])} {self.random.choice(VALUES)})")
        if self.chance(0.1):
            lines.append(f"  - add(Kw, {self.random.choice(self.atoms)})")
        if self.chance(0.1) and {"p(x)", "p(y)"} <= set(self.atoms):
            both = " and q" if "q" in self.atoms and self.chance(0.5) else ""
            lines.append(
                f"  - add(LCW, forall(thing z) (p(z){both}))" if both else "  - add(LCW, forall(thing z) p(z))"
            )
        return ["initial:", *lines] if lines else []

    def goal(self) -> list[str]:
        wanted = [f"K({fact})" for fact in self.made] or [self.query(0)]
        wanted += [f"Kw({atom})" for atom in self.hidden] + [f"(K({a}) or K(not {a}))" for a in self.hidden]
        goals = [
            self.query(0) if self.chance(0.2) else self.random.choice(wanted)
            for _ in range(self.random.choice([1, 1, 2]))
        ]
        if self.chance(0.08):
            goals.append(f"initially({self.query(0)})")
        if self.chance(0.08):
            goals.append(f"always({self.query(0)})")
        return ["goal:", *(f"  - {goal}" for goal in dict.fromkeys(goals))]

    def files(self) -> tuple[str, str]:
        """The two texts."""
        actions = [line for number in range(self.random.randint(2, 5)) for line in self.action(number)]
        functions = []
        if self.term:
            functions = ["functions:", *(f"  {name}: {{arguments: [], value: [u, v, w]}}" for name in ("f", "g"))]
        domain = [
            "domain: small",
            "types: [thing]",
            "constants:",
            "  thing: [x, y]",
            "predicates:",
            "  p: [thing]",
            "  q: []",
            "  r: []",
            "  s: []",
            *functions,
            *self.rules(),
            "actions:",
            *actions,
        ]
        problem = ["problem: small", *self.initial(), *self.goal()]
        return "\n".join(domain) + "\n", "\n".join(problem) + "\n"
