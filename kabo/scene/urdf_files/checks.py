"""Checks of a URDF file's elements: known words, valid numbers, links that form one tree. All findings at once."""

import difflib
import math

from kabo.errors import Diagnostic, did_you_mean
from kabo.language.robot_files.xml_files import MAX_LENGTH, Collected, Element, shortened
from kabo.scene.urdf_files.elements import Urdf, mimic_of, origin_of

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
    "geometry": (frozenset(("mesh", "box", "cylinder", "sphere", "capsule")), frozenset(), frozenset()),
    "mesh": (frozenset(), frozenset(("filename", "scale")), frozenset()),
    "box": (frozenset(), frozenset(("size",)), frozenset()),
    "cylinder": (frozenset(), frozenset(("radius", "length")), frozenset()),
    "sphere": (frozenset(), frozenset(("radius",)), frozenset()),
    "capsule": (frozenset(), frozenset(("radius", "length")), frozenset()),
}
MAX_LINKS = 500  # the work of pinocchio and of collision checks grows with the square of this
MISSPELLING_RATIO = 0.85  # similarity ratio of words above which an unknown word counts as misspelt
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")
UNPLANNED_JOINT_TYPES = ("floating", "planar")


def check(urdf: Urdf, *, drives: bool = False) -> list[Diagnostic]:
    """All findings in the links, joints and numbers of a URDF file; none if it is sound.

    If the robot's base `drives`, a planar or floating joint of the root link may stand for that.
    """
    collected = Collected()
    _check_words(urdf, collected)
    links, joints = (_named(urdf, tag, collected) for tag in ("link", "joint"))
    if not links:
        hint = "each rigid part is one: <link name=…>"
        collected.found.append(urdf.finding(urdf.root, f'robot file "{urdf.path.name}" has no <link>', hint))
    if len(links) > MAX_LINKS:
        said = f"{len(links)} links are too many: kabo plans for robots of up to {MAX_LINKS}"
        hint = "join links that no joint moves, or leave out what is far from the arm"
        collected.found.append(urdf.finding(list(links.values())[MAX_LINKS], said, hint))
        return collected.diagnostics
    before = len(collected.found)
    parents = _parents(urdf, joints, links, collected)
    if links and len(collected.found) == before:
        _check_tree(urdf, links, parents, collected)
    for name, joint in joints.items():
        _check_joint(urdf, name, joint, collected, drives=drives)
    if drives:
        _check_base(urdf, joints, parents, collected)
    _check_mimics(urdf, joints, collected)
    return collected.diagnostics


def _check_words(urdf: Urdf, collected: Collected) -> None:
    """Collects misspelt and repeated elements, which a parser would skip without a word."""
    waiting = [urdf.root]
    while waiting:
        element = waiting.pop()
        words, keys, single = _WORDS[element.tag]
        for key in element.attrib:
            if key not in keys and (hint := _slipped(key, keys)) is not None:
                collected.found.append(urdf.finding(element, f"<{element.tag}> has no `{shortened(key)}`", hint))
        seen: set[str] = set()
        for child in element:
            if child.tag in seen and child.tag in single:
                said = f"<{element.tag}> has two of <{child.tag}>"
                collected.found.append(urdf.finding(child, said, "leave one of them out"))
            seen.add(child.tag)
            if child.tag in words:
                if child.tag in _WORDS:
                    waiting.append(child)
            elif child.tag not in IGNORED_ELEMENTS and (hint := _slipped(child.tag, words)) is not None:
                said = f"unknown element <{shortened(child.tag)}> in <{element.tag}>"
                collected.found.append(urdf.finding(child, said, hint))
        if element.tag == "geometry" and len(element) > 1:
            said = "a <geometry> has one shape"
            collected.found.append(urdf.finding(element[1], said, "write another <collision> for it"))


def _slipped(word: str, known: frozenset[str]) -> str | None:
    """The remedy for a misspelt word; None for words that are like no known one: extensions of other tools."""
    for meant in sorted(known):
        if (
            sorted(word) == sorted(meant)
            or difflib.SequenceMatcher(None, word, meant).ratio() >= MISSPELLING_RATIO
        ):
            return f'did you mean "{meant}"?'
    return None


