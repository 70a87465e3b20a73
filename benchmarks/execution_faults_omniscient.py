"""An omniscient replanner: is there a plan to the goal from where everything truly is at the moment of a fault?

It knows where every body is, seen or not, and what a hand has lost. It is asked for plans from several states, and any plan
will do: from where robots stand; with hands that hold nothing open; with robots where the node began, or where it ends.
So it may do what no run can, as to get out of a contact without a motion: what it calls solvable is more than what any
executor could do.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

import kabo
from kabo.arrays import Array
from kabo.errors import InputError
from kabo.execution import Interruption
from kabo.language.problem import Problem
from kabo.plan import Done, ObjectPose, State, StateChange
from kabo.plan.state import changed
from kabo.planner.geometry.relations import event_of, relations
from kabo.scene import MAX_DISTANCE, Scene, attachment, beginning_at, world_T

SECONDS = 20.0  # of each state


def solvable(problem: Problem, scene: Scene, interruption: Interruption, poses: Mapping[str, Array]) -> str | None:
    """From which state there is a plan, in a word; None: from none.

    Args:
        problem: the problem. scene: its scene. interruption: where the run stood.
        poses: the true poses (4, 4) of all movable bodies then.
    """
    if any(np.abs(pose[:3, 3]).max() > MAX_DISTANCE for pose in poses.values()):
        return None  # it has fallen for so long that nobody plans with it
    for word, state, expected in _states(scene, interruption, poses):
        try:
            begun = _with_events(problem, scene, state, expected)
            if begun is not None and kabo.solve(problem, start=begun, timeout=SECONDS).plan is not None:
                return word
        except (InputError, ValueError):
            continue
    return None


def _states(
    scene: Scene, interruption: Interruption, poses: Mapping[str, Array]
) -> Iterator[tuple[str, State, StateChange | None]]:
    """States that it may begin in, each with where the plan would have everything."""
    state, expected = interruption.state, interruption.expected
    if state.geometry is None:
        yield "symbolic", state, None
        return
    here = _true(scene, state.geometry, poses)
    yield "as it is", replace(state, geometry=here), expected
    opened = _opened(scene, here)
    yield "hands open", replace(state, geometry=opened), expected
    if expected is not None and interruption.executed:
        back = _true(scene, replace(here, robots=expected.robots), poses)
        yield "back", replace(state, geometry=_opened(scene, back)), expected
        node = interruption.plan.nodes[interruption.executed[-1].node]
        placed = set() if node.after is None else node.after.objects.keys()
        missed = {body for body, _ in interruption.lost} | {interruption.surprise.thing}
        if node.after is not None and node.on is None and not placed & missed:
            others = {name: pose for name, pose in poses.items() if name not in placed}
            there = _true(scene, changed(expected, node.after), others)
            done = (*state.done, Done(node.action, dict(node.arguments)))
            yield "on", State(done, there), changed(expected, node.after)


def _true(scene: Scene, geometry: StateChange, poses: Mapping[str, Array]) -> StateChange:
    """A state with bodies that stand where they truly are."""
    objects = dict(geometry.objects)
    for name, pose in poses.items():
        here = beginning_at(scene, replace(geometry, objects=objects))
        own = objects[name]
        if "." in own.parent:
            continue
        seen = world_T(here, here.start, name)
        if float(np.linalg.norm(seen[:3, 3] - pose[:3, 3])) > 2e-3:
            found = attachment("world", pose)
            objects[name] = ObjectPose(found.parent, found.position, found.quaternion)
    return replace(geometry, objects=objects)


def _opened(scene: Scene, geometry: StateChange) -> StateChange:
    """A state in which hands that hold nothing are open."""
    holding = {own.parent.partition(".")[0] for own in geometry.objects.values() if "." in own.parent}
    robots = {name: dict(q) for name, q in geometry.robots.items()}
    for name, robot in scene.robots.items():
        if name not in holding and robot.gripper is not None:
            robots[name] |= robot.gripper.open
    return replace(geometry, robots=robots)


def _with_events(problem: Problem, scene: Scene, state: State, expected: StateChange | None) -> State | None:
    """The state with the events that have happened to bodies; None: the domain does not have them."""
    if expected is None or state.geometry is None:
        return state
    before, now = relations(scene, expected), relations(scene, state.geometry)
    for name in before:
        if before[name] != now[name]:
            event = event_of(problem, name, before[name], now[name])
            if event is None:
                return None
            state = replace(state, done=(*state.done, event))
    return state


def without_sensors(problem: Problem) -> Problem:
    """The problem when no sensor answers any more."""
    actions = {name: each for name, each in problem.domain.actions.items() if each.sense is None}
    return replace(problem, domain=replace(problem.domain, actions=actions))
