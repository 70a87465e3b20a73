"""Bodies and regions: shapes, grasp families, placements, strokes [docs/reference/scenes.md]."""

import re
from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from pathlib import Path

from kabo.language.scene_description import (
    BodyDescription,
    Constraint,
    Feature,
    FeatureName,
    GraspFamily,
    PlacementFamily,
    PoseDescription,
    RegionDescription,
    Shape,
    Stroke,
)
from kabo.language.semantic_description import SemanticDescription
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode
from kabo.language.yaml.paths import read_file_path
from kabo.language.yaml.scenes.constraints import ConstraintReader, Owner, Roles
from kabo.language.yaml.scenes.features import WORLD_FEATURES, given_features, read_features, sound_features
from kabo.language.yaml.scenes.poses import read_pose
from kabo.language.yaml.scenes.semantics import TOOL_FEATURES, frame_features, handle_grasps, read_semantics
from kabo.language.yaml.values import SMALLEST_SIZE, Reader

SHAPE_KEYS = ("mesh", "box", "cylinder", "sphere", "capsule")
ROUND_KEYS = {"cylinder": ("radius", "height"), "sphere": ("radius",), "capsule": ("radius", "length")}
MODEL_KEYS = (*SHAPE_KEYS, "scale", "pose", "movable", "mass", "features", "grasps", "placements", "srdf")
BODY_KEYS = ("model", *MODEL_KEYS)
REGION_KEYS = (*SHAPE_KEYS, "scale", "pose", "support")
GRASP_KEYS = ("constraints", "robots", "approach", "lift", "fingers")
PLACEMENT_KEYS = ("constraints", "retreat")
STROKE_KEYS = ("along", "against", "distance")

WORLD = Owner("world", WORLD_FEATURES)
_FEATURE = re.compile(r"([a-z][a-z0-9_]*)\.([a-z][a-z0-9_]*)")


@dataclass(frozen=True)
class PartialBody:
    """A partially read body or model: its shape, pose and features, without grasps and placements."""

    name: str
    mapping: Mapping
    model: str | None
    shape: Shape | None
    pose: PoseDescription
    movable: bool
    mass: float | None
    features: MappingType[str, Feature | None] = field(default_factory=dict)
    semantics: SemanticDescription | None = None  # of its SRDF file: handles

    @property
    def owner(self) -> Owner:
        """The body as an owner of features, to which roles in constraints can refer."""
        return Owner(self.name, self.features)


