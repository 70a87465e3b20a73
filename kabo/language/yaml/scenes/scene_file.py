"""Scene files, and the bodies and regions that a problem adds to them [docs/reference/scenes.md].

Robots, shapes and features are read first; then families, whose constraints name features.
"""

import re
from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.scene_description import (
    MATE_TOLERANCE,
    BodyDescription,
    Constraint,
    Mate,
    PoseDescription,
    RegionDescription,
    RobotDescription,
    SceneDescription,
)
from kabo.language.yaml.documents import MAX_NODES, Mapping, Scalar, Sequence, YamlNode, size_of
from kabo.language.yaml.paths import read_packages
from kabo.language.yaml.scenes.bodies import BODY_KEYS, MODEL_KEYS, WORLD, BodyReader, PartialBody
from kabo.language.yaml.scenes.constraints import ConstraintReader, Owner, Roles
from kabo.language.yaml.scenes.drives import check_floors
from kabo.language.yaml.scenes.features import given_features
from kabo.language.yaml.scenes.poses import Framed, check_frames
from kabo.language.yaml.scenes.robots import ROBOT_KEYS, ROBOT_MODEL_KEYS, RobotReader
from kabo.language.yaml.scenes.uncertain import read_uncertain
from kabo.language.yaml.values import Reader

SCENE_KEYS = (
    "scene", "epsilon", "packages", "robots", "robot_models", "models", "objects", "regions", "mates",
    "motion_constraints", "allowed_contacts", "uncertain",
)  # fmt: skip
MATE_KEYS = ("moving", "fixed", "constraints", "insertion", "tolerance", "holds")
_CONTACT = re.compile(r"[a-z][a-z0-9_]*(\.\S+)?")


@dataclass
class SceneReading:
    """A scene that is being read, with the facts about it that are needed to check problems afterwards."""

    findings: Findings
    reader: Reader
    description: SceneDescription | None = None
    places: dict[str, Place] = field(default_factory=dict)
    reported: set[tuple[Place, str]] = field(default_factory=set)  # objects that lack something in the scene
    copied: int = 0  # how many values came from models
    unsound: bool = False  # something is wrong with the scene itself

    def role_of(self, name: str) -> str | None:
        """The role of a name in the scene, "robot", "body" or "region"; None if it has none."""
        scene = self.description
        if scene is None:
            return None
        kinds = {"robot": scene.robots, "body": scene.bodies, "region": scene.regions}
        return next((kind for kind, names in kinds.items() if name in names), None)


def read_scene(
    root: Mapping,
    additions: Mapping | None,
    findings: Findings,
    *,
    within: Path | None = None,
    whole: bool = True,
) -> SceneReading:
    """The scene of a document, with the `bodies` and `regions` of the problem `additions` merged in.

    Args:
        root: the scene file.
        additions: the problem file, if there is one.
        findings: the collection that receives findings.
        within: if given, no mesh or URDF outside of this folder is accepted.
        whole: whether no body is missing; else problems may add some, and names of nobody in `uncertain` are warnings.
    """
    reading = SceneReading(findings, Reader(findings, within))
    reader, before = reading.reader, len(findings.errors)
    reader.keys(root, SCENE_KEYS, "a scene")
    name = reader.name(reader.require(root, "scene", "a scene"), "a scene")
    epsilon = reader.epsilon(reader.require(root, "epsilon", "a scene"), "epsilon")
    packages = read_packages(reader, root.get("packages"))
    body_reader = BodyReader(reader, ConstraintReader(findings), packages)
    robot_reader = RobotReader(reader, body_reader, packages)
    robots = _Robots(reading, robot_reader).read(root)
    bodies = _SceneBodies(reading, body_reader, {name: robot_reader.tools[name] for name in robots})
    bodies.read_parts(root, additions)
    regions = bodies.read_regions(root, additions)
    described = bodies.describe(regions)
    roles = bodies.roles(regions)
    contacts, contact_places = _read_contacts(reader, root.get("allowed_contacts"), robots, {**bodies.parts})
    reading.description = SceneDescription(
        name or "", epsilon or 1.0, robots, described, regions,
        _read_mates(body_reader, root.get("mates"), bodies.models),
        _read_motion_constraints(body_reader, root.get("motion_constraints"), roles),
        contacts, packages, root.source.path,
        read_uncertain(reader, root.get("uncertain"), [*robots, *bodies.parts], regions, whole),
        contact_places,
    )  # fmt: skip
    _check_frames(reading, bodies.parts, reading.description)
    reading.unsound = len(findings.errors) > before
    return reading


