"""Scenes as pinocchio and coal see them: read from the files of a problem, without a line of kabo."""

import copy
import fnmatch
import importlib.metadata
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import coal
import numpy as np
import numpy.typing as npt
import pinocchio as pin
import yaml

Array = npt.NDArray[np.float64]
RISE, JERK_RISE = 0.25, 0.05  # [s] of the documented defaults: v = a · 0.25 s, a = j · 0.05 s
ENDLESS = 1e6  # [rad] limits of a continuous joint
KINDS = ("velocity", "acceleration", "jerk")


def number(value: Any) -> float:
    """A number of a scene: degrees and millimetres have their unit behind them."""
    if isinstance(value, str):
        digits, unit = re.fullmatch(r"\s*([-+0-9.eE]+)\s*(deg|rad|mm|cm|m)?\s*", value).groups()  # type: ignore[union-attr]
        return float(digits) * {"deg": np.pi / 180, "mm": 1e-3, "cm": 1e-2}.get(unit, 1.0)
    return float(value)


def numbers(values: Any) -> Array:
    """A row of numbers of a scene."""
    return np.array([number(value) for value in values])


def pose(position: Any, quaternion: Any = (0.0, 0.0, 0.0, 1.0)) -> Array:
    """A transform (4, 4) of a position and a quaternion x, y, z, w."""
    turn = pin.Quaternion(np.asarray(quaternion, float))
    turn.normalize()
    return pin.SE3(turn, np.asarray(position, float)).homogeneous


def written_pose(entry: dict[str, Any] | None) -> Array:
    """The transform that an entry `pose` says, in its frame."""
    entry = entry or {}
    position = numbers(entry.get("position", (0, 0, 0)))
    if "rpy" in entry:
        found = np.eye(4)
        found[:3, :3], found[:3, 3] = pin.rpy.rpyToMatrix(*numbers(entry["rpy"])), position
        return found
    return pose(position, numbers(entry.get("quaternion", (0, 0, 0, 1))))


@dataclass
class Robot:
    """A robot of the scene as pinocchio has it: its base where the scene puts it, its meshes as coal has them."""

    name: str
    model: pin.Model
    shapes: dict[str, list[tuple[int, Array, Any]]]  # by link: supporting joint, pose there, geometry of coal
    mimics: dict[str, tuple[str, float, float]]
    limits: dict[str, dict[str, float]]  # by joint: velocity, acceleration, jerk
    positions: dict[str, tuple[float, float]]
    grip: float | None  # friction · force [N] of what is held
    frames: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.frames = {
            frame.name: i for i, frame in enumerate(self.model.frames) if frame.type == pin.FrameType.BODY
        }
        self.data = self.model.createData()

    def moving(self, joints: Any) -> set[int]:
        """The numbers of the pinocchio joints that some named joints turn, mimicking ones included."""
        named = set(joints)
        named |= {name for name in self.mimics if self._source(name)[0] in named}
        return {self.model.getJointId(name) for name in named if self.model.existJointName(name)}

    def _source(self, name: str) -> tuple[str, float, float]:
        source, ratio, offset = name, 1.0, 0.0
        while source in self.mimics:
            source, factor, shift = self.mimics[source]
            offset, ratio = ratio * shift + offset, ratio * factor
        return source, ratio, offset

    def full(self, values: dict[str, Array], order: int = 0) -> Array:
        """Configurations (T, nv) of pinocchio of named joints' values (T,); of derivatives with an order above 0."""
        size = max((np.size(value) for value in values.values()), default=1)
        q = np.zeros((size, self.model.nv))
        for j in range(1, self.model.njoints):
            name, at = self.model.names[j], self.model.idx_vs[j]
            source, ratio, offset = self._source(name)
            if source in values:
                q[:, at] = ratio * values[source] + (offset if order == 0 else 0.0)
            elif order == 0:
                low, high = self.positions.get(source, (-ENDLESS, ENDLESS))
                q[:, at] = ratio * np.clip(0.0, low, high) + offset
        return q

    def settled(self, joint: int, moving: set[int]) -> int:
        """The nearest joint towards the base, itself included, that is one of the moving ones; 0 if there is none."""
        while joint > 0 and joint not in moving:
            joint = self.model.parents[joint]
        return joint


@dataclass
class Scene:
    """Robots, the geometry of bodies, where fixed bodies stand, and what may always touch."""

    robots: dict[str, Robot]
    bodies: dict[str, Any]
    fixed: dict[str, Array]
    masses: dict[str, float]
    patterns: list[tuple[str, str]]

    def may_touch(self, first: str, second: str) -> bool:
        """Whether the scene always permits a contact of two bodies or links."""
        return any(
            (fnmatch.fnmatchcase(first, a) and fnmatch.fnmatchcase(second, b))
            or (fnmatch.fnmatchcase(first, b) and fnmatch.fnmatchcase(second, a))
            for a, b in self.patterns
        )


