"""Robots of a scene: URDF, base, planned joints, gripper, tool, configurations [docs/reference/scenes.md]."""

from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.scene_description import Feature, GripperDescription, RobotDescription
from kabo.language.yaml.documents import Mapping, Scalar, YamlNode
from kabo.language.yaml.paths import read_file_path
from kabo.language.yaml.scenes.bodies import BodyReader
from kabo.language.yaml.scenes.constraints import Owner
from kabo.language.yaml.scenes.drives import read_base
from kabo.language.yaml.scenes.features import read_features, sound_features
from kabo.language.yaml.scenes.poses import read_local_pose
from kabo.language.yaml.scenes.semantics import read_group, read_own_contacts, read_semantics, tool_of
from kabo.language.yaml.scenes.sensors import read_sensors
from kabo.language.yaml.values import Reader

ROBOT_MODEL_KEYS = (
    "urdf", "srdf", "base", "joints", "limits", "acceleration", "inverse_kinematics", "hulls", "gripper", "tool",
    "configurations", "sensors", "allowed_contacts",
)  # fmt: skip
ROBOT_KEYS = ("model", *ROBOT_MODEL_KEYS)
GRIPPER_KEYS = ("urdf", "mount", "pose", "joints", "open", "closed", "touch_links")
TOOL_KEYS = ("frame", "features")