def with_model(
    reading: "SceneReading", mapping: Mapping, models: MappingType[str, Mapping]
) -> tuple[Mapping, str | None]:
    """The mapping with absent keys taken from its `model`, and the model's name, or None without one."""
    reader = reading.reader
    name = reader.text(mapping.get("model"), "`model`")
    if name is None:
        return mapping, None
    if name not in models:
        hint = reader.findings.near(name, models.keys()) or "this scene has no models of this kind"
        reader.findings.add(mapping.entries["model"][1].place, f'unknown model "{name}"', hint)
        return mapping, None
    if reading.copied > MAX_NODES:
        return mapping, None  # reported
    reading.copied += size_of(models[name])
    if reading.copied > MAX_NODES:
        reader.findings.add(mapping.place, f"up to here, models are copied into more than {MAX_NODES} values")
        return mapping, None
    entries = {**models[name].entries, **mapping.entries}
    return Mapping(mapping.source, mapping.start, mapping.end, entries, mapping.flow), name


def _claim_name(reading: SceneReading, key: Scalar, what: str, *, replaces: bool = False) -> bool:
    """Whether a thing of the scene may have this name: robots, bodies and regions share one namespace."""
    if not reading.reader.check_name(key, what):
        return False
    if key.text == "world":
        reading.findings.add(key.place, f'"world" is a frame and cannot be the name of {what}')
        return False
    earlier = reading.places.get(key.text)
    if earlier is not None and not replaces:
        message = f'"{key.text}" is already the name of a robot, body or region'
        reading.findings.add(key.place, message, f"it is declared in line {earlier.line}")
        return False
    reading.places[key.text] = key.place
    return True


@dataclass(frozen=True)
class _Robots:
    reading: SceneReading
    robots: RobotReader

    def read(self, root: Mapping) -> dict[str, RobotDescription]:
        reader = self.reading.reader
        models: dict[str, Mapping] = {}
        for name, key, value in reader.entries(root.get("robot_models"), "the robot models"):
            reader.check_name(key, "a robot model")
            mapping = reader.mapping(value, "a robot model")
            if mapping is not None:
                models[name] = mapping
                reader.keys(mapping, ROBOT_MODEL_KEYS, "a robot model")
        found: dict[str, RobotDescription] = {}
        used: set[str] = set()
        for name, key, value in reader.entries(root.get("robots"), "the robots"):
            mapping = reader.mapping(value, "a robot") or Mapping(value.source, key.start, key.end)
            reader.keys(mapping, ROBOT_KEYS, "a robot")
            if not _claim_name(self.reading, key, "a robot"):
                continue
            merged, model = with_model(self.reading, mapping, models)
            used.add(model or "")
            unknown_model = model is None and "model" in merged.entries
            robot = self.robots.robot(name, merged, model, complete=not unknown_model)
            if robot is not None:
                found[name] = robot
        for name, mapping in models.items():
            if name not in used:
                self.robots.robot(name, mapping, None, complete=False)
        return found


