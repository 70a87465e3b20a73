"""Runs a plan through the worlds that may be the case: every claim to know must be true, every way must reach the goal.

A second judgement beside the replay of knowledge: here actions change true values, sensing delivers them, and what
the agent concludes plays no part, but where an effect itself depends on what is known (`query => …`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.arguments import check_calls
from kabo.verify.draft import ContradictionError
from kabo.verify.ground import NotVerifiableError, Symbol, Value
from kabo.verify.interpreter import Interpreter
from kabo.verify.linked import linked_groups
from kabo.verify.minds import Mind
from kabo.verify.possible_worlds import PossibleWorlds, in_words, possible_worlds
from kabo.verify.relevance import Relevance
from kabo.verify.report import Finding, WorldReport
from kabo.verify.streams import Stream
from kabo.verify.structure import check_structure
from kabo.verify.true_world import OpenError, World
from kabo.verify.world_steps import Player, RuledOutError, WrongError

LIMIT = 3000  # worlds that are all tried; of more, only samples are
SAMPLES = 300
MOST_FINDINGS = 10  # different ones; worlds go wrong by the thousand for one reason
MOST_RUNS = 10  # runs of one world in which actions leave something open, on average


def validate_worlds(
    problem: Problem, plan: Plan, *, limit: int = LIMIT, samples: int = SAMPLES, seed: int = 0
) -> WorldReport:
    """Executes a plan in all worlds that the initial knowledge allows, or in samples of them.

    Args:
        problem: the problem.
        plan: the plan.
        limit: most worlds that are all tried.
        samples: how many are tried if there are more.
        seed: of the samples.
    """
    order, findings = check_structure(plan)
    findings.extend(check_calls(plan, order, problem))
    if findings or not order:
        return WorldReport(tuple(findings), exhaustive=False)
    try:
        interpreter = Interpreter(problem)
        relevance = Relevance(plan, order, interpreter)
        return _Run(plan, interpreter, relevance, seed).report(limit, samples)
    except (NotVerifiableError, ContradictionError) as error:
        return WorldReport((Finding(None, f"the initial knowledge: {error}"),), exhaustive=False)


class _Run:
    """All runs of one plan."""

    def __init__(self, plan: Plan, interpreter: Interpreter, relevance: Relevance, seed: int) -> None:
        self.plan, self.seed = plan, seed
        self.start = interpreter.initial()
        self.player = Player(plan, interpreter, relevance, self.start)
        self.problem = interpreter.problem
        self.groups = linked_groups(self.problem, self.start, interpreter.rules, relevance.mattering(plan.root))
        self.findings: dict[tuple[str, str], Finding] = {}
        self.lengths: list[int] = []
        self.ruled_out = 0
        self.cut = False

    def report(self, limit: int, samples: int) -> WorldReport:
        """Runs every world."""
        possible = possible_worlds(self.groups, limit, samples, self.seed)
        if not possible.worlds:
            text = "no world agrees with all of the initial knowledge: it contradicts itself"
            if not possible.exhaustive:
                text = "no world was found that agrees with all of the initial knowledge"
            return WorldReport((Finding(None, text),), exhaustive=possible.exhaustive)
        runs = MOST_RUNS * len(possible.worlds)
        for index, values in enumerate(possible.worlds):
            runs -= self._world(index, values, max(runs, 0))
            if len(self.findings) >= MOST_FINDINGS:
                self.cut = True
                break
        return self._summary(possible)

    def _summary(self, possible: PossibleWorlds) -> WorldReport:
        if not self.lengths and not self.findings:
            text = "no world is left: the update rules and what actions say rule out every one"
            self.findings["", text] = Finding(None, text)
        lengths = self.lengths or [0]
        return WorldReport(
            tuple(self.findings.values()),
            len(possible.worlds),
            possible.exhaustive and not self.cut,
            min(lengths),
            sum(lengths) / len(lengths),
            max(lengths),
            self.ruled_out,
        )

    def _world(self, index: int, values: Mapping[Symbol, Value], budget: int) -> int:
        """Runs one world, with every value of what actions leave open while the budget lasts; how many runs."""
        stream = Stream(self.seed + 1, index)
        first = World({**self.start.known, **values}, dict(self.start.excluded), self.start)
        first.first = first.copy()
        self.player.watch(first)
        stack = [_Place(self.plan.root, 0, first, self.player.root)]
        runs = 0
        while stack:
            place = stack.pop()
            try:
                self.lengths.append(self._play(place))
            except OpenError as error:
                forks = self._forks(place, error)
                if runs + len(stack) >= budget and len(forks) > 1:
                    self.cut, forks = True, [forks[stream.below(len(forks))]]
                stack.extend(reversed(forks))
                continue
            except WrongError as error:
                if place.world.ramified:
                    self.ruled_out += 1
                else:
                    self._wrong(place, str(error), values)
            except RuledOutError:
                if place.world.pending is not None and place.world.pending.chosen:
                    continue  # no world: a value that does not agree with what the action says
                self.ruled_out += 1
            runs += 1
        return runs

    def _play(self, place: "_Place") -> int:
        """Goes on to the goal; the number of actions."""
        while True:
            moved = self.player.step(place.name, place.phase, place.world, place.mind)
            place.length += moved.counts
            if moved.successor is None:
                return place.length
            place.name, place.phase, place.mind = moved.successor, 0, moved.mind

    def _forks(self, place: "_Place", error: OpenError) -> list["_Place"]:
        """The same place once for each value that an open term may have."""
        result = []
        for value in place.world.possible(error.symbol, self.problem):
            world = place.world.copy()
            world.put(error.symbol, value)
            chosen = (*place.chosen, (error.symbol, value))
            result.append(replace(place, phase=error.phase, world=world, chosen=chosen))
        return result

    def _wrong(self, place: "_Place", message: str, values: Mapping[Symbol, Value]) -> None:
        if (place.name, message) in self.findings:
            return
        text = f"{message} [world: {in_words(list(_shown(values))) or 'the only one'}]"
        if place.chosen:
            text += f" [left open by actions: {in_words(place.chosen)}]"
        self.findings[place.name, message] = Finding(place.name, text)


@dataclass
class _Place:
    """Where a run is: the node and the phase of its step, the world, what is known, and values chosen on the way."""

    name: str
    phase: int
    world: World
    mind: Mind | None
    length: int = 0
    chosen: tuple[tuple[Symbol, Value], ...] = ()


def _shown(values: Mapping[Symbol, Value]) -> Iterator[tuple[Symbol, Value]]:
    """What is true first: of many atoms most are false."""
    yield from (pair for pair in values.items() if pair[1] is not False)
    yield from (pair for pair in values.items() if pair[1] is False)