def _named(urdf: Urdf, tag: str, collected: Collected) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for element in urdf.root.findall(tag):
        name = element.get("name", "")
        if not name.strip():
            collected.found.append(urdf.finding(element, f"a <{tag}> has no name", 'write name="…"'))
        elif name in found:
            said = f'there are two of <{tag} name="{shortened(name)}">'
            first = urdf.places[found[name]][0]
            collected.found.append(urdf.finding(element, said, f"rename one; the first is in line {first}"))
        else:
            found[name] = element
    return found


def _parents(
    urdf: Urdf, joints: dict[str, Element], links: dict[str, Element], collected: Collected
) -> dict[str, str]:
    """The parent link of each link that is the child of a joint."""
    parents: dict[str, str] = {}
    for name, joint in joints.items():
        ends = [_end_of(urdf, name, joint, tag, links, collected) for tag in ("parent", "child")]
        parent, child = ends
        if parent is None or child is None:
            continue
        if child in parents:
            said = f'link "{shortened(child)}" is the child of two joints; the second is "{shortened(name)}"'
            collected.found.append(urdf.finding(joint, said, "each link hangs on one joint"))
        parents[child] = parent
    return parents


def _end_of(
    urdf: Urdf, name: str, joint: Element, tag: str, links: dict[str, Element], collected: Collected
) -> str | None:
    element = joint.find(tag)
    link = None if element is None else element.get("link")
    if element is None or link is None:
        said, hint = f'joint "{shortened(name)}" has no {tag} link', f'write <{tag} link="…"/> inside of it'
        collected.found.append(urdf.finding(joint, said, hint))
        return None
    if link not in links:
        said = f'joint "{shortened(name)}" names the unknown link "{shortened(link)}"'
        hint = did_you_mean(link, links) or f"add <link name={link!r}/>, or name another {tag}"
        collected.found.append(urdf.finding(element, said, hint))
        return None
    return link


def _check_tree(urdf: Urdf, links: dict[str, Element], parents: dict[str, str], collected: Collected) -> None:
    roots = [name for name in links if name not in parents]
    for name in roots[1:]:
        said = f'links "{roots[0]}" and "{name}" hang on no joint: a robot is one tree of links'
        hint = f'name one of them as the child of a joint, e.g. of a fixed one with the parent "{roots[0]}"'
        collected.found.append(urdf.finding(links[name], said, hint))
    settled: set[str] = set(roots)
    for name, link in links.items():
        way = [name]
        while way[-1] not in settled and way[-1] in parents and parents[way[-1]] not in way:
            way.append(parents[way[-1]])
        if way[-1] not in settled:
            said = f'link "{name}" hangs on itself, over its joints: {" < ".join([*way[:4], "…"])}'
            collected.found.append(urdf.finding(link, said, "a robot is a tree: cut the loop at one joint"))
        settled.update(way)


def _check_base(urdf: Urdf, joints: dict[str, Element], parents: dict[str, str], collected: Collected) -> None:
    """Collects planar and floating joints, but for one of the root link, which may move the base."""
    loose = [(name, joint) for name, joint in joints.items() if joint.get("type") in UNPLANNED_JOINT_TYPES]
    for number, (name, joint) in enumerate(loose):
        if number > 0 or any(end.get("link") in parents for end in joint.findall("parent")):
            said = f'joint "{shortened(name)}" is {joint.get("type")}, and not the one that moves the base'
            hint = "only one joint of the first link may be planar or floating"
            collected.found.append(urdf.finding(joint, said, hint))


