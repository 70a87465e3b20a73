"""Plans of kabo as plans of unified-planning, and back.

A plan of kabo is a graph that may branch later than it senses; a `ContingentPlan` is a tree that branches behind sensing
actions: nodes are repeated for it, as often as there are branches. Where a sensing action has no child for an outcome,
the plan ends there: the goal is reached, or the outcome is impossible.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from unified_planning.model import ContingentProblem, SensingAction
from unified_planning.plans import ActionInstance, ContingentPlan, ContingentPlanNode, SequentialPlan

from kabo.errors import Diagnostic, InputError
from kabo.language import formulas as f
from kabo.language import spell_bound
from kabo.options import Options
from kabo.plan import Node, Plan, PlanBuilder, ValueOf, plan_statistics
from kabo.up.problems import Translation

MAX_LEAVES = 10_000  # of a tree
Known = Mapping[str, str]  # fact -> outcome


def plan_to_up(plan: Plan, translation: Translation) -> Any:
    """The plan as a `ContingentPlan`, or as a `SequentialPlan` if the problem is not contingent.

    Args:
        plan: a plan of `translation.problem`.
        translation: the problem, as `problem_from_up` gives it.

    Raises:
        InputError: the plan belongs to another problem, begins in the state of a run, or its tree is too large.
    """
    if plan.done:
        raise _error("the plan begins in the state of a run, where the problem does not begin")
    leaves = plan_statistics(plan).plan_leaves
    if leaves > MAX_LEAVES:
        raise _error(f"as a tree the plan has {leaves} branches, more than {MAX_LEAVES}")
    writer = _Writer(plan, translation)
    try:
        if isinstance(translation.original, ContingentProblem):
            return ContingentPlan(writer.tree(plan.root, {}), translation.original.environment)
        return SequentialPlan(list(writer.sequence()), translation.original.environment)
    except (KeyError, _Impossible) as error:
        raise _error(f"the plan is none of this problem: {error}") from error


def plan_from_up(plan: Any, translation: Translation) -> Plan:
    """A `SequentialPlan` or `ContingentPlan` of unified-planning as a plan of kabo, which `kabo.verify` judges.

    Args:
        plan: a plan for `translation.original`.
        translation: the problem, as `problem_from_up` gives it.

    Raises:
        InputError: it is another kind of plan, or uses what the problem does not have.
    """
    reader = _Reader(translation)
    if isinstance(plan, SequentialPlan):
        root = reader.sequence(plan.actions)
    elif isinstance(plan, ContingentPlan):
        root = reader.tree(plan.root_node)
    else:
        raise _error(f"a {type(plan).__name__} is neither a SequentialPlan nor a ContingentPlan")
    problem = translation.problem
    options = Options.of({"geometry": "none"}).written()
    return reader.builder.build(root, problem=problem.name, files=problem.files, options=options)


def _error(message: str) -> InputError:
    return InputError([Diagnostic("plan", 1, 1, message)])


class _Impossible(Exception):
    """Raised where a plan has no branch for an outcome: it cannot come about."""


# ---------------------------------------------------------------------------------------------------- from kabo's
@dataclass
class _Writer:
    plan: Plan
    translation: Translation
    facts: dict[str, Any] = field(default_factory=dict)  # what is sensed, as it is spelled -> unified-planning's

    def sequence(self) -> Iterator[ActionInstance]:
        """The actions of a plan without branches."""
        name = self.plan.root
        while self.plan.nodes[name].kind != "goal":
            node = self.plan.nodes[name]
            if node.next is None:
                raise _Impossible(f"{node.on} is sensed, but the problem is not contingent")
            yield self.instance(node, {})
            name = node.next

    def tree(self, name: str, known: Known) -> Any:
        """The tree of the continuation at a node, with the outcomes that are known by then; None at the goal."""
        first = last = None
        while True:
            node = self.plan.nodes[name]
            if node.kind == "goal":
                return first
            if node.kind == "branch":
                name = _followed(node, known)
                continue
            made = ContingentPlanNode(self.instance(node, known))
            if last is not None:
                last.add_child({}, made)
            first, last = first or made, made
            ways = list(self._ways(node, known)) if node.kind == "sense" else []
            if ways:
                for seen, child in ways:
                    if child is not None:
                        made.add_child(seen, child)
                return first
            assert node.next is not None  # nothing is decided by what was sensed
            name = node.next

    def _ways(self, node: Node, known: Known) -> Iterator[tuple[Any, Any]]:
        """What may be seen at a sense node, as unified-planning says it, each with the tree of how it goes on."""
        facts = self._learn(node)
        at_once = {} if node.on is None else {node.on: list(node.branches)}
        outcomes = at_once | self._decided_later(node, [fact for fact in facts if fact != node.on])
        if not outcomes:
            return
        possible = 0
        for combination in product(*outcomes.values()):
            seen = dict(zip(outcomes, combination, strict=True))
            following = node.branches[combination[0]] if node.branches else node.next
            assert following is not None
            try:
                child = self.tree(following, {**known, **seen})
            except _Impossible:
                continue
            possible += 1
            yield (
                {self.facts[fact]: self._value(self.facts[fact], outcome) for fact, outcome in seen.items()},
                child,
            )
        if not possible:
            raise _Impossible(f"nothing can be seen by {node.action}")

    def _decided_later(self, node: Node, facts: Sequence[str]) -> dict[str, list[str]]:
        """Those of some facts that a node senses on which the plan branches later, before it senses them anew."""
        found: dict[str, list[str]] = {}
        for fact in facts:
            waiting, seen = list(node.successors), set()
            while waiting:
                name = waiting.pop()
                if name in seen:
                    continue
                seen.add(name)
                here = self.plan.nodes[name]
                if here.kind == "branch" and here.on == fact:
                    found.setdefault(fact, []).extend(here.branches)
                if fact != here.on and fact not in here.delivers:
                    waiting += here.successors
        return {fact: list(dict.fromkeys(outcomes)) for fact, outcomes in found.items()}

    def instance(self, node: Node, known: Known) -> ActionInstance:
        """A node as an action of unified-planning; a value that is sensed before is that which `known` has."""
        assert node.action is not None
        names, original = self.translation.names, self.translation.original
        action = names.action_of(original, node.action)
        values = [
            self._argument(node.arguments[each], kind.type, known) for each, kind in self._parameters(node, action)
        ]
        return ActionInstance(action, tuple(values))

    def _parameters(self, node: Node, action: Any) -> Iterator[tuple[str, Any]]:
        assert node.action is not None
        own = self.translation.problem.domain.actions[node.action].parameters
        return zip((each.name for each in own), action.parameters, strict=True)

    def _argument(self, value: str | float | ValueOf, kind: Any, known: Known) -> Any:
        if isinstance(value, ValueOf) and value.term not in known:
            return self.facts[value.term]  # what was sensed, whatever it is
        return self._object(known[value.term] if isinstance(value, ValueOf) else str(value), kind)

    def _object(self, name: str, kind: Any) -> Any:
        """The object of a type that has this name in kabo: values of two functions may be called the same."""
        original, names = self.translation.original, self.translation.names.objects
        found = next((each for each in original.objects(kind) if names[each.name] == name), None)
        if found is None:
            raise KeyError(name)
        return original.environment.expression_manager.ObjectExp(found)

    def _learn(self, node: Node) -> list[str]:
        """The facts that a node senses, by their spelling in the plan; keeps what they are in unified-planning."""
        assert node.action is not None
        binding = {name: getattr(value, "term", str(value)) for name, value in node.arguments.items()}
        sensed = self.translation.problem.domain.actions[node.action].sense
        found = {spell_bound(each, binding): self._fluent(each, node.arguments) for each in sensed}
        self.facts |= found
        return list(found)

    def _fluent(self, sensed: f.Atom | f.Application, arguments: Mapping[str, Any]) -> Any:
        names, original = self.translation.names, self.translation.original
        name = sensed.predicate if isinstance(sensed, f.Atom) else sensed.function
        objects = []
        for each in sensed.arguments:
            if not isinstance(each, f.Variable | f.Constant):
                raise _error(f"the arguments of what {name} senses are computed: not supported")
            own = str(arguments[each.name]) if isinstance(each, f.Variable) else each.name
            objects.append(names.object_of(original, own))
        return names.fluent_of(original, name)(*objects)

    def _value(self, fact: Any, outcome: str) -> Any:
        manager = self.translation.original.environment.expression_manager
        if fact.type.is_bool_type():
            return manager.Bool(outcome == "true")
        return self._object(outcome, fact.type)


def _followed(node: Node, known: Known) -> str:
    """Where a branch node leads to, by what is known."""
    outcome = known.get(node.on or "")
    if outcome is None or outcome not in node.branches:
        raise _Impossible(f"{node.on} cannot be {outcome}")
    return node.branches[outcome]


# ------------------------------------------------------------------------------------------------------ to kabo's
@dataclass
class _Reader:
    translation: Translation
    builder: PlanBuilder = field(default_factory=PlanBuilder)

    def sequence(self, actions: Sequence[Any]) -> str:
        """The handle of the first of several actions in a row."""
        following = self.builder.goal()
        for each in reversed(actions):
            following = self._added(each, [({}, following)])
        return following

    def tree(self, root: Any) -> str:
        """The handle of a tree's root."""
        done: dict[int, str] = {}
        waiting = [] if root is None else [root]
        while waiting:
            node = waiting[-1]
            missing = [child for _, child in node.children if id(child) not in done]
            if missing:
                waiting += missing
                continue
            done[id(waiting.pop())] = self._added(
                node.action_instance, [(seen, done[id(child)]) for seen, child in node.children]
            )
        return self.builder.goal() if root is None else done[id(root)]

    def _added(self, instance: Any, ways: list[tuple[Any, str]]) -> str:
        """The handle of an action with its continuations by what is seen; no continuation is the goal."""
        name = self.translation.names.actions.get(instance.action.name)
        if name is None:
            raise _error(f'the problem has no action "{instance.action.name}"')
        action, objects = self.translation.problem.domain.actions[name], self.translation.names.objects
        values = [objects[each.object().name] for each in instance.actual_parameters]
        arguments = {each.name: value for each, value in zip(action.parameters, values, strict=True)}
        if not isinstance(instance.action, SensingAction):
            following = ways[0][1] if ways else self.builder.goal()
            return self.builder.add(Node("action", name, arguments, following))
        facts = [spell_bound(each, arguments) for each in action.sense]
        told = [
            ({self._spelled(key): self._outcome(value) for key, value in seen.items()}, way) for seen, way in ways
        ]
        if len(facts) == 1 and any(seen for seen, _ in told):
            return self.builder.add(
                Node("sense", name, arguments, on=facts[0], branches=self._split(facts[0], told))
            )
        return self.builder.add(Node("sense", name, arguments, self._decided(told), delivers=tuple(facts)))

    def _decided(self, told: list[tuple[dict[str, str], str]]) -> str:
        """The handle of the nodes that tell several observations apart, one fact after the other."""
        fact = next((fact for seen, _ in told for fact in seen), None)
        if fact is None:
            return told[0][1] if told else self.builder.goal()
        return self.builder.add(Node("branch", on=fact, branches=self._split(fact, told)))

    def _split(self, fact: str, told: list[tuple[dict[str, str], str]]) -> dict[str, str]:
        branches = {}
        for outcome in self._outcomes(fact):
            rest = [
                ({key: value for key, value in seen.items() if key != fact}, way)
                for seen, way in told
                if seen.get(fact, outcome) == outcome
            ]
            branches[outcome] = self._decided(rest)
        return branches

    def _outcomes(self, fact: str) -> tuple[str, ...]:
        problem = self.translation.problem
        name = fact.split("(", maxsplit=1)[0]
        if name in problem.domain.predicates:
            return ("false", "true")
        return problem.values_of(name) or ()

    def _spelled(self, node: Any) -> str:
        names = self.translation.names
        arguments = tuple(f.Constant(names.objects[each.object().name]) for each in node.args)
        name = names.fluents[node.fluent().name]
        sensed = f.Atom(name, arguments) if node.type.is_bool_type() else f.Application(name, arguments)
        return spell_bound(sensed, {})

    def _outcome(self, value: Any) -> str:
        if value.is_bool_constant():
            return "true" if value.bool_constant_value() else "false"
        return self.translation.names.objects[value.object().name]
