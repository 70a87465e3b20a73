"""Grasps: sampled from an object's grasp families, or recognised from how a robot holds it."""

from collections.abc import Iterator, Mapping
from typing import Any

from kabo.arrays import Array
from kabo.geometry_server import (
    ProcedureContext,
    Refusal,
    Situation,
    Stream,
    grasp_family_of,
    grasp_missing,
    grasp_roles,
    grasp_stream,
    overlapping,
    standing_of,
    wherever,
)
from kabo.language.scene_description import FeatureName, GraspFamily, Stroke
from kabo.scene import Body, Robot, Scene
from kabo.tasks.core import Monitor, Propagator, Property, Result
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, ROBOT, RobotStage
from kabo.tasks.robots.motion.configurations import CLOSED, hand
from kabo.tasks.robots.motion.directions import Direction
from kabo.tasks.robots.motion.targets import GraspTarget
from kabo.tasks.robots.scenes import TaskScene

# Stroke by which an object is lifted if no family says otherwise.
LIFT = Stroke(FeatureName("world", "up"), 1, 0.05, 0.10)
ANY = "any"
OF_GRASPS = (
    "grasp",
    "approach",
    "lift",
    "fingers",
    "lower",
    "retreat",
)  # the interface properties of a grasp family


def grasp_properties(robot: Robot, name: str, family: GraspFamily) -> dict[str, Any]:
    """The interface properties of a grasp family that later stages need to grasp the object and to release it."""
    approach = None if family.approach is None else Direction(family.approach, name)
    fingers = hand(robot, CLOSED) if family.fingers is None else family.fingers
    return {
        "grasp": family.name,
        "approach": approach,
        "lift": None if family.lift is None else Direction(family.lift, name),
        "fingers": {joint: value for joint, value in fingers.items() if joint in robot.gripper_joints},
        "lower": Direction(LIFT if family.lift is None else family.lift, name, -1),
        "retreat": None if approach is None else approach.reversed(),
    }


class SampleGrasp(RobotStage, Monitor):
    """The grasp families of an object where it stands: writes `target`, `grasp`, `approach`, `lift`, `fingers` for each.

    The gripper is as in the scene at the end of the monitored stage, which opens it.
    """

    READS = ("object",)
    WRITES = ("target", *OF_GRASPS)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "family": Property(
            str,
            ANY,
            "a grasp family of the object, or `any`: all that fit the robot, in file order",
            meanings.name,
        ),
    }

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result for each grasp family, with the family as target; inverse kinematics chooses the grasp later."""
        robot, name = scene.robot(properties["robot"]), properties["object"]
        if scene.holder(name) == robot.name:
            return [Refusal("constraint", f"{robot.name} holds {name} already", reads=frozenset({name}))]
        refused = _refuted(scene.context, scene.situation, robot, name, properties["family"])
        if refused is None and scene.context.tries_again:
            refused = _overlap(scene.context, scene.situation, name)
        if refused is not None:
            return [refused]
        found = _streams(scene.context, scene.situation, robot, name, properties["family"])
        return [self._answer(scene, robot, name, stream) for stream in found]

    @staticmethod
    def _answer(scene: TaskScene, robot: Robot, name: str, stream: Any) -> Result | Refusal:
        """One grasp family as target, or the proof that the gripper opens less than it needs."""
        target = GraspTarget(robot.name, stream, name)
        wide = target.too_wide(scene)
        if wide is not None and wide.proven:
            return Refusal("constraint", wide.text, proof=True, measures=(wide,))
        properties = {"target": target, **grasp_properties(robot, name, stream.family)}
        return Result(scene, properties=properties, comment=stream.family.name)

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """A message for a grasp family that the object lacks."""
        yield from family_faults(self, scene, "grasps")

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof that no family fits, or that the object is out of reach."""
        robot, name, family = (self.known(key) for key in ("robot", "object", "family"))
        if robot not in context.scene.robots or name not in situation.objects:
            return None
        holders = (r for r in context.scene.robots if name in situation.carried(r))
        if any(holder != robot for holder in holders):
            return None  # another stage brings it first
        return _refuted(context, situation, context.scene.robots[robot], name, family or ANY)

    def wanted(self, context: ProcedureContext, situation: Situation) -> list[Stream]:
        """The grasps of all families, at the object's present pose."""
        robot, name, family = (self.known(key) for key in ("robot", "object", "family"))
        if robot not in context.scene.robots or name not in situation.objects:
            return []
        chosen = context.scene.robots[robot]
        return [found.stream for found in _streams(context, situation, chosen, name, family or ANY)]