@dataclass
class _SceneBodies:
    reading: SceneReading
    bodies: BodyReader
    tools: dict[str, Owner]  # the tool features of every robot
    parts: dict[str, PartialBody] = field(default_factory=dict)
    models: dict[str, PartialBody] = field(default_factory=dict)

    def read_parts(self, root: Mapping, additions: Mapping | None) -> None:
        """Shapes, poses and features of all models, objects and bodies."""
        reader = self.reading.reader
        mappings: dict[str, Mapping] = {}
        for name, key, value in reader.entries(root.get("models"), "the models"):
            reader.check_name(key, "a model")
            mapping = reader.mapping(value, "a model")
            if mapping is not None:
                mappings[name] = mapping
                reader.keys(mapping, MODEL_KEYS, "a model")
                self.models[name] = self.bodies.part(name, mapping, None, movable=True, complete=False)
        self._read_bodies(root.get("objects"), "the objects", mappings, movable=False)
        if additions is not None:
            self._read_bodies(additions.get("bodies"), "the bodies", mappings, movable=True)

    def _read_bodies(
        self, node: YamlNode | None, what: str, models: MappingType[str, Mapping], *, movable: bool
    ) -> None:
        reader = self.reading.reader
        for name, key, value in reader.entries(node, what):
            mapping = reader.mapping(value, "a body") or Mapping(value.source, key.start, key.end)
            reader.keys(mapping, BODY_KEYS, "a body")
            if not _claim_name(self.reading, key, "a body", replaces=movable and name in self.parts):
                continue
            merged, model = with_model(self.reading, mapping, models)
            if model is None and "model" in merged.entries:  # reported; the shape is not missing as well
                if name not in self.parts:
                    self.parts[name] = PartialBody(
                        name, Mapping(key.source, key.start, key.end), None, None, PoseDescription(), movable, None
                    )
                continue
            self.parts[name] = self.bodies.part(name, merged, model, movable=movable, complete=True)

    def read_regions(self, root: Mapping, additions: Mapping | None) -> dict[str, RegionDescription]:
        """The regions of the scene and of the problem; the problem's replace those of the same name."""
        reader = self.reading.reader
        found: dict[str, RegionDescription] = {}
        for node in (root.get("regions"), None if additions is None else additions.get("regions")):
            added = node is not root.get("regions")
            for name, key, value in reader.entries(node, "the regions"):
                mapping = reader.mapping(value, "a region") or Mapping(value.source, key.start, key.end)
                if not _claim_name(self.reading, key, "a region", replaces=added and name in found):
                    continue
                region = self.bodies.region(name, mapping)
                support = mapping.get("support")
                if region is not None:
                    found[name] = region
                if region is not None and region.support is not None and region.support not in self.parts:
                    hint = reader.findings.near(region.support, self.parts.keys())
                    place = mapping.place if support is None else support.place
                    reader.findings.add(place, f'unknown body "{region.support}" as the support of a region', hint)
        return found

    def roles(self, regions: MappingType[str, RegionDescription]) -> Roles:
        """The things of this scene that the roles tool, this, support, region and world may refer to."""
        parts = [part.owner for part in (*self.models.values(), *self.parts.values())]
        areas = [Owner(name, given_features(region.shape)) for name, region in regions.items()]
        tools = [tool for tool in self.tools.values() if tool.features]
        return {"tool": tools, "this": parts, "support": parts, "region": areas, "world": [WORLD]}

    def describe(self, regions: MappingType[str, RegionDescription]) -> dict[str, BodyDescription]:
        """All bodies with their grasps and placements; those of models that nothing uses are checked as well."""
        roles, tools = self.roles(regions), self.tools
        supports, areas = list(roles["support"]), list(roles["region"])
        described = {name: self.bodies.body(part, tools, supports, areas) for name, part in self.parts.items()}
        used = {part.model for part in self.parts.values()}
        for name, model in self.models.items():
            if name not in used:
                self.bodies.body(model, tools, supports, areas)
        return {name: body for name, body in described.items() if body is not None}


