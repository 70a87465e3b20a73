"""unified-planning as the judge of plans: its simulator and its validator, in every world that a problem allows."""

import random
from collections.abc import Iterator
from itertools import islice, product

from unified_planning.engines import SequentialSimulatorMixin, ValidationResultStatus
from unified_planning.engines.plan_validator import SequentialPlanValidator
from unified_planning.engines.sequential_simulator import UPSequentialSimulator
from unified_planning.model import ContingentProblem, InstantaneousAction, Problem, SensingAction
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


def holds(literal, world) -> bool:
    return not world[literal.arg(0)] if literal.is_not() else world[literal]


def fits(problem, world) -> bool:
    """Whether a world fulfils what is known of the start."""
    exactly = all(sum(holds(each, world) for each in one) == 1 for one in problem.oneof_constraints)
    return exactly and all(any(holds(each, world) for each in one) for one in problem.or_constraints)


def all_worlds(problem) -> Iterator[dict]:
    """Every assignment to the hidden fluents that fulfils the constraints: members of `oneof` are chosen first."""
    atoms = hidden_atoms(problem)
    chosen_first = [one for one in problem.oneof_constraints]
    for choice in product(*chosen_first):
        world = {}
        consistent = True
        for one, picked in zip(chosen_first, choice, strict=True):
            for each in one:
                atom, value = (each.arg(0), each is not picked) if each.is_not() else (each, each is picked)
                consistent &= world.setdefault(atom, value) == value
        if consistent:
            free = [each for each in atoms if each not in world]
            for values in product((False, True), repeat=len(free)):
                whole = world | dict(zip(free, values, strict=True))
                if fits(problem, whole):
                    yield whole


def drawn_worlds(problem, seed: int, number: int) -> Iterator[dict]:
    """Worlds drawn at random."""
    source = random.Random(seed)
    atoms = hidden_atoms(problem)
    found = 0
    for _ in range(1000 * number):
        world = {each: source.random() < 0.5 for each in atoms}
        for one in problem.oneof_constraints:
            picked = source.choice(one)
            for each in one:
                atom, value = (each.arg(0), each is not picked) if each.is_not() else (each, each is picked)
                world[atom] = value
        if fits(problem, world):
            found += 1
            yield world
        if found == number:
            return


def worlds(problem, seed: int = 0, number: int = ALL) -> list[dict]:
    """All worlds of a problem, or `number` of them, drawn at random, if there are more."""
    some = list(islice(all_worlds(problem), number + 1))
    return some if len(some) <= number else list(drawn_worlds(problem, seed, number))


def in_world(problem: ContingentProblem, world: dict) -> Problem:
    """The classical problem whose initial state is one world; sensing actions sense nothing there."""
    made = Problem(problem.name, problem.environment)
    made._user_types, made._user_types_hierarchy = problem._user_types[:], dict(problem._user_types_hierarchy)
    for each in problem.fluents:
        made.add_fluent(each)
    made.add_objects(problem.all_objects)
    for action in problem.actions:
        made.add_action(without_sensing(action))
    hidden = set(hidden_atoms(problem))
    for fluent, value in problem.initial_values.items() if not hidden else _known_values(problem, hidden):
        made.set_initial_value(fluent, value)
    for fluent, value in world.items():
        made.set_initial_value(fluent, value)
    for goal in problem.goals:
        made.add_goal(goal)
    return made


def _known_values(problem, hidden):
    from unified_planning.model.fluent import get_all_fluent_exp

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
