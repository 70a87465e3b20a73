"""Parses and checks URDF files: elements with their lines, valid numbers, links that form a tree.

Errors are found here, with their places, before pinocchio's parser sees the file: pinocchio reports on
standard error only and does not check numbers. It is given a new text with nothing but the checked links, joints,
origins, axes and limits [`kinematics`].
"""

import difflib
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree  # noqa: S405  only files without entities are read
from xml.parsers import expat

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.source import reason_of

Words = tuple[frozenset[str], frozenset[str], frozenset[str]]

# Words that are left out on purpose: they say nothing about where links are and what shape they have.
IGNORED_ELEMENTS = frozenset(
    ("inertial", "material", "contact", "dynamics", "safety_controller", "calibration", "transmission", "gazebo")
    + (
        "sensor",
        "texture",
        "color",
        "verbose",
        "self_collision_checking",
        "contact_coefficients",
        "disable_collisions",
    )
)
_ORIGIN: Words = (frozenset(), frozenset(("xyz", "rpy")), frozenset())
_SHAPE: Words = (
    frozenset(("origin", "geometry", "material")),
    frozenset(("name",)),
    frozenset(("origin", "geometry")),
)
_JOINT = ("origin", "parent", "child", "axis", "limit", "mimic")
_WORDS: dict[str, Words] = {  # for each element that counts: its elements, its attributes, and which stand once
    "robot": (frozenset(("link", "joint")), frozenset(("name",)), frozenset()),
    "link": (frozenset(("collision", "visual")), frozenset(("name",)), frozenset()),
    "joint": (frozenset(_JOINT), frozenset(("name", "type")), frozenset(_JOINT)),
    "collision": _SHAPE,
    "visual": _SHAPE,
    "origin": _ORIGIN,
    "axis": (frozenset(), frozenset(("xyz",)), frozenset()),
    "limit": (frozenset(), frozenset(("lower", "upper", "velocity", "effort")), frozenset()),
    "mimic": (frozenset(), frozenset(("joint", "multiplier", "offset")), frozenset()),
    "parent": (frozenset(), frozenset(("link",)), frozenset()),
    "child": (frozenset(), frozenset(("link",)), frozenset()),
    "geometry": (frozenset(("mesh", "box", "cylinder", "sphere")), frozenset(), frozenset()),
    "mesh": (frozenset(), frozenset(("filename", "scale")), frozenset()),
    "box": (frozenset(), frozenset(("size",)), frozenset()),
    "cylinder": (frozenset(), frozenset(("radius", "length")), frozenset()),
    "sphere": (frozenset(), frozenset(("radius",)), frozenset()),
}
MAX_LINKS = 500  # the work of pinocchio and of collision checks grows with the square of this
MISSPELLING_RATIO = 0.85  # similarity ratio of words above which an unknown word counts as misspelt
MAX_FILE_BYTES = 16_000_000  # bytes
MAX_DEPTH = 40  # levels of nested elements
MAX_LENGTH = 1000.0  # [m] of an origin or a size
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
UNPLANNED_JOINT_TYPES = ("floating", "planar")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MAX_SHOWN_CHARACTERS = 40  # of a value that a message repeats


