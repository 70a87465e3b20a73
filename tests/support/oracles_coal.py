"""Where links are and how near meshes come, by pinocchio from the URDF files and by coal on the original meshes.

Nothing here is kabo's: joints are read by pinocchio, mimics from the file's text, distances are coal's.
"""

from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio

_MESHES: dict[str, coal.BVHModelOBBRSS] = {}


class Kinematics:
    """Poses of the links of a robot that is one URDF file, or an arm with a gripper mounted on a link of it."""

    def __init__(self, arm: Path, base: np.ndarray, gripper: Path | None = None, mount: str = "") -> None:
        self.base, self.mount = base, mount
        self.parts = [_Part(arm)] + ([] if gripper is None else [_Part(gripper)])

    def poses(self, values: dict[str, float]) -> dict[str, np.ndarray]:
        """world_T_link (4, 4) of every link, with joints at `values`."""
        found = {name: self.base @ pose for name, pose in self.parts[0].poses(values).items()}
        for part in self.parts[1:]:
            found |= {name: found[self.mount] @ pose for name, pose in part.poses(values).items()}
        return found


class _Part:
    def __init__(self, path: Path) -> None:
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        root = ElementTree.parse(path).getroot()  # noqa: S314 - a file of the repository
        self.mimics = {
            joint.attrib["name"]: (
                found.attrib["joint"],
                float(found.attrib.get("multiplier", 1)),
                float(found.attrib.get("offset", 0)),
            )
            for joint in root.findall("joint")
            if (found := joint.find("mimic")) is not None
        }
        self.links = [link.attrib["name"] for link in root.findall("link")]

    def poses(self, values: dict[str, float]) -> dict[str, np.ndarray]:
        q = pinocchio.neutral(self.model)
        for joint in range(1, self.model.njoints):
            name = self.model.names[joint]
            source, factor, offset = self.mimics.get(name, (name, 1.0, 0.0))
            q[self.model.idx_qs[joint]] = factor * values[source] + offset
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        return {
            name: self.data.oMf[self.model.getFrameId(name, pinocchio.FrameType.BODY)].homogeneous.copy()
            for name in self.links
        }


def arms(
    bases: dict[str, tuple[float, float, float]], meshes: Path, arm: str, gripper: str
) -> dict[str, Kinematics]:
    """Of generated arms that stand upright at some places, each with a gripper at `tool0`."""
    files = meshes / arm / f"{arm}.urdf", meshes / gripper / f"{gripper}.urdf"
    found = {}
    for name, place in bases.items():
        base = np.eye(4)
        base[:3, 3] = place
        found[name] = Kinematics(files[0], base, files[1], "tool0")
    return found


def distance(first: object, first_T: np.ndarray, second: object, second_T: np.ndarray) -> float:
    """The distance [m] of two meshes at world_T_mesh (4, 4): 0 or less where they touch."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(_model(first), _at(first_T), _model(second), _at(second_T), request, result))


def _at(pose: np.ndarray) -> coal.Transform3s:
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


def _model(mesh) -> coal.BVHModelOBBRSS:  # type: ignore[no-untyped-def]
    if mesh.digest not in _MESHES:
        made = coal.BVHModelOBBRSS()
        made.beginModel(len(mesh.faces), len(mesh.vertices))
        made.addVertices(np.asarray(mesh.vertices))
        made.addTriangles(np.asarray(mesh.faces, dtype=np.int64))
        made.endModel()
        _MESHES[mesh.digest] = made
    return _MESHES[mesh.digest]
