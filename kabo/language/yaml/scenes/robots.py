"""Robots of a scene: URDF, base, planned joints, gripper, tool, configurations [docs/reference/scenes.md]."""

from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.scene_description import FRICTION, Feature, GripperDescription, RobotDescription
from kabo.language.yaml.documents import Mapping, Scalar, YamlNode
from kabo.language.yaml.paths import read_file_path
from kabo.language.yaml.scenes.bodies import BodyReader
from kabo.language.yaml.scenes.constraints import Owner
from kabo.language.yaml.scenes.drives import read_base
from kabo.language.yaml.scenes.features import read_features, sound_features
from kabo.language.yaml.scenes.joint_limits import RATES, read_joint_limits
from kabo.language.yaml.scenes.poses import read_local_pose
from kabo.language.yaml.scenes.semantics import read_group, read_own_contacts, read_semantics, tool_of
from kabo.language.yaml.scenes.sensors import read_sensors
from kabo.language.yaml.values import Reader

ROBOT_MODEL_KEYS = (
    "urdf", "srdf", "base", "joints", "limits", *RATES, "inverse_kinematics", "hulls", "gripper", "tool",
    "configurations", "sensors", "allowed_contacts",
)  # fmt: skip
ROBOT_KEYS = ("model", *ROBOT_MODEL_KEYS)
GRIPPER_KEYS = ("urdf", "mount", "pose", "joints", "open", "closed", "touch_links", "force", "friction")
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
        limits = read_joint_limits(reader, mapping)
        return RobotDescription(
            name, urdf or Path(), base, joints, word, gripper, frame,
            sound_features(features), configurations, model, mapping.place, limits.positions, analytic, hulls,
            **limits.rates, limit_places=limits.places, sensors=read_sensors(reader, mapping.get("sensors")),
            drive=drive, semantics=semantics, joint_group=group,
            contacts=read_own_contacts(reader, mapping.get("allowed_contacts")),
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
        force = reader.positive(mapping.get("force"), "the force of a gripper")
        friction = reader.positive(mapping.get("friction"), "the friction of a gripper")
        if "friction" in mapping.entries and "force" not in mapping.entries:
            hint = "write the force with which the gripper holds, in N: without it nothing slips"
            reader.findings.add(mapping.key("friction").place, "`friction` counts only beside `force`", hint)
        at = mapping.key("force").place if "force" in mapping.entries else None
        return GripperDescription(
            urdf, mount, joints, opened, closed, links, mapping.place, pose, force, friction or FRICTION, at
        )

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