def load(problem: Path) -> Scene:
    """The scene of a problem, or the scene file itself."""
    said = yaml.safe_load(problem.read_text())
    file = (
        problem
        if "problem" not in said and "scene" in said and "robots" in said
        else problem.parent / said["scene"]
    )
    entry = yaml.safe_load(file.read_text())
    models, bodies = entry.get("models") or {}, dict(entry.get("objects") or {})
    added = said.get("bodies") or {} if file != problem else {}
    described = {name: {**models.get(own.get("model"), {}), **own} for name, own in {**bodies, **added}.items()}
    packages = {name: _package(name, where, file.parent) for name, where in (entry.get("packages") or {}).items()}
    robots, patterns = {}, [(str(a), str(b)) for a, b in entry.get("allowed_contacts") or ()]
    for name, own in (entry.get("robots") or {}).items():
        whole = {**(entry.get("robot_models") or {}).get(own.get("model"), {}), **own}
        robots[name] = _robot(name, whole, file.parent, packages)
        pairs = list(whole.get("allowed_contacts") or ()) + _disabled(whole, file.parent, packages)
        patterns += [(f"{name}.{a}", f"{name}.{b}") for a, b in pairs]
    shapes = {name: _shape(own, file.parent, packages) for name, own in described.items()}
    masses = {name: number(own["mass"]) for name, own in described.items() if "mass" in own}
    placed: dict[str, Array] = {}
    for name in described:
        _place(name, described, placed, robots)
    return Scene(robots, shapes, placed, masses, patterns)


def _place(name: str, described: dict[str, Any], placed: dict[str, Array], robots: dict[str, Robot]) -> Array:
    if name not in placed:
        entry = described[name].get("pose") or {}
        frame, here = entry.get("frame", "world"), written_pose(entry)
        if frame in described:
            here = _place(frame, described, placed, robots) @ here
        elif frame != "world":
            robot, _, link = frame.partition(".")
            model, data = robots[robot].model, robots[robot].data
            pin.framesForwardKinematics(model, data, robots[robot].full({})[0])
            here = data.oMf[robots[robot].frames[link]].homogeneous @ here
        placed[name] = here
    return placed[name]


def _package(name: str, where: str, folder: Path) -> Path:
    if where != "installed":
        return (folder / where).resolve()
    for file in importlib.metadata.files(name) or ():
        above = file.parts[:-1]
        for i, part in enumerate(above[:-1]):
            if part == "share" and above[i + 1] == name:
                return Path(str(importlib.metadata.distribution(name).locate_file(Path(*above[: i + 2]))))
    raise FileNotFoundError(f"no installed package {name}")


def _file(said: str, folder: Path, packages: dict[str, Path]) -> Path:
    if said.startswith("package://"):
        name, _, rest = said.removeprefix("package://").partition("/")
        if name in packages:
            return packages[name] / rest
        return next(
            where / "robots" / name / rest for where in packages.values() if (where / "robots" / name).exists()
        )
    return (folder / said.removeprefix("file://")).resolve()


def _shape(entry: dict[str, Any], folder: Path, packages: dict[str, Path]) -> Any:
    if "mesh" in entry:
        return _mesh(_file(entry["mesh"], folder, packages), number(entry.get("scale", 1.0)))
    if "box" in entry:
        return coal.Box(*numbers(entry["box"]))
    if "sphere" in entry:
        return coal.Sphere(number(entry["sphere"]["radius"]))
    if "cylinder" in entry:
        return coal.Cylinder(number(entry["cylinder"]["radius"]), number(entry["cylinder"]["height"]))
    return coal.Capsule(number(entry["capsule"]["radius"]), number(entry["capsule"]["length"]))


@cache
def _mesh(file: Path, scale: float) -> Any:
    return coal.MeshLoader().load(str(file), np.full(3, scale))


def _disabled(entry: dict[str, Any], folder: Path, packages: dict[str, Path]) -> list[tuple[str, str]]:
    if "srdf" not in entry:
        return []
    root = ET.parse(_file(entry["srdf"], folder, packages)).getroot()  # noqa: S314 - files of the repository
    return [(pair.get("link1", ""), pair.get("link2", "")) for pair in root.iter("disable_collisions")]


