"""Reads URDF files: checked elements with their places, from `.urdf` files and from what xacro makes of `.xacro` files.

Errors are found before pinocchio's parser sees the file [`checks`]: pinocchio reports on standard error only and
does not check numbers. It is given a new text with nothing but the checked links, joints, origins, axes and limits,
and the inertias that can be [`kinematics`].
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree  # noqa: S405  only files without entities are read

from kabo.language.formulas import Place
from kabo.language.robot_files.xml_files import Element, XmlFile, parsed, read_bytes, shortened
from kabo.scene.urdf_files.inertials import add_inertial

Urdf = XmlFile
XACRO_ENDING = ".xacro"


def read_elements(path: Path, packages: Mapping[str, Path], place: Place | None) -> tuple[Urdf, tuple[Path, ...]]:
    """The elements of a URDF file, not checked, and the files read: itself, and what a xacro file includes.

    Args:
        path: the URDF file, or a `.xacro` file.
        packages: the folders of ROS packages that the scene declares.
        place: the place where a scene names the file, for error messages.

    Raises:
        InputError: the file cannot be read, is not XML, or describes robots in another format.
    """
    if path.suffix.lower() == XACRO_ENDING:
        from kabo.scene.urdf_files.xacro_files import processed  # most files are none

        read_bytes(path, place)
        content, files = processed(path, packages, place)
    else:
        content, files = read_bytes(path, place), (path,)
    urdf = parsed(path, content)
    _require_robot(urdf)
    return urdf, files


def _require_robot(urdf: Urdf) -> None:
    """Raises InputError unless the file is a URDF: other formats are named, with the way out."""
    tag, name = urdf.root.tag, urdf.path.name
    if tag in OTHER_FORMATS:
        called, remedy = OTHER_FORMATS[tag]
        raise urdf.wrong(urdf.root, f'robot file "{name}" is {called}; kabo reads URDF', remedy)
    if tag != "robot":
        said = f'robot file "{name}" has <{shortened(tag)}> where <robot> is expected'
        raise urdf.wrong(urdf.root, said, "kabo reads URDF files")
    macros = next((each for each in urdf.root.iter() if each.tag.startswith("xacro:")), None)
    if macros is not None:
        said = f'robot file "{name}" has the macro <{shortened(macros.tag)}>, which is not URDF'
        raise urdf.wrong(macros, said, f"name it {name}.xacro, or process it: xacro {name} > robot.urdf")


_USE_URDF = "use the URDF that it was made from: nearly every model has one, with its maker or in a ROS package"
OTHER_FORMATS = {  # by their first element: what they are, and the way out
    "mujoco": ("a MuJoCo model (MJCF)", _USE_URDF),
    "mujocoinclude": ("a part of a MuJoCo model (MJCF)", _USE_URDF),
    "sdf": ("an SDF model (Gazebo)", _USE_URDF),
    "COLLADA": ("a COLLADA mesh", "name it in a URDF: <mesh filename=…>"),
    "html": ("a web page", "was the file downloaded as it is shown, in place of the raw text?"),
}


def origin_of(urdf: Urdf, element: Element) -> tuple[list[float], list[float]]:
    """The position [m] and roll, pitch, yaw [rad] of an element's origin; zeros if it has none."""
    origin = element.find("origin")
    if origin is None:
        return [0.0] * 3, [0.0] * 3
    return urdf.numbers(origin, "xyz", 3, "0 0 0"), urdf.numbers(origin, "rpy", 3, "0 0 0")


def mimic_of(urdf: Urdf, joint: Element) -> tuple[str, float, float] | None:
    """The joint that this one mimics, with multiplier and offset; None if it is no mimic joint."""
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    factors = (urdf.numbers(mimic, key, 1, default)[0] for key, default in (("multiplier", "1"), ("offset", "0")))
    multiplier, offset = factors
    return mimic.get("joint", ""), multiplier, offset


def named(urdf: Urdf, tag: str) -> Iterator[tuple[str, Element]]:
    """The links or joints of a checked robot by name, without those inside other elements (`transmission`)."""
    for element in urdf.root.findall(tag):
        yield element.get("name", ""), element


def kinematics(urdf: Urdf) -> str:
    """The text of a URDF that holds the checked links and joints, their origins, axes and limits, and usable inertias."""
    robot = ElementTree.Element("robot", {"name": urdf.root.get("name") or "robot"})
    for name, link in named(urdf, "link"):
        add_inertial(ElementTree.SubElement(robot, "link", {"name": name}), link)
    for name, joint in named(urdf, "joint"):
        made = ElementTree.SubElement(robot, "joint", {"name": name, "type": joint.get("type", "")})
        for tag, keys in _KEPT_ATTRIBUTES.items():
            element = joint.find(tag)
            if element is not None:
                given = {key: value for key, value in element.attrib.items() if key in keys}
                required = {"velocity": "0", "effort": "0"} if tag == "limit" else {}
                ElementTree.SubElement(made, tag, {**required, **given})
    return ElementTree.tostring(robot, encoding="unicode")


_KEPT_ATTRIBUTES = {
    "origin": ("xyz", "rpy"),
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort"),
}
