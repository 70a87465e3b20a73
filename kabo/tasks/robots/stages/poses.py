"""Poses as task files write them, and generators of poses: from a list, from a function, or at random."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Situation
from kabo.kinematics import uniform
from kabo.scene import Scene
from kabo.scene.transforms import transform
from kabo.streams import stream_key
from kabo.tasks.core import Generator, Monitor, Property, Result
from kabo.tasks.core.model.results import Answer, Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import ROBOT, RobotStage
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from kabo.tasks.robots.scenes import TaskScene

_KEYS = ("frame", "position", "quaternion", "rpy")
QUATERNION_TOLERANCE = 1e-6  # how much the length of a quaternion may differ from 1 [docs/reference/scenes.md]


def pose_of(scene: TaskScene, given: Any) -> Array:
    """The pose (4, 4) in the world that a value describes: a matrix, or {frame, position, quaternion or rpy}.

    `frame` is `world`, a body, a region or `robot.link`.

    Raises:
        ValueError: the value describes no pose.
    """
    if isinstance(given, np.ndarray) and given.shape == (4, 4):
        return given
    if isinstance(given, Mapping):
        frame = scene.frame(str(given.get("frame", "world")))
        return np.asarray(frame @ local_pose(given))
    raise ValueError(f"a pose is {{frame, position, quaternion or rpy}} or a matrix (4, 4), not {given!r}")


def local_pose(given: Mapping[str, Any]) -> Array:
    """The pose (4, 4) in its frame that {position [m], quaternion (x, y, z, w) or rpy [rad]} describes.

    Raises:
        ValueError: unknown keys, missing numbers, both kinds of rotation, or a quaternion that is not of length 1.
    """
    for key in given:
        if key not in _KEYS:
            near = get_close_matches(key, _KEYS, 1)
            meant = f", did you mean {near[0]!r}?" if near else f"; it has {', '.join(_KEYS)}"
            raise ValueError(f"a pose has no {key!r}{meant}")
    if "quaternion" in given and "rpy" in given:
        raise ValueError("a pose is turned by quaternion or by rpy, not both")
    position = _numbers(given, "position", (0.0, 0.0, 0.0))
    if "quaternion" in given:
        turn = _numbers(given, "quaternion", (0.0, 0.0, 0.0, 1.0))
        if abs(np.linalg.norm(turn) - 1.0) > QUATERNION_TOLERANCE:
            raise ValueError(f"a quaternion has length 1, not {np.linalg.norm(turn):.6g}")
        return transform(position.tolist(), (turn / np.linalg.norm(turn)).tolist())
    result = transform(position.tolist())
    result[:3, :3] = from_rpy(_numbers(given, "rpy", (0.0, 0.0, 0.0)).tolist())
    return result


def _numbers(given: Mapping[str, Any], key: str, default: tuple[float, ...]) -> Array:
    value, words = given.get(key, default), {3: "three", 4: "four"}
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (len(default),) or not np.all(np.isfinite(found)):
        raise ValueError(f"{key}: {words[len(default)]} finite numbers, not {value!r}")
    return found


def from_rpy(angles: Sequence[float]) -> Array:
    """The rotation (3, 3) of roll, pitch, yaw as in URDF."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.asarray(angles, float)), np.sin(np.asarray(angles, float))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


class _Poses(RobotStage):
    WRITES = ("target", "target_pose")
    PROPERTIES = {
        "robot": ROBOT,
        "poses": Property(
            (list, tuple, Callable),
            (),
            "a list of poses, or a function of the scene that returns them; empty: only random poses",
        ),
        "random": Property(
            dict,
            {},
            "{count, around: pose, position: [dx, dy, dz], rpy: [dr, dp, dy]} with half ranges; empty: no random poses",
            meanings.spread,
        ),
        "of": Property(
            (str, type(None)),
            None,
            "what the pose is for: the tool (none), a link, what is held, a feature",
            meanings.name,
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """No poses at all, or a frame that the scene lacks."""
        given = self.known("poses")
        listed = (
            not self.undecided("poses")
            and not self.undecided("random")
            and given is not None
            and not callable(given)
        )
        if listed and not len(given) and not self.known("random"):
            yield "there are no poses: neither `poses` nor `random` says any"

    def _offered(self, scene: TaskScene, properties: Values) -> Iterator[Answer]:
        robot = properties["robot"]
        frame = frame_for(scene, robot, properties["of"])
        for pose in _poses(scene, properties, f"{robot}/{self.name}"):
            target = pose_target(scene, robot, frame, pose)
            yield Result(scene, properties={"target": target, "target_pose": pose})


class PoseGenerator(_Poses, Generator):
    """Writes poses for inverse kinematics, in the task's first scene."""

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result with the scene for each pose, with interface properties `target` and `target_pose`."""
        return self._offered(scene, properties)


class MonitoredPoses(_Poses, Monitor):
    """Writes poses for inverse kinematics, in the scene at the end of another stage."""

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result with the scene for each pose, with interface properties `target` and `target_pose`."""
        return self._offered(scene, properties)


def _poses(scene: TaskScene, properties: Values, key: str) -> Iterator[Array]:
    given, random = properties["poses"], properties["random"]
    for each in given(scene) if callable(given) else given:
        yield pose_of(scene, each)
    if not random:
        return
    stream = stream_key(scene.context.seed, "poses", key)
    around = pose_of(scene, random.get("around", {}))
    spans = np.array([*random.get("position", (0.0, 0.0, 0.0)), *random.get("rpy", (0.0, 0.0, 0.0))], float)
    for number in range(int(random.get("count", 1))):
        drawn = spans * np.array([2.0 * uniform(stream, number, i) - 1.0 for i in range(6)])
        moved = around.copy()
        moved[:3, 3] += drawn[:3]
        moved[:3, :3] = around[:3, :3] @ from_rpy(drawn[3:])
        yield moved