@dataclass(frozen=True)
class Urdf:
    """A URDF file: its elements, and where each of them begins."""

    path: Path
    root: ElementTree.Element
    places: dict[ElementTree.Element, tuple[int, int]] = field(repr=False)
    lines: tuple[str, ...] = field(repr=False)

    def wrong(self, element: ElementTree.Element, message: str, hint: str | None = None) -> InputError:
        """The error about an element, at its place in the file."""
        line, column = self.places[element]
        source = self.lines[line - 1] if line <= len(self.lines) else None
        length = len(element.tag) + 1
        return InputError([Diagnostic(str(self.path), line, column, message, hint, length, "error", source)])

    def numbers(
        self,
        element: ElementTree.Element,
        key: str,
        count: int,
        default: str | None = None,
        largest: float = MAX_LENGTH,
    ) -> list[float]:
        """The numbers of an attribute; `default` where it is absent.

        Raises:
            InputError: the attribute is absent without a default, has more or fewer numbers, or a word that is no
            number.
        """
        text = element.get(key, default)
        named = f"`{key}` of <{element.tag}>"
        if text is None:
            raise self.wrong(
                element, f"<{element.tag}> has no `{key}`", f'write {key}="{" ".join(["0.1"] * count)}"'
            )
        words = text.split()
        if len(words) != count:
            wanted = "a number" if count == 1 else f"{count} numbers"
            raise self.wrong(element, f'{named} must be {wanted}, this is "{text[:_MAX_SHOWN_CHARACTERS]}"')
        for word in words:
            if not _NUMBER.fullmatch(word):
                raise self.wrong(
                    element, f'{named} must be {_wanted(count)}, "{word[:_MAX_SHOWN_CHARACTERS]}" is none'
                )
            if not abs(float(word)) <= largest:
                raise self.wrong(
                    element, f"{named} is too large: {word[:_MAX_SHOWN_CHARACTERS]}; {largest:g} is the most"
                )
        return [float(word) for word in words]

    def size(self, element: ElementTree.Element, key: str, count: int = 1) -> list[float]:
        """The numbers of an attribute that holds positive lengths."""
        values = self.numbers(element, key, count)
        if not min(values) >= 1e-6:
            said = f"`{key}` of <{element.tag}> must be above 0, at least a micrometre"
            raise self.wrong(element, said, "sizes are metres")
        return values


