"""Robots with one fault each: a URDF, an SRDF or a mesh, the words of the finding, and a text in its line."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import trimesh

from tests.support.small_robots import ARM

SRDF = """<robot name="small">
  <group name="arm">
    <chain base_link="base" tip_link="hand"/>
  </group>
  <group_state name="up" group="arm">
    <joint name="shoulder" value="0.5"/>
  </group_state>
  <disable_collisions link1="base" link2="lower" reason="Never"/>
</robot>
"""
SCENE = """scene: s
epsilon: 0.01
robots:
  r:
    urdf: robot.urdf
    srdf: robot.srdf
    gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}, touch_links: [left, right]}
    allowed_contacts: [[base, lower], [left, right], ["upper", "*"], [hand, "*"], [base, left], [base, right]]
"""
MESH = '<mesh filename="part.stl"/>'
UPPER = '<box size="0.04 0.04 0.3"/>'


@dataclass(frozen=True)
class Broken:
    """A scene with one fault.

    `where` is the file of the finding, `at` a text in the line of the finding (None: the file itself is not read as
    text), `says` words of the message and of the remedy.
    """

    name: str
    where: str = "robot.urdf"
    at: str | None = None
    says: tuple[str, ...] = ()
    urdf: str | bytes = ARM
    srdf: str = SRDF
    scene: str = SCENE
    severity: str = "error"
    write: Callable[[Path], None] = field(default=lambda folder: None)

    def place(self, folder: Path) -> Path:
        """Writes the files; returns the scene."""
        content = self.urdf if isinstance(self.urdf, bytes) else self.urdf.encode()
        (folder / "robot.urdf").write_bytes(content)
        (folder / "robot.srdf").write_text(self.srdf)
        (folder / "scene.yaml").write_text(self.scene)
        self.write(folder)
        return folder / "scene.yaml"

    def line(self, folder: Path) -> int | None:
        """The line of the finding."""
        if self.at is None:
            return None
        lines = (folder / self.where).read_text().splitlines()
        return 1 + next(number for number, text in enumerate(lines) if self.at in text)


def urdf(name: str, old: str, new: str, *says: str, at: str | None = None) -> Broken:
    """A URDF in which one text is replaced."""
    assert old in ARM, old
    return Broken(name, "robot.urdf", new if at is None else at, says, ARM.replace(old, new, 1))


def srdf(name: str, old: str, new: str, *says: str, severity: str = "error", at: str | None = None) -> Broken:
    """An SRDF in which one text is replaced."""
    assert old in SRDF, old
    return Broken(name, "robot.srdf", at or new, says, srdf=SRDF.replace(old, new, 1), severity=severity)


def mesh(name: str, write: Callable[[Path], None], *says: str, tag: str = MESH) -> Broken:
    """A mesh file with a fault, told at the line of the URDF that names it."""
    return Broken(name, "robot.urdf", tag, says, ARM.replace(UPPER, tag, 1), write=write)


def chain(links: int) -> str:
    """A URDF of a chain of links."""
    parts = [f'  <link name="l{i}"/>' for i in range(links)]
    parts += [
        f'  <joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(links - 1)
    ]
    return "\n".join(['<robot name="chain">', *parts, "</robot>", ""])


def _box(scale: float = 1.0) -> trimesh.Trimesh:
    return trimesh.creation.box(extents=[0.04 * scale, 0.04 * scale, 0.3 * scale])


def _open_box(folder: Path) -> None:
    box = _box()
    box.update_faces([True] * 11 + [False])
    box.export(folder / "part.stl")


def _flat(folder: Path) -> None:
    trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).export(folder / "part.stl")


def _millimetres(folder: Path) -> None:
    _box(1000.0).export(folder / "part.stl")


def _inside_out(folder: Path) -> None:
    box = _box()
    box.invert()
    box.export(folder / "part.stl")


def cases() -> Iterator[Broken]:
    """All broken robots."""
    yield from _joints()
    yield from _numbers()
    yield from _trees()
    yield from _texts()
    yield from _meshes()
    yield from _srdfs()


def _joints() -> Iterator[Broken]:
    limit = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    yield urdf(
        "no limits",
        limit,
        "",
        'joint "shoulder" is revolute and has no <limit>',
        'type="continuous"',
        at='name="shoulder"',
    )
    yield urdf("crossed limits", 'lower="-2"', 'lower="9"', "above its upper one", "swap")
    yield urdf(
        "velocity below zero",
        'velocity="1"',
        'velocity="-1"',
        "the velocity of joint",
        "below 0",
        "leave the sign out",
    )
    yield urdf(
        "effort below zero", 'effort="1"', 'effort="-1"', "the effort of joint", "below 0", "leave the sign out"
    )
    yield urdf("unknown type", 'type="revolute"', 'type="revolut"', "unknown type", 'did you mean "revolute"')
    yield urdf("floating", 'type="revolute"', 'type="floating"', "neither revolute nor prismatic", "base")
    yield urdf("no axis", 'xyz="0 1 0"', 'xyz="0 0 0"', "has no direction", 'xyz="0 0 1"')
    yield urdf(
        "mimic of nobody", 'joint="finger" mult', 'joint="fnger" mult', "mimics the unknown joint", '"finger"'
    )
    yield urdf("mimic multiplier", 'multiplier="2"', 'multiplier="x"', '"x" is none', "number")
    yield urdf(
        "mimic of itself", 'joint="finger" mult', 'joint="other_finger" mult', "mimics itself", "on its own"
    )


def _numbers() -> Iterator[Broken]:
    yield urdf("short xyz", '<origin xyz="0 0 0.05"', '<origin xyz="0 0"', "must be 3 numbers")
    yield urdf("word in xyz", '<origin xyz="0 0 0.05"', '<origin xyz="0 0 up"', '"up" is none')
    yield urdf("huge origin", '<origin xyz="0 0 0.05"', '<origin xyz="0 0 5e9"', "is too large")
    yield urdf("short box", '"0.04 0.04 0.3"', '".2 .2"', "must be 3 numbers")
    yield urdf("negative box", '"0.04 0.04 0.3"', '"1 1 -1"', "above 0", "metres")
    yield urdf("no radius", ' radius="0.02"', "", "has no `radius`", 'radius="0.1"', at="<cylinder")
    yield urdf("limit word", 'upper="2"', 'upper="two"', '"two" is none')
    yield mesh(
        "mesh scale", lambda folder: _box().export(folder / "part.stl"), '"a" is none',
        tag='<mesh filename="part.stl" scale="a b c"/>',
    )  # fmt: skip
    yield mesh(
        "mesh scaled by 0", lambda folder: _box().export(folder / "part.stl"), "cannot be scaled by 0", "0.001",
        tag='<mesh filename="part.stl" scale="0 0 0"/>',
    )  # fmt: skip


def _trees() -> Iterator[Broken]:
    yield urdf(
        "cycle",
        '<parent link="base"/><child link="upper"/>',
        '<parent link="hand"/><child link="upper"/>',
        "hangs on itself",
        at='name="upper"',
    )
    yield urdf(
        "two roots",
        '  <link name="hand"/>',
        '  <link name="lonely"/>\n  <link name="hand"/>',
        "hang on no joint",
        "child of a joint",
        at='"lonely"',
    )
    yield urdf(
        "unknown parent", '<parent link="base"/>', '<parent link="bse"/>', "unknown link", 'did you mean "base"'
    )
    yield urdf("no child", '<child link="upper"/>', "", "has no child link", "<child link=", at='name="shoulder"')
    yield urdf(
        "link twice",
        '  <link name="hand"/>',
        '  <link name="hand"/>\n  <link name="hand" />',
        "there are two of",
        "rename",
        at='"hand" />',
    )
    yield urdf(
        "joint twice", 'name="elbow"', 'name="shoulder" ', "there are two of", "line", at='"shoulder"  type'
    )
    yield urdf("nameless link", '<link name="hand"/>', "<link/>", "has no name", at="<link/>")
    yield urdf(
        "two parents", '<child link="lower"/>', '<child link="upper" />', "child of two joints", at='name="elbow"'
    )
    yield Broken("no links", at="<robot", says=("has no <link>",), urdf='<robot name="r"/>')
    yield Broken("3,000 links", at='"l500"', says=("3000 links are too many",), urdf=chain(3000))
    yield Broken(
        "misspelt element", "robot.urdf", "<colision>", ("unknown element <colision>", 'did you mean "collision"'),
        ARM.replace("<collision>", "<colision>", 1).replace("</collision>", "</colision>", 1),
    )  # fmt: skip


def _texts() -> Iterator[Broken]:
    yield Broken("cut off", at=None, says=("is no XML", "copied whole"), urdf=ARM[:300])
    yield Broken(
        "DTD", at="<!ENTITY", says=("entities",), urdf='<!DOCTYPE robot [\n<!ENTITY a "aaaa">\n]>\n' + ARM
    )
    yield Broken(
        "wrong encoding",
        at=None,
        says=("is no XML", "UTF-8"),
        urdf=ARM.replace("small", "sm\u00e4ll").encode("latin-1"),
    )
    yield Broken(
        "unknown encoding",
        at=None,
        says=("is no XML", "UTF-8"),
        urdf='<?xml version="1.0" encoding="klingon"?>\n' + ARM,
    )
    yield Broken(
        "huge",
        "scene.yaml",
        "urdf: robot.urdf",
        ("larger than 16 MB", "meshes"),
        (ARM + " " * 16_100_000).encode(),
    )
    yield Broken(
        "MJCF",
        at="<mujoco",
        says=("MuJoCo model (MJCF)", "use the URDF"),
        urdf='<mujoco model="m"><worldbody/></mujoco>',
    )
    yield Broken(
        "SDF", at="<sdf", says=("SDF model", "use the URDF"), urdf='<sdf version="1.7"><model name="m"/></sdf>'
    )
    yield Broken(
        "xacro as URDF",
        at="<xacro:",
        says=("macro", ".xacro"),
        urdf='<robot name="x" xmlns:xacro="http://x">\n<xacro:arm/></robot>',
    )


def _meshes() -> Iterator[Broken]:
    yield mesh("missing mesh", lambda folder: None, "does not exist", "looked for")
    yield mesh("similar mesh", lambda folder: _box().export(folder / "Part.stl"), "does not exist", "did you mean")
    yield mesh(
        "unknown package", lambda folder: None, 'unknown package "nowhere"', "packages:",
        tag='<mesh filename="package://nowhere/part.stl"/>',
    )  # fmt: skip
    yield mesh("open mesh", _open_box, 'link "upper"', "not closed", "hulls: [upper]", "closes it (")
    yield mesh("flat mesh", _flat, 'link "upper"', "not closed")
    yield mesh(
        "damaged mesh", lambda folder: (folder / "part.stl").write_bytes(b"solid\nno"), 'link "upper"', "part.stl"
    )
    yield mesh("empty mesh", lambda folder: (folder / "part.stl").write_bytes(b""), 'link "upper"', "part.stl")
    yield replace(
        mesh("millimetres", _millimetres, 'link "upper"', "millimetres", "scale"),
        severity="warning",
    )
    yield replace(
        mesh("inside out", _inside_out, "inside out", "normals"), severity="warning", where="part.stl", at=None
    )
    yield urdf(
        "empty geometry",
        '<geometry><box size="0.1 0.1 0.1"/></geometry>',
        "<geometry/>",
        "empty geometry",
        at='name="base"',
    )


def _srdfs() -> Iterator[Broken]:
    yield srdf("SRDF no XML", "</robot>", "</robt>", "is no XML")
    yield srdf("SRDF number", 'value="0.5"', 'value="half"', '"half" is none')
    yield srdf("SRDF no link", ' link2="lower"', "", "has no `link2`", at="<disable_collisions")
    yield srdf(
        "SRDF unknown link",
        'link2="lower"',
        'link2="lowr"',
        "unknown link",
        'did you mean "lower"',
        severity="warning",
    )
    yield srdf(
        "SRDF unknown tip",
        'tip_link="hand"',
        'tip_link="hnd"',
        "unknown link",
        'did you mean "hand"',
        severity="warning",
    )
    yield srdf(
        "SRDF unknown group",
        'group="arm"',
        'group="arn"',
        "unknown group",
        'did you mean "arm"',
        severity="warning",
    )
    yield srdf(
        "SRDF misspelt",
        "<disable_collisions",
        "<disable_collision",
        "unknown element",
        "disable_collisions",
        severity="warning",
    )
    yield srdf("SRDF beyond limits", 'value="0.5"', 'value="7"', "outside its limits", severity="warning")
    yield Broken("URDF as SRDF", "robot.srdf", "<robot", ("is a URDF, not an SRDF", "urdf"), srdf=ARM)
    yield Broken(
        "unknown pattern",
        "scene.yaml",
        "allowed_contacts",
        ('"uper*" is no link', "upper"),
        scene=SCENE.replace('"upper"', '"uper*"'),
    )
    yield Broken(
        "unknown joint group",
        "scene.yaml",
        "joints: arn",
        ('unknown group "arn"', '"arm"'),
        scene=SCENE.replace("    srdf", "    joints: arn\n    srdf"),
    )
