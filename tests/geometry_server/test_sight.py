"""Views at a small epsilon, where bodies have coarse parts that are divided when they are needed."""

from pathlib import Path

import pytest
import trimesh

from kabo.geometry_server import GeometryServer
from kabo.language import load_scene_description
from kabo.scene import load_scene
from tests.support.small_robots import ARM

SCENE = """
scene: ring
epsilon: 0.002
robots:
  arm:
    urdf: small.urdf
    sensors:
      eye: {{frame: base, pose: {{position: [0, 0, 0.2]}}, field_of_view: 60 deg, range: [0.15, 0.9],
            allowed: [upper, lower, left, right]}}
objects:
  tin: {{cylinder: {{radius: {radius}, height: 0.02}}, pose: {{position: [0, 0, 0.7]}}, movable: true}}
  ring: {{mesh: ring.stl, pose: {{position: [{aside}, 0, 0.45]}}}}
"""


@pytest.mark.parametrize(
    ("radius", "aside", "hidden_by"), [(0.02, 0.0, None), (0.02, 0.1, "ring"), (0.15, 0.0, "ring")]
)
def test_at_a_small_epsilon_a_ring_hides_only_what_is_not_seen_through_it(
    radius: float, aside: float, hidden_by: str | None, tmp_path: Path
) -> None:
    (tmp_path / "small.urdf").write_text(ARM)
    trimesh.creation.torus(0.1, 0.03, major_sections=12, minor_sections=8).export(tmp_path / "ring.stl")
    (tmp_path / "scene.yaml").write_text(SCENE.format(radius=radius, aside=aside))
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    for exact in (False, True):
        server = GeometryServer(scene, exact=exact)
        unseen = server.predicates(scene.start).unseen("arm.eye", "tin")
        assert (None if unseen is None else unseen.by) == hidden_by
