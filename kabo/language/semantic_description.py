"""The content of an SRDF file: what a URDF does not say about its robot. Names are not compared with the URDF's.

Lengths are metres, angles radians, quaternions (x, y, z, w).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from kabo.language.formulas import Place


@dataclass(frozen=True)
class DisabledPair:
    """Two links whose collision is not checked, and the reason that the file gives."""

    first: str
    second: str
    reason: str = ""
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class JointGroup:
    """A group: links and joints by name, chains (base link, tip link), and groups that it includes."""

    name: str
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    chains: tuple[tuple[str, str], ...] = ()
    groups: tuple[str, ...] = ()
    places: Mapping[str, Place] = field(default_factory=dict, compare=False, repr=False)  # of the names in it
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class GroupState:
    """A named configuration of a group: values of joints [rad or m]."""

    name: str
    group: str
    values: Mapping[str, float]
    places: Mapping[str, Place] = field(default_factory=dict, compare=False, repr=False)
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class EndEffector:
    """An end effector: the group of its joints, and the link that carries it."""

    name: str
    group: str
    parent_link: str
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class HandlingFrame:
    """A frame of HPP, a `<gripper>` or a `<handle>`: its link, its pose there, and how near both may come [m]."""

    name: str
    link: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    clearance: float = 0.0
    mask: tuple[bool, bool, bool, bool, bool, bool] = (
        True,
    ) * 6  # of x, y, z, and turns about them: what is fixed
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class SemanticDescription:
    """An SRDF file."""

    path: Path
    disabled: tuple[DisabledPair, ...] = ()
    groups: Mapping[str, JointGroup] = field(default_factory=dict)
    states: tuple[GroupState, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    passive: Mapping[str, Place] = field(default_factory=dict)
    virtual: frozenset[str] = frozenset()  # joints between the world and the robot's first link
    grippers: tuple[HandlingFrame, ...] = ()
    handles: tuple[HandlingFrame, ...] = ()
