"""Stages without motion: nothing happens, time passes, or a predicate filters solutions [T 3.4]."""

from collections.abc import Callable, Iterator
from typing import Any

from kabo.geometry_server import Measure, Refusal, Situation, excess, lies_inside, outside
from kabo.scene import Scene
from kabo.tasks.core import Propagator, Property, Result, Solution, Wrapper
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import ROBOT, RobotStage
from kabo.tasks.robots.scenes import Stretch, TaskScene
from kabo.tasks.robots.stages.letting_go import letting_go


class NoOp(RobotStage, Propagator):
    """Does nothing."""

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene, unchanged."""
        return [Result(scene)]

    backward = forward


class Wait(RobotStage, Propagator):
    """Lets time pass while the robot holds still."""

    PROPERTIES = {
        "robot": ROBOT,
        "duration": Property(float, 1.0, "the time [s]; 0: none", meanings.at_least(0.0)),
    }

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene, unchanged."""
        robot = properties["robot"]
        q = scene.situation.configuration(robot)
        return [Result(scene, motion=(Stretch(robot, "arm", (q,), seconds=float(properties["duration"])),))]

    backward = forward


class PredicateFilter(RobotStage, Wrapper):
    """Passes on those solutions of its child at whose end all given predicates hold."""

    PROPERTIES = {
        "attached": Property(
            (list, tuple), (), "[object, robot]: the robot holds the object; empty: not checked", meanings.names(2)
        ),
        "inside": Property(
            (list, tuple),
            (),
            "[body, region]: the body is proven to lie inside; empty: not checked",
            meanings.names(2),
        ),
        "free_hand": Property(
            (str, type(None)), None, "a robot that holds nothing; none: not checked", meanings.name
        ),
        "free": Property(
            (list, tuple),
            (),
            "robots that are proven free of collisions; empty: not checked",
            meanings.names(empty=True),
        ),
        "lets_go": Property(
            (list, tuple),
            (),
            "[object, robot]: the gripper that holds it has room to open and to retreat; empty: not checked",
            meanings.names(2),
        ),
        "predicate": Property(
            Any,
            None,
            "a function of the scene that returns true, false, or the reason why not; none: not checked",
            lambda value: None if callable(value) else "is a function of the scene",
        ),
    }

    def transform(self, solution: Solution, properties: Values, seed: int) -> Answers:
        """The solution itself, or a failure that names the predicate that does not hold."""
        assert solution.end is not None
        scene: TaskScene = solution.end.scene
        for refused in (_attached, _inside, _free_hand, _free, _lets_go, _predicate):
            failure = refused(scene, properties)
            if failure is not None:
                return [failure]
        return [Result(cost=solution.cost, comment=solution.comment)]

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """A message if no predicate is given."""
        keys = ("attached", "inside", "free_hand", "free", "lets_go", "predicate")
        given = {key: self.undecided(key) or self.known(key) for key in keys}
        if not any(given.values()):
            yield f"nothing is asked: it says none of {', '.join(keys)}"

    def names(self) -> tuple[tuple[str, str], ...]:
        """The arguments of the predicates, as (kind of thing, name)."""
        attached, inside, left = (self.known(key) or () for key in ("attached", "inside", "lets_go"))
        asked = [*zip(("body", "robot"), attached, strict=False), *zip(("body", "region"), inside, strict=False)]
        asked += zip(("body", "robot"), left, strict=False)
        asked += [("robot", name) for name in (self.known("free_hand"), *(self.known("free") or ())) if name]
        return tuple((kind, str(name)) for kind, name in asked)

    def reads(self) -> tuple[str, ...]:
        """The bodies that the predicates name, and the robot of `free_hand`.

        If `inside` is given, the robot of `attached` is included too: a held body's pose depends on it.
        """
        attached, inside, left = (self.known(key) or () for key in ("attached", "inside", "lets_go"))
        found = [
            *attached[:1],
            *inside[:1],
            *left[:1],
            *([self.known("free_hand")] if self.known("free_hand") else []),
        ]
        if inside and attached:
            found += attached[1:]
        return tuple(dict.fromkeys(str(name) for name in found))


Check = Callable[[TaskScene, Values], Any]


def _attached(scene: TaskScene, properties: Values) -> Any:
    if not properties["attached"]:
        return None
    name, robot = properties["attached"]
    if scene.holder(name) == robot:
        return None
    return Refusal("constraint", f"{robot} does not hold {name}", reads=frozenset({name}), proof=True)


def _inside(scene: TaskScene, properties: Values) -> Any:
    if not properties["inside"]:
        return None
    name, region = properties["inside"]
    if lies_inside(scene.context.surroundings, name, scene.pose(name), scene.context.scene.regions[region]):
        return None
    holder = scene.holder(name)
    reads = frozenset({name} if holder is None else {name, holder})
    out = max(
        0.0, outside(scene.context.surroundings, name, scene.pose(name), scene.context.scene.regions[region])
    )
    said = f"{name} does not stand in {region}: it reaches {excess(out)} out of it"
    measure = Measure(f"inside({name}, {region})", said, 0.0, out)
    return Refusal("constraint", said, reads=reads, proof=True, measures=(measure,))


def _free_hand(scene: TaskScene, properties: Values) -> Any:
    robot = properties["free_hand"]
    held = () if robot is None else scene.situation.carried(robot)
    if not held:
        return None
    return Refusal("constraint", f"{robot} holds {held[0]}", reads=frozenset(held), proof=True)


def _free(scene: TaskScene, properties: Values) -> Any:
    for robot in properties["free"]:
        hit = scene.hit(robot)
        if hit is not None:
            return Refusal.collision(hit)
    return None


def _lets_go(scene: TaskScene, properties: Values) -> Any:
    return letting_go(scene, *properties["lets_go"]) if properties["lets_go"] else None


def _predicate(scene: TaskScene, properties: Values) -> Any:
    if properties["predicate"] is None:
        return None
    answer = properties["predicate"](scene)
    return (
        None
        if answer is True
        else Refusal("constraint", answer if isinstance(answer, str) else "the predicate fails")
    )
