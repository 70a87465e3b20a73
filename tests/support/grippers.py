"""Grippers of several kinds as URDF text, on an arm that only lifts: their fingers meet around a block.

Each closes along y; a block 40 mm wide is between the fingers at `closing` of the way from open to closed.
"""

from dataclasses import dataclass
from math import asin
from pathlib import Path

BOX = "<collision><origin xyz='{place}'/><geometry><box size='{size}'/></geometry></collision>"
LIFT = """<robot name="lifter">
  <link name="base"/><link name="palm">{palm}</link>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="palm"/><origin xyz="0 0 0.6"/><axis xyz="0 0 1"/>
    <limit lower="-0.55" upper="0.4" velocity="0.5" effort="500"/></joint>
  {fingers}
</robot>"""
SCENE = """scene: lifter
epsilon: 0.002
robots:
  arm:
    urdf: lifter.urdf
    base: {{position: [0, 0, 0]}}
    joints: [lift]
    gripper:
      joints: [{joints}]
      open: {{{open}}}
      closed: {{{closed}}}
      touch_links: [{touching}]
      force: {force}
    tool: {{frame: palm}}
objects:
  table: {{box: [0.4, 0.4, 0.1], pose: {{position: [0, 0, -0.05]}}}}
  block: {{box: [0.04, 0.04, 0.06], mass: 0.3, movable: true, pose: {{position: [0, 0, 0.03]}}}}
"""


@dataclass(frozen=True)
class Gripper:
    """The fingers as URDF, the joints with their values when open and closed, and the links that touch."""

    fingers: str
    open: dict[str, float]
    closed: dict[str, float]
    touching: tuple[str, ...]

    def write(self, folder: Path, force: float = 20.0) -> Path:
        """The scene file of a lifter with this gripper."""
        palm = BOX.format(place="0 0 0.02", size="0.06 0.14 0.02")
        (folder / "lifter.urdf").write_text(LIFT.format(palm=palm, fingers=self.fingers))
        ends = (", ".join(f"{k}: {v}" for k, v in each.items()) for each in (self.open, self.closed))
        path = folder / "scene.yaml"
        names = ", ".join(self.open)
        texts = dict(zip(("open", "closed"), ends, strict=True))
        path.write_text(SCENE.format(joints=names, touching=", ".join(self.touching), force=force, **texts))
        return path


def _finger(
    name: str, parent: str, kind: str, place: str, axis: str, box: str, limits: str, mimic: str = ""
) -> str:
    coupled = f"<mimic joint='{mimic.split(maxsplit=1)[0]}' multiplier='{mimic.split()[1]}'/>" if mimic else ""
    return f"""<link name="{name}">{box}</link>
  <joint name="{name}_joint" type="{kind}"><parent link="{parent}"/><child link="{name}"/><origin xyz="{place}"/>
    <axis xyz="{axis}"/><limit {limits} velocity="1" effort="200"/>{coupled}</joint>
  """


def _pad(y: float, z: float = -0.06) -> str:
    return BOX.format(place=f"0 {y} {z}", size="0.02 0.01 0.06")


def sliding() -> Gripper:
    """Two fingers that slide, one coupled to the other."""
    limits = "lower='0' upper='0.04'"
    fingers = _finger("left", "palm", "prismatic", "0 0.005 0", "0 1 0", _pad(0.0), limits)
    fingers += _finger("right", "palm", "prismatic", "0 -0.005 0", "0 -1 0", _pad(0.0), limits, "left_joint 1")
    return Gripper(fingers, {"left_joint": 0.03}, {"left_joint": 0.0}, ("left", "right"))


def independent() -> Gripper:
    """Two fingers that slide, each with a motor."""
    limits = "lower='0' upper='0.04'"
    fingers = _finger("left", "palm", "prismatic", "0 0.005 0", "0 1 0", _pad(0.0), limits)
    fingers += _finger("right", "palm", "prismatic", "0 -0.005 0", "0 -1 0", _pad(0.0), limits)
    ends = ({f"{side}_joint": value for side in ("left", "right")} for value in (0.03, 0.0))
    return Gripper(fingers, *ends, ("left", "right"))


def turning() -> Gripper:
    """Two fingers that turn about axes beside the palm; pads are parallel where they meet the block."""
    limits = "lower='-0.5' upper='0.5'"
    fingers = _finger("left", "palm", "revolute", "0 0.025 0", "1 0 0", _pad(0.0), limits)
    fingers += _finger("right", "palm", "revolute", "0 -0.025 0", "-1 0 0", _pad(0.0), limits, "left_joint 1")
    return Gripper(fingers, {"left_joint": 0.3}, {"left_joint": -0.3}, ("left", "right"))


def linkage() -> Gripper:
    """As Robotiq's: knuckles turn, and pads turn back as much, so that they stay parallel; one motor for all."""
    knuckle, limits = 0.06, "lower='-1' upper='1'"
    shape = BOX.format(place="0 0 -0.03", size="0.01 0.01 0.04")
    fingers = ""
    for side, sign, follow in (("left", 1, ""), ("right", -1, "left_knuckle_joint 1")):
        place, axis, back = f"0 {0.03 * sign} 0", f"{sign} 0 0", f"{-sign} 0 0"
        fingers += _finger(f"{side}_knuckle", "palm", "revolute", place, axis, shape, limits, follow)
        fingers += _finger(
            side, f"{side}_knuckle", "revolute", f"0 0 {-knuckle}", back, _pad(0.0, 0.0), limits,
            "left_knuckle_joint 1",
        )  # fmt: skip
    opened, closed = asin(0.02 / knuckle), -asin(0.02 / knuckle)
    return Gripper(fingers, {"left_knuckle_joint": opened}, {"left_knuckle_joint": closed}, ("left", "right"))


def jaw() -> Gripper:
    """One jaw that turns against one that stands."""
    fixed = BOX.format(place="0 -0.025 -0.06", size="0.02 0.01 0.06")
    fingers = f"""<link name="still">{fixed}</link>
  <joint name="still_joint" type="fixed"><parent link="palm"/><child link="still"/></joint>
  """
    fingers += _finger("left", "palm", "revolute", "0 0.025 0", "1 0 0", _pad(0.0), "lower='-0.5' upper='0.5'")
    return Gripper(fingers, {"left_joint": 0.3}, {"left_joint": -0.3}, ("left", "still"))


GRIPPERS = {"sliding": sliding, "independent": independent, "turning": turning, "linkage": linkage, "jaw": jaw}
