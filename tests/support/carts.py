"""A cart: a robot of boxes with an arm of two joints, to be driven, as text."""

from pathlib import Path

from kabo.language import load_scene_description
from kabo.scene import Robot, load_scene

CART = """<robot name="cart">
  <link name="body"><collision><origin xyz="0.05 0 0.1"/><geometry><box size="0.5 0.3 0.2"/></geometry></collision></link>
  <link name="wheel"><collision><origin xyz="0 0 0.05"/><geometry><box size="0.02 0.4 0.1"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.04 0.04 0.2"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.03 0.03 0.2"/></geometry></collision></link>
  <joint name="axle" type="continuous"><parent link="body"/><child link="wheel"/><axis xyz="0 1 0"/></joint>
  <joint name="shoulder" type="revolute"><parent link="body"/><child link="upper"/><origin xyz="0.1 0 0.2"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="hand"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" velocity="1" effort="1"/></joint>
  %s
</robot>
"""
OWN_JOINTS = """<link name="map"/><link name="a"/><link name="b"/>
  <joint name="base_x" type="prismatic"><parent link="map"/><child link="a"/><origin xyz="0 0 0.01"/><axis xyz="0 1 0"/>
    <limit lower="-5" upper="0.7" velocity="0.3" effort="1"/></joint>
  <joint name="base_y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="-1 0 0"/>
    <limit lower="-5" upper="5" velocity="0.3" effort="1"/></joint>
  <joint name="base_yaw" type="%s"><parent link="b"/><child link="body"/><origin xyz="0.2 0.1 0" rpy="0 0 0.4"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>"""
LOOSE = """<link name="map"/>
  <joint name="root" type="%s"><parent link="map"/><child link="body"/><origin xyz="0 0 0.02"/></joint>"""
SCENE = """scene: carts
epsilon: 0.01
robots:
  cart:
    urdf: cart.urdf
    base: {%s}
    joints: [shoulder, elbow]
    configurations: {home: [0.5, 1.0]%s}
regions:
  hall: {%s}
"""


def cart(
    folder: Path,
    base: str = "moves: {within: hall}",
    *,
    hall: str = "box: [3, 2, 0.1]",
    extra: str = "",
    configurations: str = ", away: [0.6, -0.4, 90 deg, 0, 0]",
) -> Robot:
    """The cart of a scene written into a folder, with the text of its base and of its floor region."""
    (folder / "cart.urdf").write_text(CART % extra)
    (folder / "scene.yaml").write_text(SCENE % (base, configurations, hall))
    return load_scene(load_scene_description(folder / "scene.yaml")).robots["cart"]
