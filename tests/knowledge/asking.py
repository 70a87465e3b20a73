"""Asks what is known after some steps, through the public door of the room only.

A step is an action, `name(arguments)`, or an outcome of a branching, `fact: outcome`.
"""

from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.support.small_problems import problem


def then(conditions, outcomes):
    """The effect `when … then …`; one claim or a tuple of them."""
    both = [claims if isinstance(claims, tuple) else (claims,) for claims in (conditions, outcomes)]
    return f.WorldEffect(*both)


def branching_on(task, fact):
    """The branching on a fact, named as in plans."""
    return next(one for one in task.branchings.values() if one.fact == fact)


def outcomes(task, state, fact):
    """The names of the outcomes that are possible in a state."""
    return [name for name, _ in branching_on(task, fact).outcomes(state)]


def state_after(task, *steps):
    """The knowledge state after the steps, each of which must be possible."""
    state = task.initial
    for name in steps:
        if ": " in name:
            fact, outcome = name.split(": ")
            possible = dict(branching_on(task, fact).outcomes(state))
            assert outcome in possible, f"{name} is not possible"
            state = possible[outcome]
            continue
        action = next(action for action in task.actions if str(action) == name)
        assert action.applicable(state), f"{name} is not applicable"
        state = action.after(state)
        assert state is not None, f"{name} contradicts itself"
    return state


def holds(formula, *steps, **pieces):
    """Whether a query holds after the steps of the problem made of the pieces."""
    task = ground(problem(goal=(formula,), **pieces))
    return task.is_goal(state_after(task, *steps))


def applicable(name, **pieces):
    """Whether an action is applicable in the first state."""
    task = ground(problem(**pieces))
    return any(str(action) == name and action.applicable(task.initial) for action in task.actions)
