"""What is said of bodies by their places: on what they rest, in which regions they are, who holds them.

Knowledge of a body comes from actions that put it somewhere. As long as these relations are as they were, what is known is
taken to be true, wherever exactly the body is; where they have changed, it is not.
"""

import json
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import permutations

from kabo.errors import Diagnostic, InputError
from kabo.geometry_server import GeometryServer, Situation
from kabo.geometry_server.support_relations import lies_inside, rests_on
from kabo.language.problem import Problem
from kabo.plan import Done, StateChange
from kabo.plan.writing import done_to_json
from kabo.scene import Scene, beginning_at, world_T


@dataclass(frozen=True)
class Relations:
    """Of one body: what it rests on, the regions that it is in, and the link or body to which it is attached."""

    supports: frozenset[str]
    regions: frozenset[str]
    parent: str


def relations(scene: Scene, state: StateChange) -> dict[str, Relations]:
    """The relations of all movable bodies in a whole state."""
    here = beginning_at(scene, state)
    surroundings, situation = GeometryServer(here).surroundings, Situation.of(here.start)
    found = {}
    for name in scene.movable:
        parent = here.start.objects[name].parent
        standing = parent == "world"
        pose = world_T(here, here.start, name)
        inside = (
            region.name for region in scene.regions.values() if lies_inside(surroundings, name, pose, region)
        )
        supports = rests_on(surroundings, situation, name) if standing else ()
        found[name] = Relations(frozenset(supports), frozenset(inside if standing else ()), parent)
    return found


def changed_relations(
    scene: Scene, expected: StateChange, found: StateChange
) -> Iterator[tuple[str, Relations, Relations]]:
    """The bodies of which something else is true than is expected, with their relations as expected and as found."""
    before, now = relations(scene, expected), relations(scene, found)
    yield from ((name, before[name], now[name]) for name in before if before[name] != now[name])


def told(name: str, before: Relations, now: Relations) -> str:
    """What has changed, in a sentence."""
    if before.parent != now.parent:
        was, has = before.parent.partition("."), now.parent.partition(".")
        if now.parent != "world":
            return f"{name} is held by {has[0]}" if has[1] else f"{name} hangs on {has[0]}"
        return (
            f"{name} is not held by {was[0]} any more" if was[1] else f"{name} does not hang on {was[0]} any more"
        )
    if before.supports != now.supports:
        where = f"on {', '.join(sorted(now.supports))}" if now.supports else "on nothing that is known"
        return f"{name} does not rest on {', '.join(sorted(before.supports)) or 'what it was on'} any more, but {where}"
    gone = ", ".join(sorted(before.regions - now.regions))
    return f"{name} is not in {gone} any more" if gone else f"{name} is in {', '.join(sorted(now.regions))} now"


def require_explained(
    problem: Problem, scene: Scene, expected: StateChange, found: StateChange, happened: Collection[Done]
) -> None:
    """Checks that bodies are where what was done has left them, but for those to which an event has happened.

    Raises:
        InputError: of a body something else is true than what was done has made true; has one finding for each.
    """
    named = {value for step in happened for value in step.arguments.values()}
    faults = [
        Diagnostic("state", 1, 1, f"{told(name, before, now)}, and no event of what was done says so", hint)
        for name, before, now in changed_relations(scene, expected, found)
        if name not in named
        for hint in [_remedy(problem, name, before, now)]
    ]
    if faults:
        raise InputError(faults)


def _remedy(problem: Problem, name: str, before: Relations, now: Relations) -> str:
    event = event_of(problem, name, before, now)
    if event is not None:
        return f"add what happened to `done`: {json.dumps(done_to_json(event))}"
    if now.parent != "world":
        return "what takes and joins bodies is an action, and stands in `done`; or it hangs on `world`"
    lost = "lost(robot, body)" if "." in before.parent else "moved(body)"
    return f"the domain has no event {lost} that says what is then known; with it, add it to `done`"


def event_of(problem: Problem, name: str, before: Relations, now: Relations) -> Done | None:
    """The event of the domain that has happened to a body: `lost(robot, body)` from a hand, or else `moved(body)`.

    None if the domain does not have it, or if the body is in a hand or joined to another now: no event says that. Its
    parameters may have any names: their types say which one is which.
    """
    if before.parent != now.parent != "world":
        return None
    robot = before.parent.partition(".")[0] if "." in before.parent and now.parent != before.parent else None
    event = problem.domain.events.get("moved" if robot is None else "lost")
    things = [thing for thing in (robot, name) if thing is not None]
    if event is None or len(event.parameters) != len(things):
        return None
    for order in permutations(things):
        pairs = list(zip(event.parameters, order, strict=True))
        if all(thing in problem.of_type(parameter.type) for parameter, thing in pairs):
            return Done(event.name, {parameter.name: thing for parameter, thing in pairs})
    return None
