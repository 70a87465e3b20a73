"""A small scene with an arm of one joint, a table and a cup: drawn in a moment."""

from pathlib import Path

from kabo.language import load_scene_description
from kabo.language.scene_description import SceneDescription

URDF = """<robot name="arm">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.04 0.04"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><origin xyz="0 0 0.12"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
</robot>
"""
SCENE = """scene: small
epsilon: 0.01
robots:
  arm: {urdf: arm.urdf, base: {position: [0, 0, 0.1]}}
objects:
  table: {box: [1.0, 1.0, 0.04], pose: {position: [0.0, 0, -0.02]}}
  cup: {box: [0.05, 0.05, 0.1], movable: true, pose: {position: [0.3, 0, 0.05]}}
"""


def table_and_arm(folder: Path) -> SceneDescription:
    """The scene, its files in a folder."""
    (folder / "arm.urdf").write_text(URDF)
    (folder / "scene.yaml").write_text(SCENE)
    return load_scene_description(folder / "scene.yaml")
