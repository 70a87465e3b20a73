"""Small random problems of unified-planning, classical and contingent, from a seed."""

import random

from unified_planning.model import ContingentProblem, InstantaneousAction, Object, Problem, SensingAction
from unified_planning.shortcuts import (
    And,
    BoolType,
    Equals,
    Exists,
    Fluent,
    Forall,
    Iff,
    Not,
    Or,
    UserType,
    Variable,
)


def random_problem(seed: int, *, contingent: bool):
    """A problem with two kinds of fluents, five actions with all kinds of conditions and effects, and one or two goals."""
    source = random.Random(f"{contingent} {seed}")
    thing = UserType("Thing")
    problem = (ContingentProblem if contingent else Problem)(f"Random-{seed}")
    is_on, tied, held = Fluent("is-On", BoolType(), t=thing), Fluent("when", BoolType()), Fluent("HELD", thing)
    problem.add_fluent(is_on, default_initial_value=False)
    problem.add_fluent(tied, default_initial_value=False)
    objects = problem.add_objects([Object(name, thing) for name in ("a", "B-2", "and")]) or problem.all_objects
    problem.add_fluent(held, default_initial_value=objects[0])
    for number in range(5):
        senses = contingent and number < 2
        action = (SensingAction if senses else InstantaneousAction)(f"Act-{number}", t=thing)
        parameter = action.parameter("t")
        atoms = [is_on(parameter), tied(), is_on(source.choice(objects))]
        if not contingent:  # of what may be unknown, kabo changes atoms only
            atoms.append(Equals(held(), parameter))
        for _ in range(source.randrange(2)):
            action.add_precondition(condition(source, atoms, is_on, thing))
        if senses:
            action.add_observed_fluent(source.choice([is_on(parameter), tied()]))
        else:
            for _ in range(source.randint(1, 2)):
                effect(source, action, atoms, is_on, thing, held, contingent)
        problem.add_action(action)
    if contingent:
        hidden = [is_on(each) for each in objects]
        source.choice([problem.add_oneof_initial_constraint, problem.add_or_initial_constraint])(hidden[:2])
        if source.random() < 0.3:
            problem.add_unknown_initial_constraint(hidden[2])
    goals = [is_on(each) if source.random() < 0.7 else Not(is_on(each)) for each in source.sample(objects, 2)]
    for each in goals[: source.randint(1, 2)]:
        problem.add_goal(each)
    return problem


def condition(source, atoms, is_on, thing):
    """A condition of any form."""
    first, second = source.choice(atoms), source.choice(atoms)
    variable = Variable("v", thing)
    return source.choice(
        [first, Not(first), Or(first, Not(second)), And(first, second), Iff(first, second)]
        + [Exists(is_on(variable), variable), Not(Forall(is_on(variable), variable))]
    )


def effect(source, action, atoms, is_on, thing, held, contingent) -> None:
    """An effect: plain, conditional, computed, for all objects, or on a fluent with objects as values."""
    changed, value = atoms[source.randrange(3)], source.random() < 0.6
    form = source.randrange(5)
    if form == 1:
        action.add_effect(changed, value, source.choice(atoms))
    elif form == 2 and not contingent:
        action.add_effect(changed, Or(source.choice(atoms), Not(source.choice(atoms))))
    elif form == 3:
        variable = Variable("v", thing)
        action.add_effect(is_on(variable), value, forall=[variable])
    elif form == 4 and not contingent:
        action.add_effect(held(), action.parameter("t"))
    else:
        action.add_effect(changed, value)
