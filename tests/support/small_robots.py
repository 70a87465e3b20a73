"""Small robots as URDF text, for tests that need a real file."""

from pathlib import Path

ARM = """<robot name="small">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.15"/><geometry><box size="0.04 0.04 0.3"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.02" length="0.3"/></geometry></collision></link>
  <link name="hand"/>
  <link name="left"><collision><geometry><box size="0.01 0.02 0.05"/></geometry></collision></link>
  <link name="right"><collision><geometry><box size="0.01 0.02 0.05"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.05" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.3"/>
    <axis xyz="1 0 0"/><limit lower="-2.5" upper="2.5" velocity="2" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="lower"/><child link="hand"/><origin xyz="0 0 0.3"/>
    <axis xyz="0.6 0 0.8"/><limit velocity="3" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="hand"/><child link="left"/><origin xyz="0 0 0.02"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.04" velocity="0.1" effort="1"/></joint>
  <joint name="other_finger" type="prismatic"><parent link="hand"/><child link="right"/><origin xyz="0 0 0.02"/>
    <axis xyz="-1 0 0"/><limit lower="0" upper="0.081" velocity="0.2" effort="1"/><mimic joint="finger" multiplier="2" offset="0.001"/></joint>
</robot>
"""


def write_arm(folder: Path) -> Path:
    """The URDF file of a small arm with a gripper whose second finger mimics the first."""
    path = folder / "small.urdf"
    path.write_text(ARM)
    return path