# ------------------------------------------------------------------------------------- mates, motions, contacts
def _read_mates(
    bodies: BodyReader, node: YamlNode | None, models: MappingType[str, PartialBody]
) -> dict[str, Mate]:
    mates: dict[str, Mate] = {}
    reader = bodies.reader
    for name, key, value in reader.entries(node, "the mates"):
        reader.check_name(key, "a mate")
        mapping = reader.mapping(value, "a mate")
        if mapping is None:
            continue
        reader.keys(mapping, MATE_KEYS, "a mate")
        roles: dict[str, list[Owner]] = {"moving": [], "fixed": [], "world": [WORLD]}
        names: list[str] = []
        for role in ("moving", "fixed"):
            scalar = reader.scalar(reader.require(mapping, role, "a mate"), f"`{role}`")
            names.append("" if scalar is None else scalar.text)
            if scalar is not None and scalar.text in models:
                roles[role] = [models[scalar.text].owner]
            elif scalar is not None:
                hint = reader.findings.near(scalar.text, models.keys())
                reader.findings.add(scalar.place, f'unknown model "{scalar.text}" in a mate', hint)
        constraints = bodies.conjunction(mapping, roles, "a mate")
        given = mapping.get("tolerance")
        tolerance = MATE_TOLERANCE if given is None else reader.positive(given, "the tolerance of a mate")
        insertion = bodies.stroke(mapping, "insertion", roles)
        said = mapping.get("holds")
        holds = said is not None and bool(reader.boolean(said, "whether a mate holds"))
        mates[name] = Mate(name, names[0], names[1], constraints, insertion, tolerance or MATE_TOLERANCE, holds)
    return mates


def _read_motion_constraints(
    bodies: BodyReader, node: YamlNode | None, roles: Roles
) -> dict[str, tuple[Constraint, ...]]:
    allowed = {role: roles[role] for role in ("tool", "this", "world")}
    found: dict[str, tuple[Constraint, ...]] = {}
    for name, key, value in bodies.reader.entries(node, "the motion constraints"):
        bodies.reader.check_name(key, "a motion constraint")
        found[name] = bodies.constraint_list(value, allowed, "a motion constraint")
    return found


def _read_contacts(
    reader: Reader, node: YamlNode | None, robots: MappingType[str, object], bodies: MappingType[str, object]
) -> tuple[tuple[tuple[str, str], ...], tuple[Place, ...]]:
    """The pairs, and their places."""
    items = reader.items(node, "the allowed contacts")
    if isinstance(node, Sequence) and len(items) == 2 and all(isinstance(item, Scalar) for item in items):
        items = [node]  # a list of one may be written without brackets
    pairs: list[tuple[str, str]] = []
    places: list[Place] = []
    for item in items:
        if not isinstance(item, Sequence) or len(item.items) != 2:
            reader.findings.add(item.place, "an allowed contact is a pair: [robot.link, body]")
            continue
        first, second = (_contact_names(reader, each, robots, bodies) for each in item.items)
        found = [(a, b) for a in first for b in second if a != b]
        pairs.extend(found)
        places.extend([item.place] * len(found))
    return tuple(pairs), tuple(places)


def _contact_names(
    reader: Reader, node: YamlNode, robots: MappingType[str, object], bodies: MappingType[str, object]
) -> list[str]:
    """A robot, `robot.link` or body; those that fit a pattern; nothing for a word that is told as an error."""
    scalar = reader.scalar(node, "a robot, robot.link or body")
    if scalar is None:
        return []
    owner, dot, link = scalar.text.partition(".")
    if _CONTACT.fullmatch(scalar.text) and (owner in robots or (not dot and owner in bodies)):
        return [scalar.text]
    if set(owner) & {"*", "?"}:
        known = robots if dot else bodies
        fitting = [name for name in known if fnmatchcase(name, owner.replace("[", "[[]"))]
        if fitting and _CONTACT.fullmatch(fitting[0] + dot + link):
            return [name + dot + link for name in fitting]
    hint = reader.findings.near(owner, [*robots, *bodies])
    if not dot and robots:
        link = f"a link is written with its robot: {next(iter(robots))}.{owner}"
        hint = f"{hint}; {link}" if hint else link
    reader.findings.add(scalar.place, f'"{scalar.text}" is no robot, robot.link or body of the scene', hint)
    return []


def _check_frames(reading: SceneReading, parts: MappingType[str, PartialBody], scene: SceneDescription) -> None:
    poses: dict[str, PoseDescription] = {name: robot.base for name, robot in scene.robots.items()}
    poses.update({name: part.pose for name, part in parts.items()})
    poses.update({name: region.pose for name, region in scene.regions.items()})
    check_floors(scene.robots, scene.regions, poses, reading.findings)
    framed = {name: Framed(pose.frame, pose.place or reading.places[name]) for name, pose in poses.items()}
    check_frames(framed, scene.robots, scene.regions, reading.findings)
