"""Placements and mates: where a held object may go, by its placement families and the mates of the scene."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from kabo.geometry_server import (
    Destination,
    Measure,
    ProcedureContext,
    Refusal,
    Situation,
    Stream,
    grasps_there,
    may_place,
    placement_streams,
    region_missing,
    tool_frame,
    uncontained,
    wherever,
    why_nowhere,
)
from kabo.language.scene_description import Mate
from kabo.scene import Region, Robot, Scene
from kabo.tasks.core import Monitor, Property, Result
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, ROBOT, RobotStage
from kabo.tasks.robots.motion.directions import Direction
from kabo.tasks.robots.motion.mating import mate_target
from kabo.tasks.robots.motion.targets import PlacementTarget
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.grasps import ANY, OF_GRASPS, family_faults, held_properties


class SamplePlacement(RobotStage, Monitor):
    """The placement families of a held object: writes `target`, `placement`, `lower`, `retreat` for each.

    The object goes into `region` (on the region's support) or onto the body `support`; contact with that support is
    permitted in the scenes that it writes.
    """

    READS = ("object", "support")
    WRITES = ("target", "placement", "support", *OF_GRASPS)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "region": Property(
            (str, type(None)), None, "the region of the scene; none: anywhere on the support", meanings.name
        ),
        "support": Property(
            (str, type(None)), None, "the body to stand on; none: the support of the region", meanings.name
        ),
        "family": Property(
            str, ANY, "a placement family of the object, or `any`: all that fit, in file order", meanings.name
        ),
    }

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result for each placement family, with the family as target; inverse kinematics chooses the pose later."""
        robot, name = scene.robot(properties["robot"]), properties["object"]
        if scene.holder(name) != robot.name:
            text = f"{robot.name} does not hold {name}"
            return [Refusal("constraint", text, reads=frozenset({name}), proof=True)]
        place = _place(scene.context, properties["region"], properties["support"])
        never = _never(scene.context, name, place, properties["family"])
        if never is not None:
            return [never]
        streams = placement_streams(scene.context, robot, name, place, scene.situation, properties["family"])
        if place.support is not None:
            scene = scene.permitting([(name, place.support)])
        held = held_properties(scene, robot, name)
        region = None if place.region is None else place.region.name
        results = []
        for stream in streams:
            retreat = stream.family.retreat
            own: dict[str, Any] = {"target": PlacementTarget(robot.name, name, stream, region, place.support)}
            own |= {"placement": stream.family.name, "support": place.support}
            own |= {} if retreat is None else {"retreat": Direction(retreat, name)}
            results.append(Result(scene, properties={**held, **own}, comment=stream.family.name))
        return results

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a stage with neither region nor support, or with a placement family that the object lacks."""
        if all(self.known(key) is None and not self.undecided(key) for key in ("region", "support")):
            yield "there is no place: it says neither a region nor a support"
        yield from family_faults(self, scene, "placements")

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof that nothing fits the object there, or that the region is out of reach, however the object is held."""
        known = self._known(context)
        if known is None:
            return None
        robot, name, region = known
        place = _place(context, region.name, self.known("support"))
        ask = _uncontained if self.undecided("support") else _never
        never = ask(context, name, place, self.known("family") or ANY)
        if never is not None:
            return never
        missing = region_missing(robot, context.scene.bodies[name], region, tool_frame(robot))
        if missing <= 0.0:
            return None
        text = f"{region.name} is {missing:.3f} m out of reach of {robot.name} with {name}{wherever(robot)}"
        return Refusal("out_of_reach", text, proof=True, missing=missing)

    def foresee(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """The refusal if no configuration that grasps the object anywhere in the region was found.

        The result is None if one was found.
        """
        known = self._known(context)
        if known is None:
            return None
        robot, name, region = known
        place = _place(context, region.name, self.known("support"))
        if may_place(context, robot, context.scene.bodies[name], place, situation):
            return None
        return Refusal("out_of_reach", f"{robot.name} found no grasp of {name} anywhere in {region.name}")

    def wanted(self, context: ProcedureContext, situation: Situation) -> list[Stream]:
        """The placements of the object as it is held; if nobody holds it, grasps of it at some places in the region."""
        known = self._known(context)
        if known is None:
            return []
        robot, name, region = known
        place = _place(context, region.name, self.known("support"))
        if name in situation.carried(robot.name):
            return [made.stream for made in placement_streams(context, robot, name, place, situation)]
        return grasps_there(context, robot, context.scene.bodies[name], place, situation)

    def _known(self, context: ProcedureContext) -> tuple[Robot, str, Region] | None:
        robot, name, region = (self.known(key) for key in ("robot", "object", "region"))
        scene = context.scene
        if robot not in scene.robots or name not in scene.bodies or region not in scene.regions:
            return None
        return scene.robots[robot], name, scene.regions[region]


def _never(context: ProcedureContext, name: str, place: Destination, wanted: str) -> Refusal | None:
    """The proof that no placement family fits the place, or that the object does not fit the region; None without one."""
    why = why_nowhere(context.scene, name, place, wanted)
    return Refusal("empty_family", why, proof=True) if why else _uncontained(context, name, place, wanted)


def _uncontained(context: ProcedureContext, name: str, place: Destination, wanted: str) -> Refusal | None:
    """The proof that the object is too wide or too high for the region; None if it may fit."""
    region, body = place.region, context.scene.bodies[name]
    if region is None:
        return None
    key = "uncontained", name, region.name, place.support, wanted
    known: tuple[Measure | None] = context.surroundings.lasting(
        key, lambda: (uncontained(context.scene, body, region, place.support, wanted),)
    )
    measure = known[0]
    return None if measure is None else Refusal("constraint", measure.text, proof=True, measures=(measure,))


def _place(context: ProcedureContext, region: str | None, support: str | None) -> Destination:
    scene = context.scene
    if region is not None and region not in scene.regions:
        raise ValueError(f"the scene has no region {region!r}; it has {', '.join(scene.regions) or 'none'}")
    if support is not None and support not in scene.bodies:
        raise ValueError(f"the scene has no body {support!r}")
    chosen = None if region is None else scene.regions[region]
    return Destination(support if support is not None or chosen is None else chosen.support, chosen)


class SampleMate(RobotStage, Monitor):
    """All ways to mate the moving part, which a robot holds, with the fixed part.

    Writes `target`, `mate` and `insertion`; contact between both parts is permitted in the scenes that it writes.
    """

    READS = ("object", "onto")
    WRITES = ("target", "mate", "insertion", *OF_GRASPS)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "onto": Property(str, doc="the body with the fixed part", wrong=meanings.name),
        "mate": Property(
            str,
            doc="a mate of the scene: its roles `moving` is the object, `fixed` the other body",
            wrong=meanings.name,
        ),
    }

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene, if both bodies have the features that the mate names."""
        robot, name, onto = scene.robot(properties["robot"]), properties["object"], properties["onto"]
        if scene.holder(name) != robot.name:
            text = f"{robot.name} does not hold {name}"
            return [Refusal("constraint", text, reads=frozenset({name}), proof=True)]
        mate = mate_of(scene, properties["mate"])
        target = mate_target(scene, robot, name, onto, mate)
        if target is None:
            return [Refusal("empty_family", f"{mate.name} does not fit {name} and {onto}", proof=True)]
        insertion = None
        if mate.insertion is not None:
            owner = {"moving": "this", "fixed": "this"}.get(mate.insertion.along.owner, mate.insertion.along.owner)
            stroke = replace(mate.insertion, along=replace(mate.insertion.along, owner=owner))
            whose = onto if mate.insertion.along.owner == "fixed" else name
            insertion = Direction(stroke, whose, part=name, tolerance=mate.tolerance)
        made = {"target": target, "mate": mate.name, "insertion": insertion}
        return [
            Result(scene.permitting([(name, onto)]), properties={**held_properties(scene, robot, name), **made})
        ]


def mate_of(scene: TaskScene, name: str) -> Mate:
    """The mate of that name.

    Raises:
        ValueError: the scene has no such mate.
    """
    mates = scene.context.scene.mates
    if name not in mates:
        raise ValueError(f"the scene has no mate {name!r}; it has {', '.join(mates) or 'none'}")
    return mates[name]
