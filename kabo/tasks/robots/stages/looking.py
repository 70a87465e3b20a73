"""The stage `Look`: moves a robot's camera to where it is proven to see an object [docs/how-to/sensing.md]."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import (
    Measure,
    Pair,
    ProcedureContext,
    Refusal,
    Situation,
    Stream,
    Unseen,
    View,
    ViewpointStream,
    owners,
    viewpoints,
)
from kabo.scene import Configuration, Robot, Scene, Sensor
from kabo.tasks.core import Propagator, Property, Result
from kabo.tasks.core.model.results import Answer
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots.declaring import KEEP, OBJECT, ROBOT, RobotStage, keep_faults
from kabo.tasks.robots.motion.configurations import NoConfigurationError, goal_of
from kabo.tasks.robots.motion.nearness import own_nearness
from kabo.tasks.robots.motion.paths import length
from kabo.tasks.robots.motion.questions import along
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration
from kabo.tasks.robots.stages.moves import arm_moved


@dataclass(frozen=True)
class LookQuestion:
    """The question whether a robot is free at a configuration and sees an object from there; or a stream of viewpoints."""

    scene: TaskScene
    robot: str
    sensor: Sensor
    object: str
    q: Configuration = ()
    stream: Stream | None = None

    @property
    def is_search(self) -> bool:
        """False: no path search is needed."""
        return False

    @property
    def streams(self) -> Sequence[Stream]:
        """The stream of viewpoints, if there was none that could be tried."""
        return () if self.stream is None else (self.stream,)

    def passes(self, context: ProcedureContext, without: str | None = None) -> bool:
        """Whether the object is seen, optionally with the body `without` removed."""
        if not self.q:
            return False
        robot = context.scene.robots[self.robot]
        view = View(context.surroundings, self.scene.situation, robot, self.sensor, self.object)
        return view.unseen(np.array(self.q), without) is None

    def nearness(self, pair: Pair) -> Measure | None:
        """How near two links of the robot come at the viewpoint; None for other pairs."""
        return own_nearness(self.scene, self.robot, pair, (self.q,) if self.q else ())

    def sample(self) -> Situation:
        """The situation with the robot at the viewpoint; as it stands if there was none."""
        return self.scene.at(self.robot, self.q).situation if self.q else self.scene.situation


class Look(RobotStage, Propagator):
    """Moves the arm to where the camera is proven to see all of an object, with nothing in the way.

    The configuration `at` comes first if the robot has it, then viewpoints with the object in the middle of the view. A
    robot without a camera goes to `at`, whatever can be seen there, or stays where it is if it has no such configuration.
    """

    MOVES = ("robot",)
    READS = ("object",)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "sensor": Property(str, "", "the camera of the robot; empty: any, in the order of the scene"),
        "at": Property(str, "sense", "a named configuration that is tried first; empty: none"),
        "keep": KEEP,
    }

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Iterator[Answer]:
        """The scene with the robot at each viewpoint that it can move to, and a refusal for each other one."""
        name = properties["robot"]
        for goal in self._goals(scene, properties):
            motion: tuple[Stretch, ...] = ()
            if isinstance(goal, Refusal):
                yield goal
                continue
            if not np.array_equal(goal, scene.configuration(name)):
                moved = arm_moved(scene, name, goal, self.name, properties["keep"])
                if isinstance(moved, Refusal):
                    yield moved
                    continue
                motion = (moved,)
            yield Result(scene.at(name, goal), motion=motion, cost=length(motion))

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a camera that the robot lacks, and for a `keep` that applies to nothing held."""
        robot, sensor = self.known("robot"), self.known("sensor")
        if robot in scene.robots and sensor and sensor not in scene.robots[robot].sensors:
            yield f"{robot} has no sensor {sensor!r}; it has {', '.join(scene.robots[robot].sensors) or 'none'}"
        yield from keep_faults(self, start)

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof that the object is farther from the robot than its arm and the range of its cameras reach."""
        robot, name = (self.known(key) for key in ("robot", "object"))
        if robot not in context.scene.robots or name not in situation.objects:
            return None
        if len(situation.objects[name]) > 1 or any(name in situation.carried(r) for r in context.scene.robots):
            return None
        streams = self._streams(context, situation, context.scene.robots[robot], name, self.known("sensor"))
        missing = min((stream.missing() for stream in streams), default=0.0)
        if missing <= 0.0:
            return None
        text = f"{name} is {missing:.3f} m out of reach and range of {robot}"
        return Refusal("out_of_reach", text, reads=frozenset({name}), proof=True, missing=missing)

    def wanted(self, context: ProcedureContext, situation: Situation) -> list[Stream]:
        """The viewpoints of all cameras."""
        robot, name = (self.known(key) for key in ("robot", "object"))
        if robot not in context.scene.robots or name not in situation.objects:
            return []
        streams = self._streams(context, situation, context.scene.robots[robot], name, self.known("sensor"))
        return [found.stream for found in streams]

    # --------------------------------------------------------------------------------------------- viewpoints
    @staticmethod
    def _streams(
        context: ProcedureContext, situation: Situation, robot: Robot, name: str, wanted: str | None
    ) -> list[ViewpointStream]:
        chosen = [each for each in robot.sensors.values() if not wanted or each.name == wanted]
        return [viewpoints(context.surroundings, situation, robot, each, name, context.seed) for each in chosen]

    def _goals(self, scene: TaskScene, properties: Values) -> Iterator[Array | Refusal]:
        """Configurations (n,) from which the object is seen, and refusals of others."""
        name, at = properties["robot"], properties["at"]
        robot, first = scene.robot(name), _named(scene, name, at)
        if not robot.sensors:
            yield scene.configuration(name) if first is None else first
            return
        streams = self._streams(scene.context, scene.situation, robot, properties["object"], properties["sensor"])
        if not streams:
            yield Refusal("constraint", f"{name} has no sensor {properties['sensor']!r}", proof=True)
        for stream in streams:
            yield from _seeing(scene, robot, stream, properties["object"], first)


def _named(scene: TaskScene, robot: str, at: str) -> Array | None:
    """The configuration of that name; None if the robot has none."""
    try:
        return goal_of(scene, robot, at) if at else None
    except NoConfigurationError:
        return None


def _seeing(
    scene: TaskScene, robot: Robot, found: ViewpointStream, name: str, first: Array | None
) -> Iterator[Array | Refusal]:
    """The viewpoints of a stream, after a configuration `first`, that are free and see the object; or why not.

    They end where movable things hide the object, or block the arm, too often in a row: these had better be moved.
    """
    view = View(scene.context.surroundings, scene.situation, robot, found.sensor, name)
    tried, in_a_row = 0, 0
    if first is not None:
        refused = _refused(scene, view, first)
        yield first if refused is None else refused
    for candidate in scene.context.candidates(found):
        tried += 1
        refused = _refused(scene, view, candidate.q)
        yield candidate.q if refused is None else refused
        in_a_row = in_a_row + 1 if refused is not None and _is_movable(scene, robot.name, refused) else 0
        if in_a_row == scene.context.patience:
            return
    if not tried:
        asked = LookQuestion(scene, robot.name, found.sensor, name, stream=found.stream)
        text = f"{robot.name}.{found.sensor.name} cannot be brought to look at {name}"
        yield Refusal("out_of_reach", text, question=asked)


def _refused(scene: TaskScene, view: View, q: Array) -> Refusal | None:
    robot = view.robot.name
    hit = scene.workspace(robot).first_hit(q)
    if hit is not None:
        return Refusal.collision(hit, question=along(scene, robot, q))
    unseen = view.unseen(q)
    return None if unseen is None else _unseen(scene, view, q, unseen)


def _unseen(scene: TaskScene, view: View, q: Array, unseen: Unseen) -> Refusal:
    robot, sensor, name = view.robot.name, view.sensor, view.object
    if unseen.by is None:
        return Refusal("out_of_view", f"{name} is {unseen} for {robot}.{sensor.name}")
    pair = f"{robot}.{sensor.link}", unseen.by
    asked = LookQuestion(scene, robot, sensor, name, configuration(q))
    return Refusal("hidden", f"{name} is {unseen}", pairs=((pair, 1),), question=asked)


def _is_movable(scene: TaskScene, robot: str, refused: Refusal) -> bool:
    """Whether another robot, or an object that this one does not hold, is in the way."""
    met = {owner for pair, _ in refused.pairs for owner in owners(pair)}
    others = {*scene.situation.robots, *scene.situation.objects} - {robot, *scene.situation.carried(robot)}
    return not met.isdisjoint(others)
