"""Reads SRDF files: disabled collisions, groups, group states, end effectors, and HPP's grippers and handles."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from kabo.errors import Diagnostic, did_you_mean
from kabo.language.formulas import Place
from kabo.language.robot_files.xml_files import Collected, Element, XmlFile, parsed, read_bytes, shortened
from kabo.language.semantic_description import (
    DisabledPair,
    EndEffector,
    GroupState,
    HandlingFrame,
    JointGroup,
    SemanticDescription,
)

T = TypeVar("T")

WHAT = "SRDF file"
READ = ("disable_collisions", "group", "group_state", "end_effector", "passive_joint", "gripper", "handle")
# Elements of MoveIt, HPP and pinocchio that say nothing which kabo needs.
IGNORED = frozenset(
    ("virtual_joint", "link_sphere_approximation", "rotor_params", "specificities", "contact", "enable_collisions")
    + (
        "disable_default_collisions",
        "joint_property",
        "surface",
        "gazebo",
        "mass",
        "link_properties",
        "joint",
        "link",
    )
)
_UNIT_TOLERANCE = 1e-3  # of the length of a quaternion, which is then normalized: files write few digits


def read_srdf(path: Path, place: Place | None) -> tuple[SemanticDescription, list[Diagnostic]]:
    """The content of an SRDF file, and what is wrong in it; what is wrong is left out.

    Args:
        path: the file.
        place: the place where a scene names it, for error messages.
    """
    collected = Collected()
    made = collected.tried(lambda: _Reading(parsed(path, read_bytes(path, place, WHAT), WHAT), collected).read())
    return made or SemanticDescription(path), collected.diagnostics


class _Reading:
    """One SRDF file that is being read."""

    def __init__(self, file: XmlFile, collected: Collected) -> None:
        self.file, self.collected = file, collected

    def read(self) -> SemanticDescription:
        root = self.file.root
        if root.tag != "robot":
            hint = "an SRDF file begins with <robot name=…>"
            raise self.file.wrong(root, f"<{shortened(root.tag)}> stands where <robot> is expected", hint)
        if root.find("joint/parent") is not None:
            hint = "name the SRDF here, and this file as `urdf`"
            raise self.file.wrong(root, f'"{self.file.path.name}" is a URDF, not an SRDF', hint)
        self._unknown_elements(root)
        groups = self._groups()
        return SemanticDescription(
            self.file.path,
            self._each("disable_collisions", self._pair),
            groups,
            self._each("group_state", lambda each: self._state(each, groups)),
            self._each("end_effector", self._end_effector),
            {name: self.file.place(each) for name, each in self._passive()},
            frozenset(each.get("name", "") for each in root.findall("virtual_joint")),
            self._each("gripper", self._frame),
            self._each("handle", self._frame),
        )

    def _unknown_elements(self, root: Element) -> None:
        for element in root:
            if element.tag not in READ and element.tag not in IGNORED:
                hint = did_you_mean(element.tag, READ) or f"kabo reads {', '.join(READ)}"
                said = f"unknown element <{shortened(element.tag)}>, which says nothing to kabo"
                self.collected.found.append(self.file.finding(element, said, hint, warning=True))

    def _each(self, tag: str, read: Callable[[Element], T]) -> tuple[T, ...]:
        found = []
        for element in self.file.root.findall(tag):
            made = self.collected.tried(lambda element=element: read(element))  # type: ignore[misc]
            if made is not None:
                found.append(made)
        return tuple(found)

    def _attribute(self, element: Element, key: str) -> str:
        value = element.get(key, "").strip()
        if not value:
            hint = f'write {key}="…"'
            near = did_you_mean(key, element.attrib)
            if near is not None:
                hint = f"{near.replace('did you mean', 'was it meant by')} {hint}"
            raise self.file.wrong(element, f"<{element.tag}> has no `{key}`", hint)
        return value

    def _pair(self, element: Element) -> DisabledPair:
        first, second = self._attribute(element, "link1"), self._attribute(element, "link2")
        return DisabledPair(first, second, element.get("reason", ""), self.file.place(element))

    def _groups(self) -> dict[str, JointGroup]:
        groups: dict[str, JointGroup] = {}
        for group in self._each("group", self._group):
            if group.name in groups:  # MoveIt takes both together
                other = groups[group.name]
                group = JointGroup(
                    group.name, (*other.links, *group.links), (*other.joints, *group.joints),
                    (*other.chains, *group.chains), (*other.groups, *group.groups),
                    {**other.places, **group.places}, other.place,
                )  # fmt: skip
            groups[group.name] = group
        for group in groups.values():
            self._check_subgroups(group, groups)
        return groups

    def _check_subgroups(self, group: JointGroup, groups: dict[str, JointGroup]) -> None:
        for name in group.groups:
            if name not in groups:
                said = f'group "{shortened(group.name)}" includes the unknown group "{shortened(name)}"'
                self._add(group.places[name], said, did_you_mean(name, groups) or "leave it out")
            elif name == group.name:
                self._add(group.places[name], f'group "{shortened(name)}" includes itself', "leave it out")
            elif group.name in _below(name, groups):
                said = f'group "{shortened(group.name)}" includes itself by way of group "{shortened(name)}"'
                self._add(group.places[name], said, "leave one of the circle out")

    def _add(self, place: Place, said: str, hint: str | None) -> None:
        at = place.line, place.column
        element = next(each for each, where in self.file.places.items() if where == at)
        self.collected.found.append(self.file.finding(element, said, hint, warning=True))

    def _group(self, element: Element) -> JointGroup:
        name = self._attribute(element, "name")
        found: dict[str, list[str]] = {"link": [], "joint": [], "group": []}
        chains, places = [], {}
        for child in element:
            with self.collected.kept():
                if child.tag == "chain":
                    ends = self._attribute(child, "base_link"), self._attribute(child, "tip_link")
                    chains.append(ends)
                    places.update(dict.fromkeys(ends, self.file.place(child)))
                elif child.tag in found:
                    each = self._attribute(child, "name")
                    found[child.tag].append(each)
                    places[each] = self.file.place(child)
                elif (near := did_you_mean(child.tag, [*found, "chain"])) is not None:
                    raise self.file.wrong(child, f"unknown element <{shortened(child.tag)}> in a <group>", near)
        return JointGroup(
            name, tuple(found["link"]), tuple(found["joint"]), tuple(chains), tuple(found["group"]), places,
            self.file.place(element),
        )  # fmt: skip

    def _state(self, element: Element, groups: dict[str, JointGroup]) -> GroupState:
        name, group = self._attribute(element, "name"), element.get("group", "")  # other tools write none
        if group and group not in groups:
            said = f'<group_state name="{shortened(name)}"> names the unknown group "{shortened(group)}"'
            hint = did_you_mean(group, groups) or "declare it: <group name=…>"
            self.collected.found.append(self.file.finding(element, said, hint, warning=True))
        values, places = {}, {}
        for child in element.findall("joint"):
            with self.collected.kept():
                joint, text = self._attribute(child, "name"), self._attribute(child, "value")
                if len(text.split()) == 1:  # floating and continuous joints have several: kabo plans for none
                    values[joint] = self.file.numbers_in(child, "`value` of <joint>", text, 1)[0]
                    places[joint] = self.file.place(child)
        return GroupState(name, group, values, places, self.file.place(element))

    def _end_effector(self, element: Element) -> EndEffector:
        name, parent = self._attribute(element, "name"), self._attribute(element, "parent_link")
        return EndEffector(name, self._attribute(element, "group"), parent, self.file.place(element))

    def _passive(self) -> list[tuple[str, Element]]:
        found = []
        for element in self.file.root.findall("passive_joint"):
            name = self.collected.tried(lambda element=element: self._attribute(element, "name"))  # type: ignore[misc]
            if name is not None:
                found.append((name, element))
        return found

    def _frame(self, element: Element) -> HandlingFrame:
        """A gripper or a handle of HPP: `<position>` is x y z and a quaternion, `<link name=…/>` its link."""
        name = self._attribute(element, "name")
        link, position = element.find("link"), element.find("position")
        if link is None:
            raise self.file.wrong(
                element, f'<{element.tag} name="{name}"> has no <link>', 'write <link name="…"/>'
            )
        words = "0 0 0 0 0 0 1" if position is None else position.text or ""
        at = element if position is None else position
        x, y, z, *rest = self._pose(at, words)
        length = math.hypot(*rest)
        if not abs(length - 1.0) <= _UNIT_TOLERANCE:
            said = f"the quaternion of <position> has the length {length:.4g}, not 1"
            raise self.file.wrong(at, said, "seven numbers: x y z, then the quaternion qx qy qz qw")
        clearance = self.file.numbers(element, "clearance", 1, "0")[0]
        qx, qy, qz, qw = (value / length for value in rest)
        place = self.file.place(element)
        on, mask = self._attribute(link, "name"), self._mask(element)
        return HandlingFrame(name, on, (x, y, z), (qx, qy, qz, qw), clearance, mask, place)

    def _mask(self, element: Element) -> tuple[bool, bool, bool, bool, bool, bool]:
        """Which of x, y, z and the turns about them a `<mask>` fixes; all without one."""
        mask = element.find("mask")
        if mask is None:
            return (True,) * 6
        words = [word.lower() for word in (mask.text or "").split()]
        if len(words) != 6 or not set(words) <= {"true", "false", "1", "0"}:
            said = f'<mask> must be six of true and false, this is "{shortened(" ".join(words))}"'
            raise self.file.wrong(mask, said, "x y z, then the turns about x, y and z")
        x, y, z, rx, ry, rz = (word in {"true", "1"} for word in words)
        return x, y, z, rx, ry, rz

    def _pose(self, element: Element, words: str) -> list[float]:
        if len(words.split()) == 3:
            words = f"{words} 0 0 0 1"
        return self.file.numbers_in(element, "<position>", words, 7)


def _below(name: str, groups: dict[str, JointGroup]) -> set[str]:
    """The names of all groups that a group includes, and those that these include."""
    found: set[str] = set()
    ahead = [name]
    while ahead:
        for each in groups[ahead.pop()].groups:
            if each in groups and each not in found:
                found.add(each)
                ahead.append(each)
    return found