@dataclass(frozen=True)
class RobotReader:
    """Reads the robots of one scene."""

    reader: Reader
    bodies: BodyReader
    packages: MappingType[str, Path]
    tools: dict[str, Owner] = field(default_factory=dict)  # of every robot and robot model read

    def robot(self, name: str, mapping: Mapping, model: str | None, *, complete: bool) -> RobotDescription | None:
        """The robot that a mapping describes; None without a URDF, which is reported if it must be `complete`."""
        reader = self.reader
        node = reader.require(mapping, "urdf", "a robot") if complete else mapping.get("urdf")
        urdf = read_file_path(reader, node, "URDF", self.packages)
        base, drive = read_base(reader, mapping.get("base"))
        semantics = read_semantics(reader, mapping.get("srdf"), self.packages)
        node = mapping.get("joints")
        group = read_group(reader, node, semantics)
        joints = None if isinstance(node, Scalar) and not node.empty else self._words(node, "joint")
        node = mapping.get("inverse_kinematics")
        word = "automatic" if node is None else self._word_of_kinematics(node)
        analytic = None if node is None or word != "analytic" else node.place
        hulls = self._words(mapping.get("hulls"), "link") or ()
        gripper = self._gripper(mapping.get("gripper"))
        own_frame, own_features = self._tool(mapping.get("tool"))
        frame, features = tool_of(semantics, own_frame)
        features.update(own_features)
        self.tools[name] = Owner(name, features)
        configurations = self._configurations(mapping.get("configurations"), joints, drives=drive is not None)
        return RobotDescription(
            name, urdf or Path(), base, joints, word, gripper, frame,
            sound_features(features), configurations, model, mapping.place, self._limits(mapping.get("limits")),
            analytic, hulls, self._accelerations(mapping.get("acceleration")),
            read_sensors(reader, mapping.get("sensors")), drive, semantics, group,
            read_own_contacts(reader, mapping.get("allowed_contacts")),
        )  # fmt: skip

    def _word_of_kinematics(self, node: YamlNode) -> Literal["analytic", "automatic", "projection"]:
        word = self.reader.choice(node, ("projection", "analytic"), "`inverse_kinematics`")
        return "analytic" if word == "analytic" else "projection"

    def _words(self, node: YamlNode | None, what: str) -> tuple[str, ...] | None:
        """Names that other programs gave, each once; None if absent."""
        if node is None:
            return None
        words: list[str] = []
        for item in self.reader.items(node, f"the list of {what}s"):
            word = self.reader.text(item, f"the name of a {what}")
            if word is not None and word in words:
                self.reader.findings.add(item.place, f'"{word}" stands twice in the list')
            elif word is not None:
                words.append(word)
        return tuple(words)

    def _gripper(self, node: YamlNode | None) -> GripperDescription | None:
        mapping = self.reader.mapping(node, "a gripper")
        if mapping is None:
            return None
        reader = self.reader
        reader.keys(mapping, GRIPPER_KEYS, "a gripper")
        urdf = read_file_path(reader, mapping.get("urdf"), "URDF", self.packages)
        mount = reader.text(mapping.get("mount"), "`mount`")
        pose = read_local_pose(reader, mapping.get("pose"), "the pose of a gripper on its mount")
        joints = self._words(mapping.get("joints"), "joint")
        if "urdf" in mapping.entries:
            reader.require(mapping, "mount", "a gripper with a URDF of its own")
        elif (key := next((each for each in ("mount", "pose") if each in mapping.entries), None)) is not None:
            reader.findings.add(mapping.key(key).place, f"only a gripper with a URDF of its own has a `{key}`")
        elif "joints" not in mapping.entries:
            reader.findings.add(
                mapping.place, "a gripper needs `urdf` and `mount`, or `joints` of the robot's URDF"
            )
        opened = self._joint_values(mapping, "open", joints)
        closed = self._joint_values(mapping, "closed", joints)
        links = self._words(mapping.get("touch_links"), "link") or ()
        return GripperDescription(urdf, mount, joints, opened, closed, links, mapping.place, pose)

    def _joint_values(self, mapping: Mapping, key: str, joints: tuple[str, ...] | None) -> dict[str, float]:
        fixed = joints == ()  # a fork, a magnet, a suction cup: nothing opens or closes
        node = mapping.get(key) if fixed else self.reader.require(mapping, key, "a gripper")
        values = self.bodies.joint_values(node, f"`{key}`") or {}
        if joints is not None and isinstance(node, Mapping):
            for name in values:
                if name not in joints:
                    hint = self.reader.findings.near(name, joints)
                    self.reader.findings.add(node.key(name).place, f'"{name}" is no joint of the gripper', hint)
        return values

    def _tool(self, node: YamlNode | None) -> tuple[str | None, dict[str, Feature | None]]:
        mapping = self.reader.mapping(node, "a tool")
        if mapping is None:
            return None, {}
        self.reader.keys(mapping, TOOL_KEYS, "a tool")
        frame = self.reader.text(self.reader.require(mapping, "frame", "a tool"), "the frame of a tool")
        return frame, read_features(self.reader, mapping.get("features"))

    def _limits(self, node: YamlNode | None) -> dict[str, tuple[float, float]]:
        """The range of some joints, narrower than in the URDF."""
        found: dict[str, tuple[float, float]] = {}
        for name, _, value in self.reader.entries(node, "the limits"):
            values = self.reader.numbers(value, f'the limits of "{name}"', 2, angle=True)
            if values is not None and values[0] > values[1]:
                hint = "the lower one comes first"
                self.reader.findings.add(value.place, f'the limits of "{name}" are crossed', hint)
            elif values is not None:
                found[name] = values[0], values[1]
        return found

    def _accelerations(self, node: YamlNode | None) -> dict[str, float]:
        """The greatest accelerations of some joints [rad/s2 or m/s2]."""
        found: dict[str, float] = {}
        for name, _, value in self.reader.entries(node, "`acceleration`"):
            number = self.reader.number(value, f'the acceleration of "{name}"', angle=True)
            if number is not None and number <= 0.0:
                self.reader.findings.add(value.place, f'the acceleration of "{name}" is not above 0')
            elif number is not None:
                found[name] = number
        return found

    def _configurations(
        self, node: YamlNode | None, joints: tuple[str, ...] | None, *, drives: bool
    ) -> dict[str, tuple[float, ...]]:
        """The named configurations; if the robot `drives`, each may leave out the base's values."""
        found: dict[str, tuple[float, ...]] = {}
        count = None if joints is None or drives else len(joints)
        hint = None if joints is None else f"one for each of `joints`, in their order: {', '.join(joints)}"
        for name, key, value in self.reader.entries(node, "the configurations"):
            self.reader.check_name(key, "a configuration")
            values = self.reader.numbers(value, f'the configuration "{name}"', count, angle=True, hint=hint)
            if values is not None:
                found[name] = values
                count = None if drives else len(values)
        return found