def _wanted(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"


def read_text(path: Path, place: Place | None, *, drives: bool = False) -> Urdf:
    """The checked tree of a URDF file.

    Args:
        path: the URDF file.
        place: the place where a scene names the file, for error messages.
        drives: whether the robot's base drives: a planar or floating joint of the root link then stands for that.

    Raises:
        InputError: the file cannot be read, is not XML, or has invalid links, joints or numbers.
    """
    at = place or Place(str(path), 1, 1)

    def unreadable(reason: str, hint: str | None = None) -> InputError:
        said = f'robot file "{path.name}" cannot be read: {reason}'
        return InputError([Diagnostic(at.file, at.line, at.column, said, hint, at.length)])

    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise unreadable(f"it is larger than {MAX_FILE_BYTES // 10**6} MB")
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        raise unreadable(reason_of(error)) from None
    urdf = _parsed(path, content)
    if urdf.root.tag != "robot":
        raise urdf.wrong(urdf.root, f'robot file "{path.name}" has <{urdf.root.tag}> where <robot> is expected')
    _check(urdf, drives)
    return urdf


def _parsed(path: Path, content: bytes) -> Urdf:
    lines = tuple(content.decode("utf-8", "replace").splitlines())
    places: dict[ElementTree.Element, tuple[int, int]] = {}
    builder, depth = ElementTree.TreeBuilder(), 0
    parser = expat.ParserCreate()

    def refused(message: str, line: int, column: int) -> InputError:
        source = lines[line - 1] if 0 < line <= len(lines) else None
        said = f'robot file "{path.name}" {message}'
        return InputError([Diagnostic(str(path), max(line, 1), column, said, None, 1, "error", source)])

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        place = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1
        if depth > MAX_DEPTH:
            raise refused(f"nests elements deeper than {MAX_DEPTH}", *place)
        places[builder.start(tag, attributes)] = place

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def entity(*_: object) -> None:
        raise refused("defines XML entities, which kabo does not read", parser.CurrentLineNumber, 1)

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages.get(error.code, "broken")
        raise refused(f"is no XML: {reason}", error.lineno, error.offset + 1) from None
    except (ValueError, LookupError) as error:  # an encoding that nobody knows
        raise refused(f"is no XML: {error}", parser.CurrentLineNumber, 1) from None
    return Urdf(path, builder.close(), places, lines)


# ------------------------------------------------------------------------------------------------ links and joints
def _check(urdf: Urdf, drives: bool) -> None:
    _check_words(urdf)
    links = _named(urdf, "link")
    joints = _named(urdf, "joint")
    if not links:
        raise urdf.wrong(urdf.root, f'robot file "{urdf.path.name}" has no <link>')
    if len(links) > MAX_LINKS:
        element = list(links.values())[MAX_LINKS]
        raise urdf.wrong(element, f"{len(links)} links are too many: kabo plans for robots of up to {MAX_LINKS}")
    parents: dict[str, str] = {}
    for name, joint in joints.items():
        if not (drives and joint.get("type") in UNPLANNED_JOINT_TYPES):
            _check_joint(urdf, name, joint, joints)
        origin_of(urdf, joint)
        parent, child = (_end_of(urdf, name, joint, tag, links) for tag in ("parent", "child"))
        if child in parents:
            raise urdf.wrong(joint, f'link "{child}" is the child of two joints; the second is "{name}"')
        parents[child] = parent
    _check_tree(urdf, links, parents)
    _check_base(urdf, joints, parents)


def _check_base(urdf: Urdf, joints: dict[str, ElementTree.Element], parents: dict[str, str]) -> None:
    """Raises InputError for a planar or floating joint that is not on the root link, or not the first one there."""
    loose = [(name, joint) for name, joint in joints.items() if joint.get("type") in UNPLANNED_JOINT_TYPES]
    for number, (name, joint) in enumerate(loose):
        if number > 0 or any(end.get("link") in parents for end in joint.findall("parent")):
            said = f'joint "{name}" is {joint.get("type")}, and not the one that moves the base'
            raise urdf.wrong(joint, said, "only one joint of the first link may be planar or floating")


def _check_words(urdf: Urdf) -> None:
    """Raises InputError for misspelt and for repeated elements, which a parser would skip without a word."""
    waiting = [urdf.root]
    while waiting:
        element = waiting.pop()
        words, keys, single = _WORDS[element.tag]
        for key in element.attrib:
            if key not in keys and (hint := _slipped(key, keys)) is not None:
                raise urdf.wrong(element, f"<{element.tag}> has no `{key[:_MAX_SHOWN_CHARACTERS]}`", hint)
        seen: set[str] = set()
        for child in element:
            if child.tag in seen and child.tag in single:
                raise urdf.wrong(child, f"<{element.tag}> has two of <{child.tag}>")
            seen.add(child.tag)
            if child.tag in words:
                if child.tag in _WORDS:
                    waiting.append(child)
            elif child.tag not in IGNORED_ELEMENTS and (hint := _slipped(child.tag, words)) is not None:
                raise urdf.wrong(
                    child, f"unknown element <{child.tag[:_MAX_SHOWN_CHARACTERS]}> in <{element.tag}>", hint
                )
        if element.tag == "geometry" and len(element) > 1:
            raise urdf.wrong(element[1], "a <geometry> has one shape", "write another <collision> for it")


def _slipped(word: str, known: frozenset[str]) -> str | None:
    """The remedy for a misspelt word; None for words that are like no known one: extensions of other tools."""
    for meant in sorted(known):
        if (
            sorted(word) == sorted(meant)
            or difflib.SequenceMatcher(None, word, meant).ratio() >= MISSPELLING_RATIO
        ):
            return f'did you mean "{meant}"?'
    return None


def _named(urdf: Urdf, tag: str) -> dict[str, ElementTree.Element]:
    found: dict[str, ElementTree.Element] = {}
    for element in urdf.root.findall(tag):
        name = element.get("name", "")
        if not name.strip():
            raise urdf.wrong(element, f"a <{tag}> has no name")
        if name in found:
            raise urdf.wrong(element, f'there are two of <{tag} name="{name[:_MAX_SHOWN_CHARACTERS]}">')
        found[name] = element
    return found


def _end_of(
    urdf: Urdf, name: str, joint: ElementTree.Element, tag: str, links: dict[str, ElementTree.Element]
) -> str:
    element = joint.find(tag)
    link = None if element is None else element.get("link")
    if element is None or link is None:
        raise urdf.wrong(joint, f'joint "{name}" has no {tag} link', f'write <{tag} link="…"/> inside of it')
    if link not in links:
        raise urdf.wrong(element, f'joint "{name}" names the unknown link "{link}"', did_you_mean(link, links))
    return link


def _check_tree(urdf: Urdf, links: dict[str, ElementTree.Element], parents: dict[str, str]) -> None:
    roots = [name for name in links if name not in parents]
    if len(roots) > 1:
        said = f'links "{roots[0]}" and "{roots[1]}" hang on no joint: a robot is one tree of links'
        raise urdf.wrong(links[roots[1]], said, "name one of them as the child of a joint")
    for name, link in links.items():
        above, seen = name, {name}
        while above in parents:
            above = parents[above]
            if above in seen:
                raise urdf.wrong(link, f'link "{name}" hangs on itself, over its joints')
            seen.add(above)


def _check_joint(
    urdf: Urdf, name: str, joint: ElementTree.Element, joints: dict[str, ElementTree.Element]
) -> None:
    kind = joint.get("type", "")
    if kind in UNPLANNED_JOINT_TYPES:
        raise urdf.wrong(
            joint,
            f'joint "{name}" is {kind}, neither revolute nor prismatic: kabo plans for no such one',
            "if it moves the base, write in the scene base: {moves: {within: REGION}}",
        )
    if kind not in JOINT_TYPES:
        hint = did_you_mean(kind, JOINT_TYPES) or f"there are {', '.join(JOINT_TYPES)}"
        raise urdf.wrong(joint, f'joint "{name}" has the unknown type "{kind[:_MAX_SHOWN_CHARACTERS]}"', hint)
    origin_of(urdf, joint)
    axis = joint.find("axis")
    if axis is not None and kind != "fixed":
        direction = urdf.numbers(axis, "xyz", 3, "1 0 0")
        if not math.hypot(*direction) > 1e-6:
            raise urdf.wrong(axis, f'the axis of joint "{name}" has no direction', 'write e.g. xyz="0 0 1"')
    _check_limit(urdf, name, kind, joint)
    mimic = joint.find("mimic")
    if mimic is not None:
        if mimic.get("joint", "") not in joints:
            said = f'joint "{name}" mimics the unknown joint "{mimic.get("joint", "")}"'
            raise urdf.wrong(mimic, said, did_you_mean(mimic.get("joint", ""), joints))
        mimic_of(urdf, joint)


def _check_limit(urdf: Urdf, name: str, kind: str, joint: ElementTree.Element) -> None:
    limit = joint.find("limit")
    if limit is None:
        if kind in {"revolute", "prismatic"}:
            hint = 'write <limit lower="…" upper="…" velocity="…" effort="…"/> inside of it'
            hint += ', or type="continuous"' if kind == "revolute" else ""
            raise urdf.wrong(joint, f'joint "{name}" is {kind} and has no <limit>', hint)
        return
    for key in ("velocity", "effort"):
        urdf.numbers(limit, key, 1, "0", largest=math.inf if key == "effort" else 1e300)
    lower, upper = (urdf.numbers(limit, key, 1, "0", largest=1e300)[0] for key in ("lower", "upper"))
    if kind == "prismatic" and max(abs(lower), abs(upper)) > MAX_LENGTH:
        raise urdf.wrong(limit, f'joint "{name}" slides farther than {MAX_LENGTH:g} m')
    if lower > upper and kind in {"revolute", "prismatic"}:
        raise urdf.wrong(limit, f'joint "{name}" has its lower limit {lower:g} above its upper one {upper:g}')


def origin_of(urdf: Urdf, element: ElementTree.Element) -> tuple[list[float], list[float]]:
    """The position [m] and roll, pitch, yaw [rad] of an element's origin; zeros if it has none."""
    origin = element.find("origin")
    if origin is None:
        return [0.0] * 3, [0.0] * 3
    return urdf.numbers(origin, "xyz", 3, "0 0 0"), urdf.numbers(origin, "rpy", 3, "0 0 0")


def mimic_of(urdf: Urdf, joint: ElementTree.Element) -> tuple[str, float, float] | None:
    """The joint that this one mimics, with multiplier and offset; None if it is no mimic joint."""
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    factors = (urdf.numbers(mimic, key, 1, default)[0] for key, default in (("multiplier", "1"), ("offset", "0")))
    multiplier, offset = factors
    return mimic.get("joint", ""), multiplier, offset


def named(urdf: Urdf, tag: str) -> Iterator[tuple[str, ElementTree.Element]]:
    """The links or joints of a checked robot by name, without those inside other elements (`transmission`)."""
    for element in urdf.root.findall(tag):
        yield element.get("name", ""), element


def kinematics(urdf: Urdf) -> str:
    """The text of a URDF that holds the checked links and joints, their origins, axes and limits, and nothing else."""
    robot = ElementTree.Element("robot", {"name": urdf.root.get("name") or "robot"})
    for name, _ in named(urdf, "link"):
        ElementTree.SubElement(robot, "link", {"name": name})
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