def _read(said: str, folder: Path, packages: dict[str, Path]) -> ET.Element:
    """A URDF: its links and joints alone; visual geometry is that of a link without other; meshes by whole paths."""
    file = _file(said, folder, packages)
    root = ET.parse(file).getroot()  # noqa: S314 - files of the repository
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(_file(mesh.get("filename", ""), file.parent, packages)))
    for element in list(root):
        if element.tag not in {"link", "joint"}:
            root.remove(element)
    for link in root.iter("link"):
        shown = link.findall("visual")
        if not link.findall("collision"):
            for each in shown:
                other = copy.deepcopy(each)
                other.tag = "collision"
                link.append(other)
        for each in (*shown, *link.findall("inertial")):
            link.remove(each)
    for joint in root.iter("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            limit = ET.SubElement(joint, "limit", effort="0", velocity="0") if limit is None else limit
            limit.set("lower", str(-ENDLESS))
            limit.set("upper", str(ENDLESS))
    return root


def _root_link(root: ET.Element) -> str:
    children = {child.get("link") for child in root.iter("child")}
    return next(link.get("name", "") for link in root.findall("link") if link.get("name") not in children)


def _fixed(root: ET.Element, name: str, parent: str, child: str, at: Array) -> None:
    joint = ET.SubElement(root, "joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    turn = " ".join(repr(float(x)) for x in pin.rpy.matrixToRpy(at[:3, :3]))
    ET.SubElement(joint, "origin", xyz=" ".join(repr(float(x)) for x in at[:3, 3]), rpy=turn)


def _driving(root: ET.Element, moves: dict[str, Any], first: str) -> str:
    """The link above a base that drives; its joints are added, if the URDF has none of their names."""
    names = moves.get("joints") or ("base_x", "base_y", "base_yaw")
    if {joint.get("name") for joint in root.iter("joint")} >= set(names):
        return first
    for joint in list(root.findall("joint")):
        if joint.get("type") in {"planar", "floating"}:
            joint.set("type", "fixed")
    turns = numbers(moves.get("turn", (-2 * np.pi, 2 * np.pi)))
    speed, turn_speed = number(moves.get("speed", 0.5)), number(moves.get("turn_speed", 1.0))
    parents = ["judge_floor", "judge_x", "judge_y"]
    for name, parent, child, axis, kind in zip(
        names,
        parents,
        (*parents[1:], first),
        ("1 0 0", "0 1 0", "0 0 1"),
        ("prismatic",) * 2 + ("revolute",),
        strict=True,
    ):
        ET.SubElement(root, "link", name=parent)
        joint = ET.SubElement(root, "joint", name=name, type=kind)
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=child)
        ET.SubElement(joint, "axis", xyz=axis)
        low, high = turns if kind == "revolute" else (-1e3, 1e3)
        fast = turn_speed if kind == "revolute" else speed
        ET.SubElement(joint, "limit", lower=str(low), upper=str(high), velocity=str(fast), effort="0")
    return parents[0]


def _robot(name: str, entry: dict[str, Any], folder: Path, packages: dict[str, Path]) -> Robot:
    root = _read(entry["urdf"], folder, packages)
    first, gripper = _root_link(root), entry.get("gripper") or {}
    if "urdf" in gripper:
        other = _read(gripper["urdf"], folder, packages)
        mounted = _root_link(other)
        root.extend(list(other))
        _fixed(root, "judge_mount", gripper["mount"], mounted, written_pose(gripper.get("pose")))
    base = entry.get("base") or {}
    if "moves" in base:
        first = _driving(root, base["moves"] or {}, first)
    ET.SubElement(root, "link", name="judge_world")
    _fixed(root, "judge_base", "judge_world", first, written_pose(base))
    text = ET.tostring(root, encoding="unicode")
    model = pin.buildModelFromXML(text)
    geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    shapes: dict[str, list[tuple[int, Array, Any]]] = {}
    for each in geometry.geometryObjects:
        link = model.frames[each.parentFrame].name
        shapes.setdefault(link, []).append((each.parentJoint, each.placement.homogeneous, each.geometry))
    mimics = {}
    for joint in root.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            ratio, offset = float(mimic.get("multiplier", 1.0)), float(mimic.get("offset", 0.0))
            mimics[joint.get("name", "")] = (mimic.get("joint", ""), ratio, offset)
    grip = number(gripper["force"]) * number(gripper.get("friction", 0.5)) if "force" in gripper else None
    return Robot(name, model, shapes, mimics, _limits(root, entry), _positions(root, entry), grip)


def _positions(root: ET.Element, entry: dict[str, Any]) -> dict[str, tuple[float, float]]:
    found = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if limit is not None and joint.get("type") in {"revolute", "prismatic"}:
            found[joint.get("name", "")] = (float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0)))
    for name, said in (entry.get("limits") or {}).items():
        pair = said.get("position") if isinstance(said, dict) else said
        if pair is not None:
            found[name] = (number(pair[0]), number(pair[1]))
    return found


def _limits(root: ET.Element, entry: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Velocity, acceleration and jerk of every joint that has a velocity."""
    found = {}
    for joint in root.findall("joint"):
        limit, name = joint.find("limit"), joint.get("name", "")
        if limit is None:
            continue
        own: dict[str, float] = {}
        long = (entry.get("limits") or {}).get(name)
        for kind in KINDS:
            said = entry.get(kind)
            said = said.get(name) if isinstance(said, dict) else said
            if isinstance(long, dict) and kind in long:
                said = long[kind]
            if said is not None:
                own[kind] = number(said)
        velocity = min(float(limit.get("velocity", 0.0)), own.get("velocity", np.inf))
        acceleration = own.get("acceleration", velocity / RISE)
        jerk = own.get("jerk", acceleration / JERK_RISE)
        found[name] = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
    return found
