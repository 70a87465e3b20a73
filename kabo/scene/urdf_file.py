"""The contents of a URDF file that pinocchio does not read for kabo: link geometry and mimic joints."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element  # noqa: S405  for types; what is read is checked by `urdf_text`

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, KaboError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, load_mesh, outwards
from kabo.scene.shapes import primitive
from kabo.scene.urdf_text import Urdf, kinematics, mimic_of, named, origin_of, read_text

SHAPES = ("mesh", "box", "cylinder", "sphere")


def refusal(place: Place | None, message: str, hint: str | None = None) -> InputError:
    """The error about an entry of a scene file, at its place."""
    at = place or Place("scene", 1, 1)
    return InputError([Diagnostic(at.file, at.line, at.column, message, hint, at.length)])


@dataclass(frozen=True)
class UrdfFile:
    """A URDF file apart from pinocchio's model: link meshes (link frame, metres), mimic rules, files read."""

    path: Path
    meshes: Mapping[str, Mesh]
    mimics: Mapping[str, tuple[str, float, float]]  # joint -> (source, multiplier, offset)
    kinematics: str  # a URDF text of the checked links and joints alone, for pinocchio
    places: Mapping[str, Place]  # of the links
    files: tuple[Path, ...] = field(default=())


def pinocchio() -> Any:
    """The imported pinocchio module; raises InputError with a one-line message if it cannot be imported."""
    try:
        import pinocchio as module
    except ImportError as error:
        if "libgomp" in str(error):
            raise KaboError(
                "pinocchio needs the system library libgomp1; on Debian: apt-get install libgomp1"
            ) from None
        raise KaboError(f"pinocchio cannot be imported: {error}") from None
    return module


def read_urdf(path: Path, packages: Mapping[str, Path], place: Place | None, *, drives: bool = False) -> UrdfFile:
    """The links' geometry (collision, else visual), the mimic rules and the kinematics of a URDF file.

    If the robot `drives`, its first joint may be planar or floating.

    Raises:
        InputError: the file is not XML, has impossible values, or names a mesh that does not load.
    """
    urdf = read_text(path, place, drives=drives)
    meshes, files = {}, [path]
    for name, link in named(urdf, "link"):
        shapes = link.findall("collision") or link.findall("visual")
        pieces = [_piece(urdf, shape, packages, place, files) for shape in shapes]
        if pieces:
            meshes[name] = _merged(pieces)
    rules = {name: rule for name, joint in named(urdf, "joint") if (rule := mimic_of(urdf, joint)) is not None}
    places = {name: Place(str(path), *urdf.places[link], len("<link")) for name, link in named(urdf, "link")}
    return UrdfFile(path, meshes, rules, kinematics(urdf), places, tuple(files))


def _origin(urdf: Urdf, element: Element) -> Array:
    xyz, (roll, pitch, yaw) = origin_of(urdf, element)
    matrix: Array = np.eye(4)
    matrix[:3, :3] = pinocchio().rpy.rpyToMatrix(roll, pitch, yaw) if roll or pitch or yaw else np.eye(3)
    matrix[:3, 3] = xyz
    return matrix


def _piece(
    urdf: Urdf, element: Element, packages: Mapping[str, Path], place: Place | None, files: list[Path]
) -> Mesh:
    geometry = element.find("geometry")
    shape = None if geometry is None else next(iter(geometry), None)
    if shape is None:
        raise urdf.wrong(element, f'robot file "{urdf.path.name}": a link has an empty geometry')
    if shape.tag == "mesh":
        path = _locate(urdf, shape, packages, place)
        files.append(path)
        scale = urdf.numbers(shape, "scale", 3, "1 1 1")
        if not min(map(abs, scale)) >= 1e-9:
            raise urdf.wrong(shape, "a mesh cannot be scaled by 0", "write 0.001 for millimetres")
        made = outwards(load_mesh(path, scale, place))[0]
    elif shape.tag == "box":
        x, y, z = urdf.size(shape, "size", 3)
        made = primitive(Shape("box", size=(x, y, z)))
    elif shape.tag == "cylinder":
        (radius,), (length,) = urdf.size(shape, "radius"), urdf.size(shape, "length")
        made = primitive(Shape("cylinder", size=(radius, radius, length)))
    elif shape.tag == "sphere":
        (radius,) = urdf.size(shape, "radius")
        made = primitive(Shape("sphere", size=(radius, radius, radius)))
    else:
        hint = did_you_mean(shape.tag, SHAPES) or f"kabo reads {', '.join(SHAPES)}"
        raise urdf.wrong(shape, f'robot file "{urdf.path.name}": unknown geometry <{shape.tag}>', hint)
    return made.moved(_origin(urdf, element))


def _locate(urdf: Urdf, shape: Element, packages: Mapping[str, Path], place: Place | None) -> Path:
    name = shape.get("filename", "")
    if "\0" in name or not name.strip():
        raise urdf.wrong(shape, "a <mesh> names no file", 'write filename="…"')
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        if package not in packages:
            hint = did_you_mean(package, packages) or f"add packages: {{{package}: FOLDER}} to the scene"
            raise refusal(place, f'robot file "{urdf.path.name}" names the unknown package "{package}"', hint)
        path = packages[package] / rest
    else:
        path = urdf.path.parent / name.removeprefix("file://")
    try:
        present = path.is_file()
    except (OSError, ValueError):  # too long a name
        present = False
    if not present:
        raise refusal(place, f'robot file "{urdf.path.name}" names the mesh "{name}", which does not exist')
    return path


def _merged(pieces: list[Mesh]) -> Mesh:
    if len(pieces) == 1:
        return pieces[0]
    offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    faces = np.concatenate([piece.faces + offset for piece, offset in zip(pieces, offsets, strict=False)])
    return Mesh(np.concatenate([piece.vertices for piece in pieces]), faces)
