"""What an SRDF file says about a robot whose URDF is known: its groups, configurations, pairs that may touch.

Names that the URDF does not have are warnings: one SRDF often serves several variants of a robot.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.names import NAME, proper_name
from kabo.language.scene_description import ContactPattern
from kabo.language.semantic_description import GroupState, JointGroup, SemanticDescription

LIMIT_SLACK = 1e-3  # [rad or m] by which a state may exceed a limit: files round; it is then moved to the limit


@dataclass(frozen=True)
class JointEnds:
    """A joint of a URDF: its links and its type."""

    parent: str
    child: str
    kind: str = "fixed"


@dataclass(frozen=True)
class Groups:
    """The groups of an SRDF file over the joints of a URDF."""

    groups: Mapping[str, JointGroup]
    joints: Mapping[str, JointEnds]
    above: Mapping[str, str] = field(default_factory=dict)  # link -> the joint whose child it is

    @classmethod
    def of(cls, semantics: SemanticDescription | None, joints: Mapping[str, JointEnds]) -> "Groups":
        """The groups of an SRDF file; none without one."""
        groups = {} if semantics is None else semantics.groups
        return cls(groups, joints, {ends.child: name for name, ends in joints.items()})

    def joints_of(self, name: str) -> tuple[str, ...]:
        """The joints of a group, fixed ones as well, in the order of the URDF."""
        wanted = set(self._joints(name, ()))
        return tuple(joint for joint in self.joints if joint in wanted)

    def links_of(self, name: str) -> tuple[str, ...]:
        """The links of a group: those that it names, and the child links of its joints."""
        named = [link for group in self._with_subgroups(name, ()) for link in self.groups[group].links]
        return tuple(dict.fromkeys([*named, *(self.joints[joint].child for joint in self.joints_of(name))]))

    def _with_subgroups(self, name: str, seen: tuple[str, ...]) -> Iterator[str]:
        if name in self.groups and name not in seen:
            yield name
            for below in self.groups[name].groups:
                yield from self._with_subgroups(below, (*seen, name))

    def _joints(self, name: str, seen: tuple[str, ...]) -> Iterator[str]:
        for each in self._with_subgroups(name, seen):
            group = self.groups[each]
            yield from (joint for joint in group.joints if joint in self.joints)
            yield from (self.above[link] for link in group.links if link in self.above)
            for base, tip in group.chains:
                yield from self._chain(base, tip)

    def _chain(self, base: str, tip: str) -> Iterator[str]:
        link = tip
        while link != base and link in self.above:
            joint = self.above[link]
            yield joint
            link = self.joints[joint].parent


def spelled(name: str) -> str:
    """A name of an SRDF file as kabo spells names."""
    return name if NAME.fullmatch(name) else proper_name(name)


def links_named(pattern: str, links: Iterable[str], groups: Groups) -> tuple[str, ...]:
    """The links that a word means: the link of this name, else the links of this group, else those that fit the pattern."""
    known = tuple(links)
    if pattern in known:
        return (pattern,)
    if pattern in groups.groups:
        return tuple(link for link in groups.links_of(pattern) if link in known)
    if "*" in pattern or "?" in pattern:
        literal = pattern.replace("[", "[[]")
        return tuple(link for link in known if fnmatchcase(link, literal))
    return ()


def unknown_links(
    pattern: str, links: Sequence[str], groups: Groups, robot: str, place: Place | None
) -> Diagnostic:
    """The error about a word that means no link."""
    at = place or Place("scene", 1, 1)
    said = f'"{pattern}" is no link of robot "{robot}"'
    said += ", and fits none" if "*" in pattern or "?" in pattern else ", and no group of its SRDF"
    hint = (
        did_you_mean(pattern, [*links, *groups.groups])
        or "kabo check tells the links; `*` stands for any characters"
    )
    return Diagnostic(at.file, at.line, at.column, said, hint, at.length)


def own_contacts(
    contacts: Sequence[ContactPattern],
    semantics: SemanticDescription | None,
    links: Sequence[str],
    groups: Groups,
    robot: str,
) -> frozenset[frozenset[str]]:
    """The pairs of a robot's links that may touch, as its scene entry and its SRDF say.

    Raises:
        InputError: words of the scene entry that mean no link.
    """
    disabled = () if semantics is None else semantics.disabled
    pairs = {frozenset((each.first, each.second)) for each in disabled if {each.first, each.second} <= set(links)}
    wrong = []
    for contact in contacts:
        sides = [links_named(word, links, groups) for word in (contact.first, contact.second)]
        for word, side in zip((contact.first, contact.second), sides, strict=True):
            if not side:
                wrong.append(unknown_links(word, links, groups, robot, contact.place))
        pairs.update(frozenset((a, b)) for a in sides[0] for b in sides[1] if a != b)
    if wrong:
        raise InputError(wrong)
    return frozenset(pairs)


def configurations(
    semantics: SemanticDescription | None,
    planned: Sequence[str],
    limits: Mapping[str, tuple[float, float]],
    given: Mapping[str, tuple[float, ...]],
) -> dict[str, tuple[float, ...]]:
    """The named configurations of the planned joints: those given, and the group states of the SRDF.

    A joint that a state does not name is where it is in `home`, else at zero within its limits. States that name none of
    the planned joints, such as those of a gripper, and states beyond the limits are left out.
    """
    found = dict(given)
    if semantics is None:
        return found
    merged: dict[str, dict[str, float]] = {}
    for state in semantics.states:
        merged.setdefault(spelled(state.name), {}).update(state.values)
    for name in sorted(merged, key=lambda each: each != "home"):
        values = merged[name]
        inside = all(_within(values[joint], limits[joint]) for joint in planned if joint in values)
        if name in given or not inside or not any(joint in values for joint in planned):
            continue
        home = found.get("home", ())
        if len(home) != len(planned):  # none; or one of a wrong length, which is refused where it is given
            home = tuple(min(max(0.0, limits[j][0]), limits[j][1]) for j in planned)
        row = (values.get(joint, other) for joint, other in zip(planned, home, strict=True))
        bounds = (limits[joint] for joint in planned)
        found[name] = tuple(min(max(value, low), high) for value, (low, high) in zip(row, bounds, strict=True))
    return found


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] - LIMIT_SLACK <= value <= limits[1] + LIMIT_SLACK


def findings(
    semantics: SemanticDescription,
    joints: Mapping[str, JointEnds],
    links: Sequence[str],
    limits: Mapping[str, tuple[float, float]],
) -> list[Diagnostic]:
    """Warnings about what an SRDF file says of links and joints that the URDF does not have, and beyond its limits.

    Args:
        semantics: the SRDF file.
        joints: the joints of the URDF.
        links: the links of the URDF.
        limits: of the joints that move on their own.
    """
    found: list[Diagnostic] = []

    def unknown(place: Place | None, what: str, word: str, known: Iterable[str]) -> None:
        at = place or Place(str(semantics.path), 1, 1)
        hint = did_you_mean(word, known) or "it is left out"
        found.append(Diagnostic(at.file, at.line, at.column, f'{what} "{word}"', hint, at.length, "warning"))

    for pair in semantics.disabled:
        for link in (pair.first, pair.second):
            if link not in links:
                unknown(pair.place, "<disable_collisions> names the unknown link", link, links)
    for group in semantics.groups.values():
        for link in (*group.links, *(end for chain in group.chains for end in chain)):
            if link not in links:
                unknown(group.places.get(link), f'group "{group.name}" names the unknown link', link, links)
        for joint in group.joints:
            if joint not in joints and joint not in semantics.virtual:
                unknown(group.places.get(joint), f'group "{group.name}" names the unknown joint', joint, joints)
    for each in semantics.end_effectors:
        if each.parent_link not in links:
            unknown(
                each.place, f'<end_effector name="{each.name}"> names the unknown link', each.parent_link, links
            )
    for frame in (*semantics.grippers, *semantics.handles):
        if frame.link not in links:
            unknown(frame.place, f'"{frame.name}" is on the unknown link', frame.link, links)
    for state in semantics.states:
        found.extend(_beyond(state, limits))
    return found


def _beyond(state: GroupState, limits: Mapping[str, tuple[float, float]]) -> Iterator[Diagnostic]:
    for joint, value in state.values.items():
        if joint in limits and not _within(value, limits[joint]):
            low, high = limits[joint]
            at = state.places[joint]
            said = f'state "{state.name}": {joint} = {value:.6g} is outside its limits [{low:.6g}, {high:.6g}]'
            hint = "the state is left out; write it under `configurations` of the scene"
            yield Diagnostic(at.file, at.line, at.column, said, hint, at.length, "warning")
