"""Problems of MotionBenchMaker, as MoveIt writes them, made into scenes of kabo.

A folder holds one folder for each set of problems, and in it `sceneNNNN.yaml` (what stands there) beside
`requestNNNN.yaml` (where the robot starts, and what it shall reach); two folders above lie `NAME.urdf`, `NAME.srdf` and
`meshes`, as in the resources of VAMP. Bodies are boxes, cylinders and spheres. Everything else of the files is left
alone; what the SRDF lets touch may touch.
"""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

# Links with meshes that are not closed: their convex hulls, which are larger, stand for them.
HULLS = {
    "panda": ("panda_link6",),
    "baxter": ("torso", "torso_collision_4", "screen"),
    "ur5": (
        "fts_robotside",
        "robotiq_85_base_link",
        "robotiq_85_left_finger_tip_link",
        "robotiq_85_right_finger_tip_link",
    ),
}
ROUNDING = 1e-5  # [rad or m] by which an end may be beyond the limits of the URDF
_BODIES = {"box": 3, "cylinder": 2, "sphere": 1}


@dataclass(frozen=True)
class Robot:
    """The robot of a folder of problems: its files, its planned joints, and what it is called in scenes."""

    name: str
    urdf: Path
    joints: tuple[str, ...]

    @property
    def resources(self) -> Path:
        """The folder of its files."""
        return self.urdf.parent


@dataclass(frozen=True)
class MotionProblem:
    """One problem: the bodies, and the configurations at both ends."""

    name: str
    robot: Robot
    bodies: tuple[Mapping[str, Any], ...]
    start: tuple[float, ...]
    goal: tuple[float, ...]

    def scene(self, epsilon: float) -> str:
        """The text of a scene with the robot at the start."""
        robot = {
            "urdf": str(self.robot.urdf),
            "srdf": str(self.robot.urdf.with_suffix(".srdf")),
            "joints": list(self.robot.joints),
            "hulls": list(HULLS.get(self.robot.name, ())),
            "configurations": {"home": list(self.start), "goal": list(self.goal)},
        }
        objects = {body["name"]: {k: v for k, v in body.items() if k != "name"} for body in self.bodies}
        description = {
            "scene": self.name.replace("/", "_"),
            "epsilon": epsilon,
            "packages": {"meshes": str(self.robot.resources / "meshes")},
            "robots": {self.robot.name: robot},
            "objects": objects,
        }
        return yaml.safe_dump(description, sort_keys=False)


def robot_files(folder: Path, target: Path) -> Path:
    """Copies the robot's URDF and SRDF beside a link to its meshes, and returns the URDF.

    In the Panda's URDF a fixed joint mimics another: that says nothing, and is left out.
    """
    urdf = next(path for path in sorted(folder.parent.glob("*.urdf")) if "spherized" not in path.name)
    target.mkdir(parents=True, exist_ok=True)
    fixed = re.compile(r'(<joint [^>]*type="fixed"(?:(?!</joint>).)*?)<mimic[^>]*>(?:\s*</mimic>)?', re.DOTALL)
    (target / urdf.name).write_text(fixed.sub(r"\1", urdf.read_text()))
    (target / f"{urdf.stem}.srdf").write_bytes(urdf.with_suffix(".srdf").read_bytes())
    if not (target / "meshes").exists():
        (target / "meshes").symlink_to((folder.parent / "meshes").resolve(), target_is_directory=True)
    return target / urdf.name


def problems(folder: Path, urdf: Path, every: int = 1) -> Iterator[MotionProblem]:
    """The problems of a folder for the robot of a URDF, set by set; every n-th of each set."""
    for each in sorted(path for path in folder.iterdir() if path.is_dir()):
        for request in sorted(each.glob("request*.yaml"))[::every]:
            scene = request.with_name(request.name.replace("request", "scene"))
            if scene.is_file():
                yield _problem(f"{each.name}/{request.stem[-4:]}", urdf, _read(scene), _read(request))


def _problem(name: str, urdf: Path, scene: Any, request: Any) -> MotionProblem:
    goal = {
        one["joint_name"]: float(one["position"])
        for constraint in request["goal_constraints"]
        for one in constraint["joint_constraints"]
    }
    state = request["start_state"]["joint_state"]
    start = dict(zip(state["name"], map(float, state["position"]), strict=True))
    robot = Robot(urdf.stem, urdf, tuple(joint for joint in start if joint in goal))
    bodies, limits = tuple(_bodies(scene["world"]["collision_objects"])), _limits(urdf)
    ends = (tuple(_within(end[joint], limits.get(joint)) for joint in robot.joints) for end in (start, goal))
    return MotionProblem(name, robot, bodies, *ends)


def _limits(urdf: Path) -> dict[str, tuple[float, float]]:
    """The limits of those joints that have some."""
    found = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):  # noqa: S314 - a robot of the benchmark
        limit = joint.find("limit")
        if limit is not None and joint.get("type") in ("revolute", "prismatic"):
            found[joint.attrib["name"]] = float(limit.get("lower", 0)), float(limit.get("upper", 0))
    return found


def _within(value: float, limits: tuple[float, float] | None) -> float:
    """A value that is beyond its limits by no more than their rounding (of Fetch pi is 3.14159), moved to them."""
    if limits is None:
        return value
    nearest = min(max(value, limits[0]), limits[1])
    return nearest if abs(value - nearest) < ROUNDING else value


def _bodies(objects: Any) -> Iterator[Mapping[str, Any]]:
    for one in objects:
        pairs = list(zip(one["primitives"], one["primitive_poses"], strict=True))
        for number, (primitive, pose) in enumerate(pairs):
            name = one["id"] if len(pairs) == 1 else f"{one['id']}_{number}"
            sizes = [float(size) for size in primitive["dimensions"]]
            assert len(sizes) == _BODIES[primitive["type"]], primitive
            shape: dict[str, Any] = {"box": sizes}
            if primitive["type"] == "cylinder":
                shape = {"cylinder": {"height": sizes[0], "radius": sizes[1]}}
            elif primitive["type"] == "sphere":
                shape = {"sphere": {"radius": sizes[0]}}
            place = {"position": list(pose["position"]), "quaternion": _unit(pose["orientation"])}
            yield {"name": re.sub("[^a-z0-9_]", "_", name.lower()), **shape, "pose": place}


def _unit(quaternion: Any) -> list[float]:
    length = sum(float(v) ** 2 for v in quaternion) ** 0.5
    return [float(v) / length for v in quaternion]


def _read(path: Path) -> Any:
    with path.open() as file:
        return yaml.load(file, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506  a safe one