def _check_joint(urdf: Urdf, name: str, joint: Element, collected: Collected, *, drives: bool) -> None:
    kind = joint.get("type", "")
    if kind in UNPLANNED_JOINT_TYPES:
        if not drives:
            said = f'joint "{name}" is {kind}, neither revolute nor prismatic: kabo plans for no such one'
            hint = 'write type="fixed", or for a base that drives, in the scene, base: {moves: {within: REGION}}'
            collected.found.append(urdf.finding(joint, said, hint))
    elif kind not in JOINT_TYPES:
        hint = did_you_mean(kind, JOINT_TYPES) or f"there are {', '.join(JOINT_TYPES)}"
        said = f'joint "{shortened(name)}" has the unknown type "{shortened(kind)}"'
        collected.found.append(urdf.finding(joint, said, hint))
    with collected.kept():
        origin_of(urdf, joint)
    axis = joint.find("axis")
    if axis is not None and kind != "fixed":
        with collected.kept():
            direction = urdf.numbers(axis, "xyz", 3, "1 0 0")
            if not math.hypot(*direction) > 1e-6:
                raise urdf.wrong(axis, f'the axis of joint "{name}" has no direction', 'write e.g. xyz="0 0 1"')
    _check_limit(urdf, name, kind, joint, collected)


def _check_mimics(urdf: Urdf, joints: dict[str, Element], collected: Collected) -> None:
    """Collects mimic joints with wrong numbers, and those that follow no joint, or each other in a circle."""
    sources: dict[str, str] = {}
    for name, joint in joints.items():
        mimic = joint.find("mimic")
        if mimic is None:
            continue
        with collected.kept():
            mimic_of(urdf, joint)
        source = sources[name] = mimic.get("joint", "")
        if source not in joints:
            said = f'joint "{shortened(name)}" mimics the unknown joint "{shortened(source)}"'
            hint = did_you_mean(source, joints) or "name a joint of this file, or leave <mimic> out"
            collected.found.append(urdf.finding(mimic, said, hint))
        elif joints[source].get("type") == "fixed":
            said = f'joint "{shortened(name)}" mimics "{shortened(source)}", which is fixed and never moves'
            collected.found.append(urdf.finding(mimic, said, "name a joint that moves, or leave <mimic> out"))
    for name in sources:
        way = [name]
        while way[-1] in sources and sources[way[-1]] not in way:
            way.append(sources[way[-1]])
        if sources.get(way[-1]) == name:
            said = f'joint "{shortened(name)}" mimics itself'
            hint = "one joint of the circle must move on its own"
            mimic = joints[name].find("mimic")
            collected.found.append(urdf.finding(joints[name] if mimic is None else mimic, said, hint))


def _check_limit(urdf: Urdf, name: str, kind: str, joint: Element, collected: Collected) -> None:
    limit = joint.find("limit")
    if limit is None:
        if kind in {"revolute", "prismatic"}:
            hint = 'write <limit lower="…" upper="…" velocity="…" effort="…"/> inside of it'
            hint += ', or type="continuous"' if kind == "revolute" else ""
            said = f'joint "{shortened(name)}" is {kind} and has no <limit>'
            collected.found.append(urdf.finding(joint, said, hint))
        return
    for key in ("velocity", "effort"):
        with collected.kept():
            (most,) = urdf.numbers(limit, key, 1, "0", largest=math.inf if key == "effort" else 1e300)
            if most < 0.0 and kind != "fixed":
                said = f'the {key} of joint "{shortened(name)}" is limited to {most:g}, below 0'
                raise urdf.wrong(limit, said, "leave the sign out: it is a limit of the size")
    bounds = [
        collected.tried(lambda key=key: urdf.numbers(limit, key, 1, "0", largest=1e300)[0])  # type: ignore[misc]
        for key in ("lower", "upper")
    ]
    lower, upper = bounds
    if lower is None or upper is None:
        return
    if kind == "prismatic" and max(abs(lower), abs(upper)) > MAX_LENGTH:
        said = f'joint "{name}" slides farther than {MAX_LENGTH:g} m'
        collected.found.append(urdf.finding(limit, said, "limits of sliding joints are metres"))
    if lower > upper and kind in {"revolute", "prismatic"}:
        said = f'joint "{name}" has its lower limit {lower:g} above its upper one {upper:g}'
        collected.found.append(urdf.finding(limit, said, "swap them"))
