"""The domain's update rules, grounded once, with an index of the rules that a change can trigger."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from kabo.language.formulas import Effect, ForEach
from kabo.language.problem import Problem
from kabo.verify.knowledge.ground import Binding, Symbol, instances
from kabo.verify.knowledge.mentions import mentions
from kabo.verify.knowledge.replay.questions import question
from kabo.verify.knowledge.updates import Rule, rules_of


@dataclass
class UpdateRules:
    """Every instance of every rule; `by_symbol` maps an atom, a term or a symbol's name to the rules that mention it."""

    rules: list[Rule] = field(default_factory=list)
    mentioned: list[frozenset[Symbol | str]] = field(default_factory=list)
    by_symbol: dict[Symbol | str, list[int]] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem) -> "UpdateRules":
        """All ground update rules of a problem's domain."""
        result = cls()
        for effect, binding in ground(problem.domain.update_rules, problem, {}):
            for rule in rules_of([effect], problem, binding, question):
                result._add(rule, frozenset(mentions(effect, problem, binding)))
        return result

    def _add(self, rule: Rule, mentioned: frozenset[Symbol | str]) -> None:
        for thing in mentioned:
            self.by_symbol.setdefault(thing, []).append(len(self.rules))
        self.rules.append(rule)
        self.mentioned.append(mentioned)

    def set_off_by(self, symbols: Iterable[Symbol]) -> list[Rule]:
        """The rules that a change of these atoms and terms can trigger, in the order of the file."""
        numbers: set[int] = set()
        for symbol in symbols:
            numbers.update(self.by_symbol.get(symbol, ()))
            numbers.update(self.by_symbol.get(symbol[0], ()))
        return [self.rules[number] for number in sorted(numbers)]


def ground(effects: Iterable[Effect], problem: Problem, binding: Binding) -> Iterator[tuple[Effect, Binding]]:
    """The effects without their outer quantifiers, once for each instance, with the binding of the variables."""
    for effect in effects:
        if isinstance(effect, ForEach):
            for more in instances(problem, effect.variables, binding):
                yield from ground(effect.effects, problem, more)
        else:
            yield effect, binding
