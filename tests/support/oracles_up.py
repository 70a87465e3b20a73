"""unified-planning as the judge of plans: its simulator and its validator, in every world that a problem allows."""

import random
from collections.abc import Iterator
from itertools import islice

from unified_planning.engines import SequentialSimulatorMixin, ValidationResultStatus
from unified_planning.engines.plan_validator import SequentialPlanValidator
from unified_planning.engines.sequential_simulator import UPSequentialSimulator
from unified_planning.model import ContingentProblem, InstantaneousAction, Problem, SensingAction
from unified_planning.model.fluent import get_all_fluent_exp
from unified_planning.plans import ActionInstance, SequentialPlan

ALL = 512  # worlds that are looked at one by one; of more, so many are drawn


def is_valid(problem, plan) -> bool:
    """Whether unified-planning's validator accepts a plan without branches."""
    validator = SequentialPlanValidator()
    validator.skip_checks = True
    return validator.validate(problem, plan).status == ValidationResultStatus.VALID


def hidden_atoms(problem: ContingentProblem) -> list:
    """The fluents that are not known at the start, in an order that does not depend on hashes."""
    return sorted({each.arg(0) if each.is_not() else each for each in problem.hidden_fluents}, key=str)


def constraints_of(problem) -> list[tuple[list, bool]]:
    """What is known of the start: literals, of which exactly one (True) or at least one (False) holds."""
    return [(one, True) for one in problem.oneof_constraints] + [(one, False) for one in problem.or_constraints]


def possible(literals, exactly: bool, world: dict) -> bool:
    """Whether a constraint may still hold in a world of which only some atoms are decided."""
    sides = [(each.arg(0), False) if each.is_not() else (each, True) for each in literals]
    true = sum(atom in world and world[atom] == positive for atom, positive in sides)
    open_ = sum(atom not in world for atom, _ in sides)
    return true + open_ >= 1 and not (exactly and true > 1)


def all_worlds(problem, source: random.Random | None = None) -> Iterator[dict]:
    """Every assignment to the hidden fluents that fulfils the constraints, in an order that `source` shuffles."""
    atoms = hidden_atoms(problem)
    about: dict = {each: [] for each in atoms}
    for literals, exactly in constraints_of(problem):
        for each in literals:
            about[each.arg(0) if each.is_not() else each].append((literals, exactly))
    tied = constraints_of(problem)
    if source is not None:
        source.shuffle(tied)
    near = [each.arg(0) if each.is_not() else each for literals, _ in tied for each in literals]
    order = list(dict.fromkeys([*near, *atoms]))  # those of one constraint one after the other

    def from_here(number: int, world: dict) -> Iterator[dict]:
        if number == len(order):
            yield dict(world)
            return
        values = [False, True] if source is None else source.sample([False, True], 2)
        for value in values:
            world[order[number]] = value
            if all(possible(literals, exactly, world) for literals, exactly in about[order[number]]):
                yield from from_here(number + 1, world)
            del world[order[number]]

    yield from from_here(0, {})


def worlds(problem, seed: int = 0, number: int = ALL) -> list[dict]:
    """All worlds of a problem, or `number` of them, drawn at random, if there are more."""
    some = list(islice(all_worlds(problem), number + 1))
    if len(some) <= number:
        return some
    return [next(all_worlds(problem, random.Random(f"{seed} {each}"))) for each in range(number)]


def in_world(problem: ContingentProblem, world: dict) -> Problem:
    """The classical problem whose initial state is one world; sensing actions sense nothing there."""
    made = Problem(problem.name, problem.environment)
    made._user_types, made._user_types_hierarchy = problem._user_types[:], dict(problem._user_types_hierarchy)
    for each in problem.fluents:
        made.add_fluent(each)
    made.add_objects(problem.all_objects)
    for action in problem.actions:
        made.add_action(without_sensing(action))
    hidden = {each.arg(0) if each.is_equals() else each for each in hidden_atoms(problem)}
    for fluent, value in _known_values(problem, hidden):
        made.set_initial_value(fluent, value)
    for atom, value in world.items():
        if not atom.is_equals():
            made.set_initial_value(atom, value)
        elif value:
            made.set_initial_value(atom.arg(0), atom.arg(1))
    for goal in problem.goals:
        made.add_goal(goal)
    return made


def _known_values(problem, hidden):
    for fluent in problem.fluents:
        for each in get_all_fluent_exp(problem, fluent):
            if each not in hidden:
                yield each, problem.initial_value(each)


def without_sensing(action) -> InstantaneousAction:
    if not isinstance(action, SensingAction):
        return action
    made = InstantaneousAction(action.name, {each.name: each.type for each in action.parameters})
    made._preconditions, made._effects = action.preconditions[:], [each.clone() for each in action.effects]
    return made


def failure(problem: ContingentProblem, plan, world: dict) -> str:
    """Why a contingent plan fails in one world, or nothing: walked by the simulator, then judged by the validator."""
    classical = in_world(problem, world)
    simulator: SequentialSimulatorMixin = UPSequentialSimulator(classical, error_on_failed_checks=False)
    state, node, done = simulator.get_initial_state(), plan.root_node, []
    while node is not None:
        action = classical.action(node.action_instance.action.name)
        instance = ActionInstance(action, node.action_instance.actual_parameters)
        done.append(instance)
        state = simulator.apply(state, instance)
        if state is None:
            return f"{instance} cannot be done"
        following = [
            child for seen, child in node.children
            if all(state.get_value(fluent) == value for fluent, value in seen.items())
        ]  # fmt: skip
        if len(following) > 1:
            return f"{instance} goes on in {len(following)} ways"
        node = following[0] if following else None
    return "" if is_valid(classical, SequentialPlan(done, problem.environment)) else f"invalid: {done}"


def failures(problem, plan, seed: int = 0, number: int = ALL) -> list[str]:
    """Why a plan fails, in each world in which it does."""
    if not isinstance(problem, ContingentProblem):
        return [] if is_valid(problem, plan) else ["invalid"]
    tried = worlds(problem, seed, number)
    assert tried, "no world fulfils the constraints"
    return [why for why in (failure(problem, plan, each) for each in tried) if why]
