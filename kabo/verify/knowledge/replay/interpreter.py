"""The knowledge semantics of one problem: its initial state, its actions, its branchings, its goal.

Source: docs/explanation/knowledge.md.

Actions, update rules and goals are grounded once and cached, actions by their names and arguments.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

from kabo.language.formulas import And, Forall, Formula, Temporal
from kabo.language.problem import Action, Problem
from kabo.plan import ValueOf
from kabo.plan.plan import Arguments
from kabo.verify.knowledge.external_procedures import external_of, succeeds
from kabo.verify.knowledge.facts import Facts, truth, will_be_known
from kabo.verify.knowledge.ground import (
    Binding,
    Entry,
    GroundClaim,
    Observable,
    Symbol,
    Value,
    instances,
    is_symbol,
    range_of,
    read_observable,
    read_symbol,
)
from kabo.verify.knowledge.mentions import mentions
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError, MutableKnowledge
from kabo.verify.knowledge.replay.questions import question
from kabo.verify.knowledge.replay.states import Knowledge, symbols_of
from kabo.verify.knowledge.replay.transition import change_world, look_back, note, settle
from kabo.verify.knowledge.replay.update_rules import UpdateRules
from kabo.verify.knowledge.terms import Question
from kabo.verify.knowledge.updates import Rule, Updates, fired, rules_of, sensing


@dataclass(frozen=True)
class GroundAction:
    """An action with its arguments: preconditions and effects as functions of the state."""

    action: Action
    values: tuple[tuple[str, Symbol | None], ...]  # run-time variables: the text and symbol of their terms
    preconditions: tuple[Question, ...]
    effects: tuple[Rule, ...]
    refused: bool  # whether the function of its external procedure says that it fails


@dataclass(frozen=True)
class GoalPart:
    """A conjunct of the goal; `temporal` says whether it uses `always` or `initially`."""

    formula: Formula
    holds: Question
    mentioned: frozenset[Symbol | str]
    temporal: bool


class Interpreter:
    """Evaluates a problem's formulas and effects on states of knowledge."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.rules = UpdateRules.of(problem)
        self._actions: dict[tuple[str, tuple[tuple[str, object], ...]], GroundAction] = {}
        self._always: list[Question] = []
        self._remember: frozenset[Symbol | str] = frozenset()
        self._looks_back = 0
        self.goals = tuple(self._goal_part(formula, binding) for formula, binding in self._conjuncts())
        self.dependencies: dict[object, object] = {}  # a cache of `dependencies_of`

    def _conjuncts(self) -> Iterator[tuple[Formula, Binding]]:
        """The goal without its outer conjunctions and universal quantifiers."""
        waiting: list[tuple[Formula, Binding]] = [(formula, {}) for formula in reversed(self.problem.goal)]
        while waiting:
            formula, binding = waiting.pop()
            if isinstance(formula, And):
                waiting.extend((part, binding) for part in reversed(formula.parts))
            elif isinstance(formula, Forall):
                every = list(instances(self.problem, formula.variables, binding))
                waiting.extend((formula.body, more) for more in reversed(every))
            else:
                yield formula, binding

    def _goal_part(self, formula: Formula, binding: Binding) -> GoalPart:
        before = len(self._always), self._looks_back
        holds = question(formula, self.problem, binding, self._temporal)
        temporal = (len(self._always), self._looks_back) != before
        return GoalPart(formula, holds, frozenset(mentions(formula, self.problem, binding)), temporal)

    def reaches_goal(self, state: Knowledge) -> bool:
        """Whether every conjunct of the goal holds in a state."""
        return all(part.holds(state) for part in self.goals)

    def _temporal(self, formula: Temporal, binding: Binding) -> Question:
        inner = question(formula.body, self.problem, binding)
        if formula.kind == "always":
            number = len(self._always)
            self._always.append(inner)
            return lambda state: isinstance(state, Knowledge) and number not in state.broken
        self._remember |= frozenset(mentions(formula.body, self.problem, binding))
        self._looks_back += 1
        return lambda state: isinstance(state, Knowledge) and inner(state.at_start())

    # --------------------------------------------------------------------------------------------------- states
    def initial(self) -> Knowledge:
        """The initial state of the problem file: facts in their order, then entries, LCW and rules.

        Raises:
            ContradictionError: the initial knowledge contradicts itself.
            NotVerifiableError: the verifier does not judge a part of it.
        """
        draft = MutableKnowledge(self.problem, Knowledge({}))
        rest = Updates()
        for rule in rules_of(self.problem.initial, self.problem, {}, question):
            updates = fired([rule], draft)
            rest.entries += updates.entries
            rest.no_entries += updates.no_entries
            rest.complete += updates.complete
            rest.no_complete += updates.no_complete
            updates.entries, updates.no_entries, updates.complete, updates.no_complete = [], [], [], []
            change_world(draft, draft.finished(), updates, frozenset())
        for symbol in self._single_valued():
            draft.changed.add(symbol)
        note(draft, replace(rest, complete=[]))
        if rest.complete:  # a local closed world depends on what is known, inferences included
            settle(draft, self.rules, everything=True)
        note(draft, Updates(complete=rest.complete))
        settle(draft, self.rules, everything=True)
        state = draft.finished()
        return self._watched(replace(state, past=self._past(state)) if self._looks_back else state)

    def _past(self, state: Knowledge) -> Knowledge:
        """The knowledge of the initial state that concerns what `initially` mentions."""
        entries = [*state.exclusive, *state.some]
        while True:
            tied = {
                symbol
                for entry in entries
                if any(symbol in self._remember or symbol[0] in self._remember for symbol in symbols_of(entry))
                for symbol in symbols_of(entry)
            }
            if tied <= self._remember:
                break
            self._remember |= tied

        def near(entry: Entry) -> bool:
            return not symbols_of(entry).isdisjoint(tied)

        return Knowledge(
            {s: value for s, value in state.known.items() if s in self._remember or s[0] in self._remember},
            {s: values for s, values in state.excluded.items() if s in self._remember or s[0] in self._remember},
            exclusive=frozenset(filter(near, state.exclusive)),
            some=frozenset(filter(near, state.some)),
        )

    def _single_valued(self) -> Iterator[Symbol]:
        """The terms that can have one value only, which is therefore known."""
        for name, function in self.problem.domain.functions.items():
            values = self.problem.values_of(name)
            if values is not None and len(values) == 1:
                for arguments in product(*(self.problem.of_type(kind) for kind in function.arguments)):
                    yield name, arguments

    def _watched(self, state: Knowledge) -> Knowledge:
        """The state, with a record of the `always` goals that do not hold in it."""
        now = {number for number, holds in enumerate(self._always) if not holds(state)}
        return replace(state, broken=state.broken | now) if now - state.broken else state

    # -------------------------------------------------------------------------------------------------- actions
    def action(self, name: str, arguments: Arguments) -> GroundAction:
        """The ground action of this name with these arguments, which must fit the action's parameters.

        Raises:
            NotVerifiableError: the verifier does not judge a part of it.
        """
        key = name, tuple(sorted(arguments.items(), key=lambda pair: pair[0]))
        if key not in self._actions:
            schema = self.problem.domain.actions[name]
            binding: Binding = dict(arguments)
            call = external_of(schema.geometry, self.problem)
            self._actions[key] = GroundAction(
                schema,
                tuple(
                    (value.term, read_symbol(value.term, self.problem))
                    for value in arguments.values()
                    if isinstance(value, ValueOf)
                ),
                tuple(question(part, self.problem, binding) for part in schema.preconditions),
                (
                    *rules_of(schema.effects, self.problem, binding, question),
                    *sensing(schema.sense, self.problem, binding),
                ),
                call is not None and not succeeds(call, self.problem, binding),
            )
        return self._actions[key]

    def act(self, state: Knowledge, action: GroundAction) -> tuple[Knowledge, Updates]:
        """The knowledge after an action, without the values that it senses, and the updates that fired.

        Raises:
            ContradictionError: the action would contradict what is known, so it is not applicable.
            NotVerifiableError: the verifier does not judge an effect.
        """
        updates = fired(action.effects, state)
        draft = MutableKnowledge(self.problem, state)
        change_world(draft, state, updates, self._remember)
        settle(draft, self.rules)
        look_back(draft, self.rules, self._remember)
        return self._watched(draft.finished()), updates

    # ----------------------------------------------------------------------------------------------- branching
    def read(self, text: str) -> Observable | None:
        """The atom, term or conjunction that a plan's `on` or `delivers` names; None if there is none."""
        return read_observable(text, self.problem)

    def can_branch(self, state: Facts, thing: Observable) -> bool:
        """Whether the observable's truth or value will be known at run time, so that a plan can branch on it."""
        if is_symbol(thing):
            return will_be_known(thing, state)  # type: ignore[arg-type]
        if isinstance(state, Knowledge) and thing in state.conjunctions:
            return True
        return self._determined(state, thing)  # type: ignore[arg-type]

    def _determined(self, state: Facts, claims: tuple[GroundClaim, ...]) -> bool:
        truths = [truth(claim, state) for claim in claims]
        return False in truths or None not in truths or all(will_be_known(claim[0], state) for claim in claims)

    def outcomes_of(self, thing: Observable, state: Knowledge) -> tuple[Value, ...] | None:
        """All values in an observable's range, even excluded ones; for a number only its known value, or None."""
        if not is_symbol(thing):
            return (False, True)
        symbol: Symbol = thing  # type: ignore[assignment]
        values = range_of(self.problem, symbol)
        if values is None and symbol in state.known:
            return (state.known[symbol],)
        return values

    def learned(self, state: Knowledge, thing: Observable, value: Value) -> Knowledge | None:
        """The knowledge in the branch of an outcome; None if the outcome contradicts what is known."""
        draft = MutableKnowledge(self.problem, state)
        try:
            if is_symbol(thing):
                draft.learn((thing, value, True))  # type: ignore[arg-type]
            else:
                claims: tuple[GroundClaim, ...] = thing  # type: ignore[assignment]
                draft.conjunctions.discard(claims)
                if value is True:
                    for claim in claims:
                        draft.learn(claim)
                else:
                    draft.deny_all(claims)
            settle(draft, self.rules)
            look_back(draft, self.rules, self._remember)
        except ContradictionError:
            return None
        return self._watched(draft.finished())
