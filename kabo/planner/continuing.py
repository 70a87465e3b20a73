"""Plans that begin in the state of a run, after what was done and observed [K 6.1.3]."""

from collections.abc import Iterable, Mapping

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.given import require_all
from kabo.knowledge import Branching, GroundAction, GroundedTask
from kabo.knowledge.actions import RunTimeArgument
from kabo.language.problem import Problem
from kabo.plan import Done, History, ObjectPose, Plan, State, ValueOf, state_after


def after(
    problem: Problem,
    plan: Plan,
    history: History = (),
    *,
    robots: Mapping[str, Mapping[str, float]] = {},
    objects: Mapping[str, ObjectPose] = {},
) -> State:
    """The state of a run after some nodes of a plan: where `kabo.solve(problem, start=state)` begins.

    Args:
        problem: the problem.
        plan: a plan of it; it may itself begin in the state of a run.
        history: the nodes that were done, from the root on, each with the outcome that was observed or None, as
            `kabo.execution.Run.history` has them.
        robots: where robots are now, in place of where the plan has them: values by joint [rad or m].
        objects: where objects are now, in place of where the plan has them.

    Raises:
        InputError: the plan is of another problem, the history is no way through it, or it has no such robot, joint or
            object.

    Example:
        >>> problem = kabo.load_problem("domains/grid/n3.yaml")
        >>> plan = kabo.solve(problem).plan
        >>> state = kabo.after(problem, plan, [(plan.root, None)])
        >>> len(state.done)
        1
        >>> kabo.solve(problem, start=state)
        <Result solved: 10 nodes, 2 outcomes, 8 actions at most>
    """
    require_of(problem, plan)
    return state_after(plan, history, robots=robots, objects=objects)


def require_of(problem: Problem, plan: Plan) -> None:
    """Checks that a plan is of a problem.

    Raises:
        ArgumentError: one of them is of a wrong kind.
        InputError: it is of another one.
    """
    require_all(problem=(problem, Problem), plan=(plan, Plan))
    if plan.problem != problem.name:
        text = f"the plan is of {plan.problem}, not of {problem.name}"
        raise InputError([Diagnostic("plan", 1, 1, text, "give the problem of which it was made")])


def knowledge_after(task: GroundedTask, done: Iterable[Done]) -> int:
    """The knowledge state after steps of a run.

    Args:
        task: the grounded problem.
        done: the steps, in order.

    Raises:
        InputError: a step is none of the problem, was not applicable, or observed what was known to be otherwise.
    """
    actions = {action_key(action.name, action.arguments): action for action in task.actions}
    branchings = {each.fact: each for each in task.branchings.values()}
    state = task.initial
    for number, step in enumerate(done, start=1):
        if step.action is not None:
            state = _acted(number, step, state, actions)
        if step.on is not None:
            state = _observed(number, step, state, branchings)
    return state


def _acted(number: int, step: Done, state: int, actions: Mapping[object, GroundAction]) -> int:
    action = actions.get(action_key(str(step.action), step.arguments))
    text = f"{step.action}({', '.join(map(str, map(_text, step.arguments.values())))})"
    if action is None:
        names = {each.name for each in actions.values()}
        known = (f"{each.name}({', '.join(map(str, each.arguments.values()))})" for each in actions.values())
        hint = did_you_mean(text, known) if step.action in names else did_you_mean(str(step.action), names)
        raise _fault(number, f"{text} is no action that matters in this problem", hint)
    if not action.applicable(state):
        raise _fault(number, f"the preconditions of {text} did not hold", None)
    after = action.after(state)
    if after is None:
        raise _fault(number, f"{text} contradicts what was known", None)
    return after


def _observed(number: int, step: Done, state: int, branchings: Mapping[str, Branching]) -> int:
    branching = branchings.get(str(step.on))
    if branching is None:
        hint = did_you_mean(str(step.on), branchings)
        raise _fault(number, f"{step.on} is nothing that can be observed", hint)
    for choice in branching.choices:
        if choice.outcome == step.outcome:
            after = branching.after(state, choice)
            if after is None:
                raise _fault(number, f"that {step.on} is {step.outcome} contradicts what was known", None)
            return after
    outcomes = ", ".join(choice.outcome for choice in branching.choices)
    raise _fault(number, f"{step.outcome} is no value of {step.on}", f"one of {outcomes}")


def action_key(name: str, arguments: Mapping[str, object]) -> object:
    """A key by which actions of plans and of the grounded problem are found to be the same."""
    return name, tuple(sorted((parameter, _text(value)) for parameter, value in arguments.items()))


def _text(value: object) -> object:
    return ("value of", value.term) if isinstance(value, RunTimeArgument | ValueOf) else value


def _fault(number: int, text: str, hint: str | None) -> InputError:
    return InputError([Diagnostic("state", 1, 1, f"step {number} of what was done: {text}", hint)])
