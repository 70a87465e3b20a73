"""The state of a run: what was done and observed since the problem began, and where everything is now.

A plan may begin in such a state in place of the problem's start. Knowledge is not written down: whoever needs it follows
`done` from the initial knowledge, the planner by its own rules and the verifier by its own.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from numbers import Real
from pathlib import Path

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.given import as_float, read_file, require_given, require_output, shown
from kabo.plan.checked_json import JsonValue, read_checked
from kabo.plan.plan import Done, Node, ObjectPose, Plan, StateChange
from kabo.plan.reading import done_from_json, state_from_json
from kabo.plan.writing import canonical, done_to_json, rounded_state, state_to_json
from kabo.whole_files import write_atomically

FORMAT = "kabo-state/1"
_OTHER_FILES = {
    "kabo-plan": ("a plan", "`kabo execute --state` and `kabo.after` make the state of a run of it"),
    "kabo-task": ("a report of a task", "`kabo execute --state` writes the state of a run"),
}

History = Sequence[
    tuple[str, str | None]
]  # nodes of a plan in order, each with the outcome that was observed, if any


@dataclass(frozen=True)
class State:
    """What a run has come to.

    Attributes:
        done: all steps since the problem began, in order.
        geometry: where every robot and every movable object is; None for a problem without a scene.
    """

    done: tuple[Done, ...] = ()
    geometry: StateChange | None = None

    def save(self, path: str | Path) -> None:
        """Writes the state's file, completely or not at all; `kabo.load_state` reads it.

        Raises:
            InputError: `path` is no file in a folder that exists; or a robot or an object is at a number that is not
                finite, which no file holds.
            OSError: the file cannot be written.
        """
        if self.geometry is not None and (faults := list(_not_finite(self.geometry))):
            raise InputError(faults)
        write_atomically(require_output("path", path), canonical(state_file(self)) + b"\n")


def state_after(
    plan: Plan,
    history: History = (),
    *,
    robots: Mapping[str, Mapping[str, float]] = {},
    objects: Mapping[str, ObjectPose] = {},
) -> State:
    """The state of a run after some nodes of a plan.

    Args:
        plan: the plan; it may itself begin in the state of a run.
        history: the nodes that were done, from the root on, each with the outcome that was observed or None, as
            `kabo.execution.Run.history` has them.
        robots: where robots are now, in place of where the plan has them: values by joint [rad or m].
        objects: where objects are now, in place of where the plan has them.

    Raises:
        InputError: the history is no way through the plan, the plan has no such robot, joint or object, or one of them
            is at a number that is not finite.
    """
    for name, given, kind in (("robots", robots, Mapping), ("objects", objects, ObjectPose)):
        require_given(name, given, Mapping)
        for own, each in given.items():
            require_given(f"{name}[{own!r}]", each, kind)
    done, now = list(plan.done or ()), plan.start
    for name, node, outcome in _followed(plan, history):
        if node.action is not None or node.on is not None:
            done.append(Done(node.action, dict(node.arguments), None if outcome is None else node.on, outcome))
        if now is not None and node.after is not None:
            now = changed(now, node.after)
        if node.kind == "goal":
            raise _fault(f"{name} is the goal: nothing is done there", None)
    change = StateChange(robots, objects)
    _require_known(plan.start or StateChange({}, {}), change)
    return State(tuple(done), None if now is None else changed(now, change))


def _require_known(start: StateChange, change: StateChange) -> None:
    """Checks that a plan has the robots, joints and objects that a change names, and that they are somewhere.

    Raises:
        InputError: it has no such ones, or they are at a number that is not finite.
    """
    kinds = [("robot", change.robots, start.robots), ("movable object", change.objects, start.objects)]
    kinds += [
        (f"joint of {name}", change.robots[name], own)
        for name, own in start.robots.items()
        if name in change.robots
    ]
    faults = [
        Diagnostic("state", 1, 1, f"the plan has no {kind} {name}", did_you_mean(name, known))
        for kind, names, known in kinds
        for name in names
        if name not in known
    ]
    faults += _not_finite(change)
    if faults:
        raise InputError(faults)


def _not_finite(change: StateChange) -> Iterator[Diagnostic]:
    """A diagnostic for each joint and each object that is at NaN or at infinity."""
    for name, joints in change.robots.items():
        for joint, value in joints.items():
            if not _is_finite(value):
                yield Diagnostic(
                    "state", 1, 1, f"{joint} of {name} is at {shown(value)}", "a finite number [rad or m]"
                )
    for name, pose in change.objects.items():
        if not all(map(_is_finite, (*pose.position, *pose.quaternion))):
            yield Diagnostic("state", 1, 1, f"the pose of {name} has a number that is not finite", None)


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and isfinite(as_float(value))


def changed(state: StateChange, change: StateChange) -> StateChange:
    """The state with the joints and objects that a change names as it has them."""
    robots = {name: {**joints, **change.robots.get(name, {})} for name, joints in state.robots.items()}
    return replace(state, robots=robots, objects={**state.objects, **change.objects})


def _followed(plan: Plan, history: History) -> Iterable[tuple[str, Node, str | None]]:
    """The nodes of the history, each with its outcome.

    Raises:
        InputError: they are no way through the plan.
    """
    expected: str | None = plan.root
    require_given("history", history, Sequence)
    for number, step in enumerate(history, start=1):
        if not isinstance(step, list | tuple) or len(step) != 2 or not isinstance(step[0], str):
            text = f"step {number} is {step!r}, and not a node with the outcome that was observed, or None"
            raise _fault(text, "for example [('n0', 'true'), ('n2', None)]")
        name, outcome = step
        node = plan.nodes.get(name)
        if node is None:
            raise _fault(f"the plan has no node {name}", did_you_mean(name, plan.nodes))
        if name != expected:
            raise _fault(f"{name} does not follow there", f"{expected} does")
        if node.on is None and outcome is not None:
            raise _fault(f"{name} observes nothing, but has the outcome {outcome}", None)
        if node.on is not None and outcome not in node.branches:
            said = "is missing" if outcome is None else f"is none that the plan has a branch for: {outcome}"
            raise _fault(f"the outcome of {node.on} at {name} {said}", f"one of {', '.join(node.branches)}")
        yield name, node, outcome
        expected = node.next if outcome is None else node.branches.get(outcome)


def _fault(text: str, hint: str | None) -> InputError:
    return InputError([Diagnostic("history", 1, 1, text, hint)])


# ------------------------------------------------------------------------------------------------------------ files
def state_file(state: State) -> dict[str, object]:
    """The state as the JSON object of its file."""
    body: dict[str, object] = {"format": FORMAT, "done": [done_to_json(each) for each in state.done]}
    return body if state.geometry is None else body | {"geometry": state_to_json(rounded_state(state.geometry))}


def load_state(path: str | Path) -> State:
    """The state in a file, as `State.save` or `kabo execute --state` wrote it.

    Args:
        path: the file.

    Raises:
        InputError: the file cannot be read, or its form is wrong; has all findings with their JSON paths.
    """
    return read_checked(read_file("path", path), str(path), _state)


def _state(place: JsonValue) -> State:
    place.refuse_other_files("the state of a run", _OTHER_FILES)
    fields = place.fields(("format", "done"), ("geometry",))
    if "format" in fields and fields["format"].value != FORMAT:
        fields["format"].add_finding(f'expected "{FORMAT}"', "this file is of another version, or no state")
    geometry = state_from_json(fields["geometry"], ("robots", "objects")) if "geometry" in fields else None
    return State(tuple(map(done_from_json, fields["done"].items())), geometry)
