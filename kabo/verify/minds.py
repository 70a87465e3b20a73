"""What is known while a plan runs in a world, for effects that depend on it (`query => …`): played once, then kept.

Runs that know the same at a node share what follows, so that hundreds of worlds cost little more than the replay.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from kabo.language.formulas import Change, Comparison, Conditional, Effect, FactForall, ForEach
from kabo.plan import Plan
from kabo.verify.ground import Symbol, Value
from kabo.verify.interpreter import Interpreter
from kabo.verify.knowledge import Frozen, Knowledge
from kabo.verify.relevance import Relevance
from kabo.verify.steps import Step, step


@dataclass
class Mind:
    """What is known at a node, what playing the node there comes to, and what is known behind each outcome."""

    name: str
    state: Knowledge
    step: Step
    onward: "dict[Value | None, tuple[Mind, tuple[tuple[Symbol, Value], ...]]]" = field(default_factory=dict)


class Minds:
    """All that is known anywhere in the runs of one plan."""

    def __init__(self, plan: Plan, interpreter: Interpreter, relevance: Relevance) -> None:
        self.plan, self.interpreter, self.relevance = plan, interpreter, relevance
        self._minds: dict[tuple[str, Frozen], Mind] = {}

    def at(self, name: str, state: Knowledge) -> Mind:
        """What is known at a node, without what the rest of the plan does not ask for."""
        rest = self.relevance.reduced(name, state)
        self.relevance.leave(name)
        key = name, rest.frozen()
        if key not in self._minds:
            self._minds[key] = Mind(name, rest, step(self.interpreter, self.plan.nodes[name], rest))
        return self._minds[key]

    def onward(self, mind: Mind, value: Value | None) -> tuple[Mind, tuple[tuple[Symbol, Value], ...]] | None:
        """What is known at the next node, and what of it is new; None if the outcome is held to be impossible."""
        if value not in mind.onward:
            way = next((way for way in mind.step.ways if way.value == value), None)
            if way is None:
                return None
            before = mind.state.known
            news = tuple((s, v) for s, v in way.state.known.items() if before.get(s) != v)
            mind.onward[value] = self.at(way.successor, way.state), news
        return mind.onward[value]


def depends_on_knowledge(effects: Iterable[Effect]) -> bool:
    """Whether what effects do to the world depends on what is known."""
    return any(map(_depends, _flat(effects)))


def _flat(effects: Iterable[Effect]) -> Iterator[Effect]:
    for effect in effects:
        if isinstance(effect, ForEach):
            yield from _flat(effect.effects)
        else:
            yield effect


def _depends(effect: Effect) -> bool:
    if isinstance(effect, Conditional):
        return True
    if not isinstance(effect, Change) or effect.database not in ("Kf", "LCW"):
        return False
    if effect.database == "LCW":
        return effect.operation == "add"
    facts = [fact.body if isinstance(fact, FactForall) else fact for fact in effect.facts]
    return any(isinstance(f, Comparison) and (effect.operation == "del" or f.operator == "!=") for f in facts)
