"""Random small problems of hybrid planning, whose geometry is a random function, and brute force over all its answers.

Components have three values each. A call has a few candidates; where each of them lands is a random function of what
the call reads, and whether a component is in its way one of that component's value besides. So everything can be
looked at: brute force walks all states of knowledge and geometry, with all candidates.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from random import Random
from types import SimpleNamespace
from zlib import crc32

from kabo.geometry_server import GeometryStatistics, Refusal, Situation, Success
from kabo.language import formulas as f
from kabo.language.formulas import GroundCall
from kabo.language.problem import Problem
from kabo.scene import GeometricState
from tests.planner.scripted import at
from tests.support.small_problems import action, add, know, problem

ROBOTS, OBJECTS = ("r", "s"), ("a", "b")
COMPONENTS = (*ROBOTS, *OBJECTS)
VALUES = 3
ATOMS = ("k", "l", "m")
SENSED = "t"

Values = Mapping[str, tuple[int, ...]]  # of every component those that it may have
Knowledge = tuple[bool | None, ...]  # of the atoms and of what is sensed; None: unknown


@dataclass(frozen=True)
class Act:
    """An action: what must be known, what it makes known, and what its call moves and reads."""

    name: str
    needs: Mapping[str, bool]
    makes: Mapping[str, bool]
    moves: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    senses: bool = False


@dataclass
class Hybrid:
    """A random problem; `crowded`: how likely a component is in a candidate's way, `hopeless`: that it rules a call out."""

    seed: int
    acts: tuple[Act, ...]
    goal: Mapping[str, bool]
    candidates: int
    crowded: float
    hopeless: float
    most_effort: int = 2
    asked: int = 0
    statistics: GeometryStatistics = field(default_factory=GeometryStatistics)
    met: list[GeometricState] = field(default_factory=list)

    # ----------------------------------------------------------------------------------------- the random truth
    def chance(self, *what: object) -> float:
        """A number from 0 to 1 that depends on these things alone."""
        return crc32(repr((self.seed, *what)).encode()) % 9973 / 9973

    def lands(self, act: Act, candidate: int, values: Values) -> dict[str, int]:
        """The values of what a candidate moves after it."""
        read = tuple(values[name][0] for name in act.reads)
        return {n: int(VALUES * self.chance("lands", act.name, candidate, n, read)) for n in act.moves}

    def obstacle(self, act: Act, candidate: int, values: Values) -> str | None:
        """The first component that is in a candidate's way, at any value that it may have."""
        read = tuple(values[name][0] for name in act.reads)
        return next(
            (
                name
                for name in COMPONENTS
                for value in values[name]
                if self.chance("blocks", act.name, candidate, name, value, read) < self.crowded
            ),
            None,
        )

    def impossible(self, act: Act, values: Values) -> str | None:
        """The component whose value rules a call out, whatever is sampled."""
        names = (name for name in act.reads if self.chance("never", act.name, name, values[name]) < self.hopeless)
        return next(names, None)

    def answers(self, act: Act, values: Values, effort: int) -> tuple[list[dict[str, int]], list[str]]:
        """Where all free candidates lead, in order, and what was in the way of the others."""
        free, blocked = [], []
        for candidate in range(self.candidates + effort):
            obstacle = self.obstacle(act, candidate, values)
            if obstacle is None:
                free.append(self.lands(act, candidate, values))
            else:
                blocked.append(obstacle)
        return free, blocked

    # ----------------------------------------------------------------------------- as the planner sees a server
    @property
    def scene(self) -> SimpleNamespace:
        """What the planner reads of a scene."""
        start = GeometricState(dict.fromkeys(ROBOTS, (0.0,)), {n: at(0.0) for n in OBJECTS})
        return SimpleNamespace(robots=start.robots, movable=OBJECTS, start=start)

    def stop(self) -> bool:
        """Nobody stops it."""
        return False

    def act(self, call: GroundCall) -> Act:
        """The action of a call."""
        return next(act for act in self.acts if act.name == call.procedure)

    def bind(self, call: GroundCall) -> SimpleNamespace:
        """Which components a call moves and reads."""
        return SimpleNamespace(moves=self.act(call).moves, reads=self.act(call).reads)

    def knows(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> bool:
        """Answers cost nothing here."""
        return True

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Success | Refusal:
        """The answer, as a geometry server gives it: with what it rests on."""
        act, values = self.act(call), {name: numbers(situation, name) for name in COMPONENTS}
        answer = self._answer(act, values, attempt, effort)
        self.statistics.record(call.procedure, answer)
        return answer

    def _answer(self, act: Act, values: Values, attempt: int, effort: int) -> Success | Refusal:
        ruled_out = self.impossible(act, values)
        if ruled_out is not None:
            return Refusal("constraint", act.name, frozenset([ruled_out]), proof=True)
        free, blocked = self.answers(act, values, effort)
        if attempt < len(free):
            changes = {name: component(name, value) for name, value in free[attempt].items()}
            return Success((), changes, frozenset(blocked))
        pairs = tuple((("hand", name), blocked.count(name)) for name in dict.fromkeys(blocked))
        return Refusal("collision", act.name, frozenset({*act.reads, *blocked}), pairs)

    def refuted(self, call: GroundCall) -> Refusal | None:
        """The proof that a call fails at the start, if there is one."""
        answer = self._answer(self.act(call), dict.fromkeys(COMPONENTS, (0,)), 0, 0)
        return answer if isinstance(answer, Refusal) and answer.proof else None

    def identify(self, state: GeometricState) -> int:
        """The number of a state, in the order in which they were met."""
        if state not in self.met:
            self.met.append(state)
        return self.met.index(state)

    def state(self, identifier: int) -> GeometricState:
        """The state of a number."""
        return self.met[identifier]

    # ---------------------------------------------------------------------------------------- as a problem's text
    @property
    def problem(self) -> Problem:
        """The problem of knowledge, its calls without arguments."""
        actions = [
            action(
                act.name,
                pre=[know(literal(name, value)) for name, value in act.needs.items()],
                effects=[add(literal(name, value)) for name, value in act.makes.items()],
                sense=[f.Atom(SENSED)] if act.senses else [],
                geometry=f.ProcedureCall(act.name) if act.moves else None,
            )
            for act in self.acts
        ]
        return problem(
            actions=actions,
            initial=[add(literal(name, False)) for name in ATOMS],
            goal=[know(literal(name, value)) for name, value in self.goal.items()],
            predicates=dict.fromkeys((*ATOMS, SENSED), ()),
        )

    # ----------------------------------------------------------------------------------------------- brute force
    def solvable(self) -> bool:
        """Whether there is a plan for every outcome: the least fixpoint over all that can be reached."""
        start = ((*(False for _ in ATOMS), None), (0,) * len(COMPONENTS))
        moves: dict[object, list[list[object]]] = {}
        waiting = [start]
        while waiting:
            here = waiting.pop()
            if here not in moves:
                moves[here] = [list(outcomes) for outcomes in self._steps(*here)]
                waiting += [after for outcomes in moves[here] for after in outcomes]  # type: ignore[misc]
        solved = {here for here in moves if self.is_goal(here[0])}  # type: ignore[index]
        while start not in solved:
            more = {h for h, ways in moves.items() if h not in solved and any(solved.issuperset(w) for w in ways)}
            if not more:
                return False
            solved |= more
        return True

    def is_goal(self, knowledge: Knowledge) -> bool:
        """Whether the goal holds."""
        return self._holds(self.goal, knowledge)

    def _steps(self, knowledge: Knowledge, geometry: tuple[int, ...]) -> Iterator[list[tuple[Knowledge, object]]]:
        for act in self.acts:
            if not self._holds(act.needs, knowledge):
                continue
            known = self.after(act, knowledge)
            outcomes = (
                [(*known[:-1], value) for value in (False, True)] if known[-1] is None and act.senses else [known]
            )
            values = dict(zip(COMPONENTS, ((value,) for value in geometry), strict=True))
            if act.moves and self.impossible(act, values) is not None:
                continue
            for changes in self.answers(act, values, self.most_effort)[0] if act.moves else [{}]:
                after = tuple(changes.get(name, value) for name, value in zip(COMPONENTS, geometry, strict=True))
                yield [(outcome, after) for outcome in outcomes]

    def after(self, act: Act, knowledge: Knowledge) -> Knowledge:
        """What is known after an action, but for what it senses."""
        known = tuple(act.makes.get(name, value) for name, value in zip(ATOMS, knowledge, strict=False))
        return (*known, knowledge[-1])

    def _holds(self, literals: Mapping[str, bool], knowledge: Knowledge) -> bool:
        known = dict(zip((*ATOMS, SENSED), knowledge, strict=True))
        return all(known[name] is value for name, value in literals.items())


def literal(name: str, value: bool) -> f.Literal:
    """An atom without arguments, or that it does not hold."""
    return f.Literal(f.Atom(name), value)


def component(name: str, value: int) -> object:
    """A value as a component has it."""
    return (float(value),) if name in ROBOTS else at(float(value))


def numbers(situation: Situation, name: str) -> tuple[int, ...]:
    """The values that a component may have, as numbers."""
    found = situation.values(name)
    return tuple(int(each[0] if name in ROBOTS else each.position[0]) for each in found)  # type: ignore[union-attr,index]


def random_hybrid(seed: int, senses: bool) -> Hybrid:
    """A random problem; with sensing, one atom is unknown, and some actions need to know it."""
    draw = Random(seed)

    def some(names: tuple[str, ...], least: int, most: int) -> tuple[str, ...]:
        chosen = draw.sample(names, draw.randint(least, most))
        return tuple(name for name in names if name in chosen)

    acts = []
    for number in range(draw.randint(4, 6)):
        needs = {name: draw.random() < 0.5 for name in some(ATOMS, 0, 2)}
        if senses and draw.random() < 0.4:
            needs[SENSED] = draw.random() < 0.5
        makes = {name: draw.random() < 0.7 for name in some(ATOMS, 0 if number else 1, 2)}
        acts.append(Act(f"act_{number}", needs, makes, some(COMPONENTS, 1, 2), some(COMPONENTS, 0, 2)))
    if senses:
        looks = {name: draw.random() < 0.5 for name in some(ATOMS, 0, 1)}
        acts.append(Act("look", looks, {}, senses=True))
    goal = {name: draw.random() < 0.8 for name in some(ATOMS, 1, 2)}
    return Hybrid(
        seed, tuple(acts), goal, draw.randint(1, 2), draw.choice((0.15, 0.3, 0.45)), draw.choice((0.0, 0.1))
    )
