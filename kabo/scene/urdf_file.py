"""The contents of a URDF file that pinocchio does not read for kabo: link geometry and mimic joints."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element as Tag  # noqa: S405  for types; what is read is checked by `urdf_files`

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, KaboError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.robot_files.packages import SCHEME, known_packages, package_folder, searched_places
from kabo.language.robot_files.xml_files import Collected
from kabo.language.scene_description import Shape
from kabo.meshes import load_mesh, outwards
from kabo.scene.elements import Element
from kabo.scene.mimic_limits import MimicJoint, mimic_joint
from kabo.scene.semantics import JointEnds
from kabo.scene.shapes import element_of
from kabo.scene.urdf_files.checks import check
from kabo.scene.urdf_files.elements import Urdf, kinematics, mimic_of, named, origin_of, read_elements

SHAPES = ("mesh", "box", "cylinder", "sphere", "capsule")


def refusal(place: Place | None, message: str, hint: str | None = None) -> InputError:
    """The error about an entry of a scene file, at its place."""
    at = place or Place("scene", 1, 1)
    return InputError([Diagnostic(at.file, at.line, at.column, message, hint, at.length)])


@dataclass(frozen=True)
class UrdfFile:
    """A URDF file apart from pinocchio's model: links' elements (link frame, metres), mimic rules, files read."""

    path: Path
    elements: Mapping[str, tuple[Element, ...]]
    mimics: Mapping[str, MimicJoint]  # each follows a joint that moves on its own
    kinematics: str  # a URDF text of the checked links and joints alone, for pinocchio
    places: Mapping[str, Place]  # of the links
    joints: Mapping[str, JointEnds]
    files: tuple[Path, ...] = field(default=())
    visual: tuple[str, ...] = ()  # the links without collision geometry, whose visual geometry is used
    zones: frozenset[str] = frozenset()  # the links with collision geometry alone, where others have a visual one


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
    urdf, read = read_elements(path, packages, place)
    collected = Collected(check(urdf, drives=drives))
    elements, files = {}, list(read)
    for name, link in named(urdf, "link"):
        pieces = []
        for shape in link.findall("collision") or link.findall("visual"):
            with collected.kept(), _told_of(urdf, name, shape):
                pieces.append(_element(urdf, shape, packages, place, files))
        if pieces:
            elements[name] = tuple(pieces)
    collected.finish()
    visual = tuple(
        name for name, link in named(urdf, "link") if name in elements and link.find("collision") is None
    )
    places = {name: urdf.place(link) for name, link in named(urdf, "link")}
    rest = _joints(urdf), tuple(files), visual, _zones(urdf, elements)
    return UrdfFile(path, elements, _mimics(urdf), kinematics(urdf), places, *rest)


def _zones(urdf: Urdf, elements: Mapping[str, tuple[Element, ...]]) -> frozenset[str]:
    """The links with a shape that nothing shows; none in a file without visual geometry."""
    shown = {name for name, link in named(urdf, "link") if link.find("visual") is not None}
    return frozenset(elements) - shown if shown else frozenset()


def _joints(urdf: Urdf) -> dict[str, JointEnds]:
    """The joints by name: their links and types."""
    found = {}
    for name, joint in named(urdf, "joint"):
        parent, child = (joint.find(tag) for tag in ("parent", "child"))
        if parent is not None and child is not None:
            ends = parent.get("link", ""), child.get("link", "")
            found[name] = JointEnds(*ends, joint.get("type", "fixed"))
    return found


@contextmanager
def _told_of(urdf: Urdf, link: str, shape: Tag) -> Iterator[None]:
    """Errors of a mesh file as findings at the shape in the URDF that names it, with the link."""
    try:
        yield
    except InputError as error:
        at = next((each for each in shape.iter("mesh")), shape)
        found = [
            each
            if each.file == str(urdf.path)
            else urdf.finding(at, f'link "{link}": {each.message}', each.hint or _MESH_REMEDY)
            for each in error.diagnostics
        ]
        raise InputError(found) from None


_MESH_REMEDY = "export the mesh again, or give the link a box, cylinder or sphere"


def _mimics(urdf: Urdf) -> dict[str, MimicJoint]:
    """The mimic joints; a joint that mimics a mimic joint follows the one that moves."""
    rules = {name: rule for name, joint in named(urdf, "joint") if (rule := mimic_of(urdf, joint)) is not None}
    for name, (source, factor, offset) in list(rules.items()):
        while source in rules:
            source, ratio, shift = rules[source]
            factor, offset = factor * ratio, factor * shift + offset
        rules[name] = source, factor, offset
    return {
        name: mimic_joint(urdf, name, joint, rules[name]) for name, joint in named(urdf, "joint") if name in rules
    }


def _origin(urdf: Urdf, element: Tag) -> Array:
    xyz, (roll, pitch, yaw) = origin_of(urdf, element)
    matrix: Array = np.eye(4)
    matrix[:3, :3] = pinocchio().rpy.rpyToMatrix(roll, pitch, yaw) if roll or pitch or yaw else np.eye(3)
    matrix[:3, 3] = xyz
    return matrix


def _element(
    urdf: Urdf, tag: Tag, packages: Mapping[str, Path], place: Place | None, files: list[Path]
) -> Element:
    geometry = tag.find("geometry")
    given = None if geometry is None else next(iter(geometry), None)
    if given is None:
        hint = f"write one shape in it ({', '.join(SHAPES)}), or leave the <{tag.tag}> out"
        raise urdf.wrong(tag, f'robot file "{urdf.path.name}": a link has an empty geometry', hint)
    at = Place(str(urdf.path), *urdf.places[given], len(given.tag) + 1)
    if given.tag == "mesh":
        path = _locate(urdf, given, packages, place)
        files.append(path)
        scale = urdf.numbers(given, "scale", 3, "1 1 1")
        if not min(map(abs, scale)) >= 1e-9:
            raise urdf.wrong(given, "a mesh cannot be scaled by 0", "write 0.001 for millimetres")
        made = Element("mesh", outwards(load_mesh(path, scale, place))[0], place=at, path=path)
    else:
        made = element_of(_primitive(urdf, given), at)
    return made.moved(_origin(urdf, tag))


def _primitive(urdf: Urdf, tag: Tag) -> Shape:
    if tag.tag == "box":
        x, y, z = urdf.size(tag, "size", 3)
        return Shape("box", size=(x, y, z))
    if tag.tag in ("cylinder", "capsule"):
        (radius,), (length,) = urdf.size(tag, "radius"), urdf.size(tag, "length")
        return Shape("cylinder" if tag.tag == "cylinder" else "capsule", size=(radius, radius, length))
    if tag.tag == "sphere":
        (radius,) = urdf.size(tag, "radius")
        return Shape("sphere", size=(radius, radius, radius))
    hint = did_you_mean(tag.tag, SHAPES) or f"kabo reads {', '.join(SHAPES)}"
    raise urdf.wrong(tag, f'robot file "{urdf.path.name}": unknown geometry <{tag.tag}>', hint)


def _locate(urdf: Urdf, shape: Tag, packages: Mapping[str, Path], place: Place | None) -> Path:
    name = shape.get("filename", "")
    if "\0" in name or not name.strip():
        raise urdf.wrong(shape, "a <mesh> names no file", 'write filename="…"')
    if name.startswith(SCHEME):
        package, _, rest = name.removeprefix(SCHEME).partition("/")
        folder = package_folder(package, packages, urdf.path)
        if folder is None:
            said = f'robot file "{urdf.path.name}" names the unknown package "{package}"'
            near = did_you_mean(package, known_packages(packages, urdf.path))
            hint = f"add packages: {{{package}: FOLDER}} to the scene; looked for in {searched_places()}"
            raise urdf.wrong(shape, said, hint if near is None else f"{near} Else {hint}")
        path = folder / rest
    else:
        path = urdf.path.parent / name.removeprefix("file://")
    try:
        present = path.is_file()
    except (OSError, ValueError):  # too long a name
        present = False
    if not present:
        said = f'robot file "{urdf.path.name}" names the mesh "{name}", which does not exist'
        raise urdf.wrong(shape, said, _remedy_for(name, path))
    return path


def _remedy_for(name: str, path: Path) -> str:
    """What helps where a mesh that a URDF names is not there."""
    scheme, found, _ = name.partition("://")
    if found and scheme != "file":
        ways = "download the mesh, and name the file" if scheme in ("http", "https") else "name the file"
        return f"{scheme}:// is not read: {ways}, or package://NAME/…"
    if "$(" in name:
        return "$( ) is xacro: expand the file, or let its name end in .xacro"
    return f"{path} is a folder" if path.is_dir() else _similar(path) or f"looked for {path}"


def _similar(path: Path) -> str | None:
    """The remedy `did you mean "…"?` for a missing file, from the names in its folder."""
    try:
        return did_you_mean(path.name, [each.name for each in path.parent.iterdir()])
    except (OSError, ValueError):
        return None
