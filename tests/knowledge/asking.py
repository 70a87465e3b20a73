"""Asks what is known after some actions, through the public door of the room only."""

from kabo.knowledge import ground
from tests.small_problems import problem


def state_after(task, *steps):
    """The knowledge state after actions, named as `name(arguments)`, each of which must be applicable."""
    state = task.initial
    for name in steps:
        action = next(action for action in task.actions if str(action) == name)
        assert action.applicable(state), f"{name} is not applicable"
        state = action.after(state)
    return state


def holds(formula, *steps, **pieces):
    """Whether a query holds after the steps of the problem made of the pieces."""
    task = ground(problem(goal=(formula,), **pieces))
    return task.is_goal(state_after(task, *steps))


def applicable(name, **pieces):
    """Whether an action is applicable in the first state."""
    task = ground(problem(**pieces))
    return any(str(action) == name and action.applicable(task.initial) for action in task.actions)