@dataclass(frozen=True)
class BodyReader:
    """Reads bodies, models and regions of one scene."""

    reader: Reader
    constraints: ConstraintReader
    packages: MappingType[str, Path]

    def part(
        self, name: str, mapping: Mapping, model: str | None, *, movable: bool, complete: bool
    ) -> PartialBody:
        """The shape, pose and features of a body; if not `complete` (a model), the shape may be missing."""
        reader = self.reader
        shape = self.shape(mapping, required=complete, what="a body")
        semantics = read_semantics(reader, mapping.get("srdf"), self.packages)
        handles = () if semantics is None else semantics.handles
        given = {key: each for handle in handles for key, each in frame_features(handle).items()}
        own = {**given, **read_features(reader, mapping.get("features"))}
        moves = reader.boolean(mapping.get("movable"), "`movable`")
        return PartialBody(
            name, mapping, model, shape, read_pose(reader, mapping.get("pose")),
            movable if moves is None else moves, reader.positive(mapping.get("mass"), "the mass"),
            {**given_features(shape), **own}, semantics,
        )  # fmt: skip

    def body(
        self, part: PartialBody, robots: MappingType[str, Owner], supports: list[Owner], regions: list[Owner]
    ) -> BodyDescription | None:
        """The body with its grasp and placement families; None if it has no shape, which was reported."""
        grasps = self._grasps(part, robots)
        placements = self._placements(part, robots, supports, regions)
        if part.shape is None:
            return None
        return BodyDescription(
            part.name, part.shape, part.pose, part.movable, part.model, part.mass,
            sound_features(part.features), grasps,
            placements, part.mapping.place, None if part.semantics is None else part.semantics.path,
        )  # fmt: skip

    def region(self, name: str, mapping: Mapping) -> RegionDescription | None:
        """The region that a mapping describes; None without a shape. The caller checks its support."""
        self.reader.keys(mapping, REGION_KEYS, "a region")
        shape = self.shape(mapping, required=True, what="a region")
        pose = read_pose(self.reader, mapping.get("pose"))
        support = self.reader.text(mapping.get("support"), "`support`")
        return None if shape is None else RegionDescription(name, shape, pose, support, mapping.place)

    # ------------------------------------------------------------------------------------------------ shapes
    def shape(self, mapping: Mapping, *, required: bool, what: str) -> Shape | None:
        """The shape that a mapping describes, with sizes in metres; None if it is absent or faulty."""
        given = [key for key in SHAPE_KEYS if key in mapping.entries]
        if len(given) > 1:
            place = mapping.key(given[1]).place
            self.reader.findings.add(place, f"{what} has one shape, this one has {' and '.join(given)}")
            return None
        if not given:
            if required:
                message = f"{what} needs a shape: one of {', '.join(SHAPE_KEYS)}"
                self.reader.findings.add(mapping.place, message)
            return None
        kind = given[0]
        if kind != "mesh" and "scale" in mapping.entries:
            self.reader.findings.add(mapping.key("scale").place, "only a mesh has a scale")
        node = mapping.get(kind)
        if isinstance(node, Scalar) and node.empty:
            self.reader.findings.add(mapping.key(kind).place, f"the {kind} has no value")
            return None
        if kind == "mesh":
            path = read_file_path(self.reader, node, "mesh", self.packages)
            scale = self.reader.positive(mapping.get("scale"), "the scale")
            at = None if node is None else node.place
            return None if path is None else Shape("mesh", path, 1.0 if scale is None else scale, None, at)
        return self._primitive(kind, node)

    def _primitive(self, kind: str, node: YamlNode | None) -> Shape | None:
        place = None if node is None else node.place
        if kind == "box":
            sides = self.reader.position(node, "the whole sides of a box")
            if sides is not None and node is not None and min(sides) < SMALLEST_SIZE:
                said = "the sides of a box must be greater than 0"
                self.reader.findings.add(node.place, said if min(sides) <= 0 else f"{said}, at least a micrometre")
                return None
            return None if sides is None else Shape("box", None, 1.0, sides, place)
        mapping = self.reader.mapping(node, f"a {kind}")
        if mapping is None:
            return None
        keys = ROUND_KEYS[kind]
        self.reader.keys(mapping, keys, f"a {kind}")
        values = [self.reader.size(self.reader.require(mapping, key, f"a {kind}"), f"the {key}") for key in keys]
        if None in values:
            return None
        numbers = [value for value in values if value is not None]
        size = numbers[0], numbers[0], numbers[-1]
        if kind == "cylinder":
            return Shape("cylinder", None, 1.0, size, place)
        return Shape("capsule" if kind == "capsule" else "sphere", None, 1.0, size, place)

    # ---------------------------------------------------------------------------------------------- families
    def _grasps(self, part: PartialBody, robots: MappingType[str, Owner]) -> dict[str, GraspFamily]:
        families: dict[str, GraspFamily] = {}
        if part.semantics is not None and any(set(robot.features) >= TOOL_FEATURES for robot in robots.values()):
            families.update(handle_grasps(part.semantics.handles))
        for name, key, value in self.reader.entries(part.mapping.get("grasps"), "the grasps"):
            self.reader.check_name(key, "a grasp family")
            mapping = self.reader.mapping(value, "a grasp family")
            if mapping is None:
                continue
            self.reader.keys(mapping, GRASP_KEYS, "a grasp family")
            named = self._robot_names(mapping.get("robots"), robots)
            able = [
                robot
                for robot in robots.values()
                if (named is None and robot.features) or robot.name in (named or ())
            ]
            roles = {"tool": able, "this": [part.owner], "world": [WORLD]}
            constraints = self.conjunction(mapping, roles, "a grasp family")
            self._check_some_robot(key, constraints, able, named)
            families[name] = GraspFamily(
                name, constraints, named, self.stroke(mapping, "approach", roles),
                self.stroke(mapping, "lift", roles), self.joint_values(mapping.get("fingers"), "`fingers`"),
            )  # fmt: skip
        return families

    def _robot_names(self, node: YamlNode | None, robots: MappingType[str, Owner]) -> tuple[str, ...] | None:
        if node is None:
            return None
        found: list[str] = []
        for item in self.reader.items(node, "`robots`"):
            name = self.reader.text(item, "a robot")
            if name is not None and name not in robots:
                hint = self.reader.findings.near(name, robots.keys())
                self.reader.findings.add(item.place, f'unknown robot "{name}"', hint)
            elif name is not None:
                found.append(name)
        return tuple(found)

    def _check_some_robot(
        self, key: Scalar, constraints: tuple[Constraint, ...], able: list[Owner], named: tuple[str, ...] | None
    ) -> None:
        sides = [side for constraint in constraints for side in (constraint.first, constraint.second)]
        used = sorted({side.feature for side in sides if side.owner == "tool" and side.feature is not None})
        lacking = {robot.name: [feature for feature in used if feature not in robot.features] for robot in able}
        if named is None:
            if lacking and all(lacking.values()):
                message = f'no robot has all tool features that the grasp family "{key.text}" uses'
                self.reader.findings.add(key.place, message, f"it uses {', '.join(used)}")
            return
        for robot, features in lacking.items():
            if features:
                message = f'the grasp family "{key.text}" names robot "{robot}", whose tool has no "{features[0]}"'
                self.reader.findings.add(key.place, message)

    def _placements(
        self, part: PartialBody, robots: MappingType[str, Owner], supports: list[Owner], regions: list[Owner]
    ) -> dict[str, PlacementFamily]:
        families: dict[str, PlacementFamily] = {}
        for name, key, value in self.reader.entries(part.mapping.get("placements"), "the placements"):
            self.reader.check_name(key, "a placement")
            mapping = self.reader.mapping(value, "a placement")
            if mapping is None:
                continue
            self.reader.keys(mapping, PLACEMENT_KEYS, "a placement")
            roles: Roles = {"this": [part.owner], "support": supports, "region": regions, "world": [WORLD]}
            constraints = self.conjunction(mapping, roles, "a placement")
            motion_roles = {**roles, "tool": [robot for robot in robots.values() if robot.features]}
            families[name] = PlacementFamily(name, constraints, self.stroke(mapping, "retreat", motion_roles))
        return families

    def conjunction(self, mapping: Mapping, roles: Roles, what: str) -> tuple[Constraint, ...]:
        """The constraints under the required key `constraints` of a mapping."""
        node = self.reader.require(mapping, "constraints", what)
        return self.constraint_list(node, roles, f"a constraint of {what}")

    def constraint_list(self, node: YamlNode | None, roles: Roles, what: str) -> tuple[Constraint, ...]:
        """The constraints in a list; faulty ones are reported and left out."""
        read = [self.constraints.read(scalar, roles) for scalar in self.reader.formulas(node, what)]
        return tuple(constraint for constraint in read if constraint is not None)

    # ----------------------------------------------------------------------------------------------- strokes
    def stroke(self, owner: Mapping, key: str, roles: Roles) -> Stroke | None:
        """The straight motion `{along | against: line, distance: …}` under `key`; None if absent or faulty."""
        mapping = self.reader.mapping(owner.get(key), f"`{key}`")
        if mapping is None:
            return None
        self.reader.keys(mapping, STROKE_KEYS, f"`{key}`")
        directions = [word for word in ("along", "against") if word in mapping.entries]
        if len(directions) != 1:
            self.reader.findings.add(mapping.place, f"`{key}` needs exactly one of along and against")
        distances = self._distances(self.reader.require(mapping, "distance", f"`{key}`"))
        if len(directions) != 1:
            return None
        feature = self._line(mapping.get(directions[0]), roles)
        if feature is None or distances is None:
            return None
        return Stroke(feature, 1 if directions[0] == "along" else -1, *distances)

    def _line(self, node: YamlNode | None, roles: Roles) -> FeatureName | None:
        scalar = self.reader.scalar(node, "a line feature")
        if scalar is None:
            return None
        found = _FEATURE.fullmatch(scalar.text)
        if found is None:
            self.reader.findings.add(
                scalar.place, f'"{scalar.text}" is no feature: write tool.approach or world.up'
            )
            return None
        name = FeatureName(found[1], found[2])
        return name if self.constraints.check_stroke_feature(name, scalar.place, roles) else None

    def _distances(self, node: YamlNode | None) -> tuple[float, float] | None:
        if isinstance(node, Sequence):
            values = self.reader.numbers(node, "a distance [min, max]", 2)
        else:
            value = self.reader.number(node, "a distance")
            values = None if value is None else (value, value)
        if values is None or node is None or not self.reader.sensible(node, "a distance", values[1]):
            return None
        if values[0] < 0 or values[0] > values[1]:
            self.reader.findings.add(node.place, "a distance [min, max] needs 0 <= min <= max")
            return None
        return values[0], values[1]

    def joint_values(self, node: YamlNode | None, what: str) -> dict[str, float] | None:
        """The values of joints by their names [rad or m]; None if `node` is None."""
        if node is None:
            return None
        values: dict[str, float] = {}
        for name, _, item in self.reader.entries(node, what):
            value = self.reader.number(item, f'the value of joint "{name}"', angle=True)
            if value is not None:
                values[name] = value
        return values
