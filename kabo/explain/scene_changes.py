"""Applies one change to a problem: a body removed, a smaller epsilon, a robot's base moved, or its floor larger."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

from kabo.explain.findings import BaseMoved, BodyRemoved, Change, FloorLarger, SmallerEpsilon
from kabo.language.formulas import Change as Facts
from kabo.language.formulas import Constant, Effect, Exists, Forall, Variable
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.scene import Scene, world_T


def changed(problem: Problem, scene: Scene, change: Change) -> Problem:
    """The problem with one change; a smaller epsilon is set in the problem's options, which override the scene's.

    Args:
        problem: a problem with a scene.
        scene: the loaded scene of the problem.
        change: the change; a removed body must be `removable`, a moved base that of a robot of the scene.

    Raises:
        ValueError: the problem has no scene.
    """
    given = problem.scene
    if given is None:
        raise ValueError("only a problem with a scene has bodies, an epsilon and bases")
    match change:
        case BodyRemoved(body):
            objects = {name: kind for name, kind in problem.objects.items() if name != body}
            initial = tuple(_without(body, problem.initial))
            return replace(problem, scene=_scene_without(given, body), objects=objects, initial=initial)
        case SmallerEpsilon(epsilon):
            return replace(problem, options={**problem.options, "epsilon": epsilon})
        case BaseMoved(name, by):
            robot = given.robots[name]
            turn = world_T(scene, scene.start, robot.base.frame)[:3, :3]
            shift = turn.T @ by
            x, y, z = (float(old + new) for old, new in zip(robot.base.position, shift, strict=True))
            moved = replace(robot, base=replace(robot.base, position=(x, y, z)))
            return replace(problem, scene=replace(given, robots={**given.robots, name: moved}))

        case FloorLarger(_, floor, by):
            region = given.regions[floor]
            x, y, z = region.shape.size or (0.0, 0.0, 0.0)
            more = 2.0 * by if region.shape.kind == "box" else by  # sides, or radii
            shape = replace(region.shape, size=(x + more, y + more, z + more))
            return replace(
                problem, scene=replace(given, regions={**given.regions, floor: replace(region, shape=shape)})
            )


def may_grow(problem: Problem, region: str) -> bool:
    """Whether a region is a box, cylinder or sphere, which can be made larger."""
    return problem.scene is not None and problem.scene.regions[region].shape.size is not None


def removable(problem: Problem, body: str) -> bool:
    """Whether a body can be removed: goal and actions do not name it, and nothing in the scene refers to it.

    Objects that the goal quantifies over and constants of the domain count as named. Bodies, regions, bases and
    mates that are defined relative to the body refer to it.
    """
    scene = problem.scene
    if scene is None or body not in scene.bodies:
        return False
    carried = [each.pose.frame for each in scene.bodies.values()] + [r.pose.frame for r in scene.regions.values()]
    based = [robot.base.frame for robot in scene.robots.values()]
    held = [region.support for region in scene.regions.values()]
    mated = [name for mate in scene.mates.values() for name in (mate.moving, mate.fixed)]
    named = {*_named(problem.goal, problem), *_named(tuple(problem.domain.actions.values()), problem, own=False)}
    return body not in {*carried, *based, *held, *mated, *named, *problem.domain.constants}


def _named(tree: Any, problem: Problem, *, own: bool = True) -> Iterator[str]:
    """The objects that a formula tree names; with `own`, all objects of quantified types as well."""
    for each in _walk(tree):
        if isinstance(each, Constant):
            yield each.name
        elif own and isinstance(each, (Forall, Exists)):
            for variable in each.variables:
                yield from problem.of_type(variable.type)


def _walk(tree: Any) -> Iterator[Any]:
    yield tree
    if isinstance(tree, (tuple, list)):
        for each in tree:
            yield from _walk(each)
    elif is_dataclass(tree) and not isinstance(tree, Variable):
        for part in fields(tree):
            yield from _walk(getattr(tree, part.name))


def _mentions(tree: Any, name: str) -> bool:
    return any(isinstance(each, Constant) and each.name == name for each in _walk(tree))


def _without(name: str, effects: tuple[Effect, ...]) -> Iterator[Effect]:
    """The effects without the facts that name an object; other effects that name it are left out."""
    for effect in effects:
        if isinstance(effect, Facts):
            facts = tuple(fact for fact in effect.facts if not _mentions(fact, name))
            if facts:
                yield replace(effect, facts=facts)
        elif not _mentions(effect, name):
            yield effect


def _scene_without(given: SceneDescription, body: str) -> SceneDescription:
    bodies = {name: each for name, each in given.bodies.items() if name != body}
    contacts = tuple(pair for pair in given.allowed_contacts if body not in pair)
    return replace(given, bodies=bodies, allowed_contacts=contacts, contact_places=())
