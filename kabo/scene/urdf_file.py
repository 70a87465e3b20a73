"""What pinocchio leaves in a URDF file: the geometry of links and the rules of mimic joints."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree  # noqa: S405  expat of every supported Python limits entity expansion

import numpy as np
import numpy.typing as npt

from kabo.errors import Diagnostic, InputError, KaboError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, load_mesh
from kabo.scene.shapes import primitive

Array = npt.NDArray[np.float64]


def refusal(place: Place | None, message: str, hint: str | None = None) -> InputError:
    """The error about what a scene says at a place."""
    at = place or Place("scene", 1, 1)
    return InputError([Diagnostic(at.file, at.line, at.column, message, hint, at.length)])


@dataclass(frozen=True)
class UrdfFile:
    """What is read of a URDF beside pinocchio: link meshes (link frame, metres), mimic rules, files read."""

    path: Path
    meshes: Mapping[str, Mesh]
    mimics: Mapping[str, tuple[str, float, float]]  # joint -> (source, multiplier, offset)
    files: tuple[Path, ...] = field(default=())


def pinocchio() -> Any:
    """The pinocchio module, or one line that says what its import lacks."""
    try:
        import pinocchio as module
    except ImportError as error:
        if "libgomp" in str(error):
            raise KaboError(
                "pinocchio needs the system library libgomp1; on Debian: apt-get install libgomp1"
            ) from None
        raise KaboError(f"pinocchio cannot be imported: {error}") from None
    return module


def read_urdf(path: Path, packages: Mapping[str, Path], place: Place | None) -> UrdfFile:
    """The links' geometry (collision, else visual) and the mimic rules of a URDF file.

    Raises:
        InputError: the file is not XML, or names a mesh that does not load.
    """
    try:
        root = ElementTree.parse(path).getroot()  # noqa: S314
    except (ElementTree.ParseError, OSError, UnicodeDecodeError) as error:
        raise refusal(place, f'robot file "{path.name}" cannot be read: {error}') from None
    if root.tag != "robot":
        raise refusal(place, f'robot file "{path.name}" has <{root.tag}> where <robot> is expected')
    meshes, files = {}, [path]
    for link in root.iter("link"):
        shapes = link.findall("collision") or link.findall("visual")
        pieces = [_piece(shape, path, packages, place, files) for shape in shapes]
        if pieces:
            meshes[link.get("name", "")] = _merged(pieces)
    mimics = {}
    for joint in root.iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            factors = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            mimics[joint.get("name", "")] = (mimic.get("joint", ""), *factors)
    return UrdfFile(path, meshes, mimics, tuple(files))


def _numbers(text: str | None, default: str) -> list[float]:
    return [float(word) for word in (text or default).split()]


def _origin(element: Any) -> Array:
    origin = element.find("origin")
    xyz = _numbers(None if origin is None else origin.get("xyz"), "0 0 0")
    roll, pitch, yaw = _numbers(None if origin is None else origin.get("rpy"), "0 0 0")
    matrix: Array = np.eye(4)
    matrix[:3, :3] = pinocchio().rpy.rpyToMatrix(roll, pitch, yaw) if roll or pitch or yaw else np.eye(3)
    matrix[:3, 3] = xyz
    return matrix


def _piece(element: Any, urdf: Path, packages: Mapping[str, Path], place: Place | None, files: list[Path]) -> Mesh:
    geometry = element.find("geometry")
    shape = None if geometry is None else next(iter(geometry), None)
    if shape is None:
        raise refusal(place, f'robot file "{urdf.name}": a link has an empty geometry')
    if shape.tag == "mesh":
        path = _locate(shape.get("filename", ""), urdf, packages, place)
        files.append(path)
        made = load_mesh(path, _numbers(shape.get("scale"), "1 1 1"), place)
    elif shape.tag == "box":
        x, y, z = _numbers(shape.get("size"), "0 0 0")
        made = primitive(Shape("box", size=(x, y, z)))
    elif shape.tag == "cylinder":
        radius, length = float(shape.get("radius", "0")), float(shape.get("length", "0"))
        made = primitive(Shape("cylinder", size=(radius, radius, length)))
    elif shape.tag == "sphere":
        radius = float(shape.get("radius", "0"))
        made = primitive(Shape("sphere", size=(radius, radius, radius)))
    else:
        raise refusal(place, f'robot file "{urdf.name}": unknown geometry <{shape.tag}>')
    return made.moved(_origin(element))


def _locate(name: str, urdf: Path, packages: Mapping[str, Path], place: Place | None) -> Path:
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        if package not in packages:
            hint = did_you_mean(package, packages) or f"add packages: {{{package}: FOLDER}} to the scene"
            raise refusal(place, f'robot file "{urdf.name}" names the unknown package "{package}"', hint)
        path = packages[package] / rest
    else:
        path = urdf.parent / name.removeprefix("file://")
    if not path.is_file():
        raise refusal(place, f'robot file "{urdf.name}" names the mesh "{name}", which does not exist')
    return path


def _merged(pieces: list[Mesh]) -> Mesh:
    if len(pieces) == 1:
        return pieces[0]
    offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    faces = np.concatenate([piece.faces + offset for piece, offset in zip(pieces, offsets, strict=False)])
    return Mesh(np.concatenate([piece.vertices for piece in pieces]), faces)