def family_faults(stage: RobotStage, scene: Scene, kind: str) -> Iterator[str]:
    """A message if the stage's object is known and lacks the family that the stage names.

    `kind` is `grasps` or `placements`.
    """
    name, family = stage.known("object"), stage.known("family")
    if name not in scene.bodies or family in (None, ANY):
        return
    known = getattr(scene.bodies[name], kind)
    if family not in known:
        yield f"{name} has no family {family!r} among its {kind}; it has {', '.join(known) or 'none'}"


def _streams(context: ProcedureContext, situation: Situation, robot: Robot, name: str, wanted: str) -> list[Any]:
    body = _body(context, name)
    poses = context.surroundings.poses(situation, name)
    held = tuple(situation.configuration(robot.name)[robot.planned :])
    chosen = [family for family in body.grasps.values() if wanted in (ANY, family.name)]
    standing = standing_of(context.surroundings, robot)
    made = (grasp_stream(robot, body, family, poses[0], held, context.seed, standing) for family in chosen)
    return [stream for stream in made if stream is not None]


def _body(context: ProcedureContext, name: str) -> Body:
    if name not in context.scene.bodies:
        raise ValueError(f"the scene has no body {name!r}")
    return context.scene.bodies[name]


def _refuted(
    context: ProcedureContext, situation: Situation, robot: Robot, name: str, wanted: str
) -> Refusal | None:
    pose = context.surroundings.poses(situation, name)[0]
    key = "refuted", robot.name, name, wanted, pose.tobytes()
    known: tuple[Refusal | None] = context.surroundings.lasting(
        key, lambda: (_beyond(_body(context, name), pose, robot, wanted),)
    )
    return known[0]


def _overlap(context: ProcedureContext, situation: Situation, name: str) -> Refusal | None:
    """A proof that an object cannot be grasped where it begins, since it overlaps something there."""
    fault = overlapping(context.surroundings, situation, name)
    if fault is None:
        return None
    reads = frozenset(fault.things) & {*situation.objects}
    return Refusal("constraint", fault.said, reads, proof=True)


def _beyond(body: Body, pose: Array, robot: Robot, wanted: str) -> Refusal | None:
    """A proof that a body at a pose (4, 4) cannot be grasped; None if there is none."""
    name = body.name
    chosen = [family for family in body.grasps.values() if wanted in (ANY, family.name)]
    fitting = [(family, grasp_roles(robot, body, family, pose)) for family in chosen]
    bounds = [grasp_missing(robot, family.constraints, roles) for family, roles in fitting if roles is not None]
    if not bounds:
        why = "" if robot.tool is not None else f": {robot.name} has no `tool` in the scene"
        return Refusal("empty_family", f"{name} has no grasp family that {robot.name} can use{why}", proof=True)
    missing = min(bounds)
    if missing <= 0.0:
        return None
    text = f"{name} is {missing:.3f} m out of reach of {robot.name}{wherever(robot)}"
    return Refusal("out_of_reach", text, reads=frozenset({name}), proof=True, missing=missing)


class RecogniseGrasp(RobotStage, Propagator):
    """Recognises the family by which a robot holds an object; writes `grasp`, `approach`, `lift`, `lower`, `retreat`."""

    READS = ("object",)
    WRITES = OF_GRASPS
    PROPERTIES = {"robot": ROBOT, "object": OBJECT}

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The unchanged scene; if no family fits, `lower` and `retreat` are vertical strokes."""
        robot, name = scene.robot(properties["robot"]), properties["object"]
        return [Result(scene, properties=held_properties(scene, robot, name))]

    backward = forward


def held_properties(scene: TaskScene, robot: Robot, name: str) -> Mapping[str, Any]:
    """The interface properties that describe how a robot holds an object.

    They name no family if none matches the hold.
    """
    if scene.holder(name) != robot.name:
        return {}
    found = grasp_family_of(scene.context, robot, name, scene.situation)
    if found is None:
        return {"grasp": None, "lower": Direction(LIFT, name, -1), "retreat": None}
    return grasp_properties(robot, name, found)
