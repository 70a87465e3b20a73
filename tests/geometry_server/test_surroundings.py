"""What bodies are asked to keep from each other by checks of convex parts and by those of the original meshes."""

from pathlib import Path

import pytest

from kabo.geometry_server import GeometryServer
from kabo.scene import Scene, load_scene

KEPT = 0.0005  # m: less than the share of an epsilon of 20 mm that convex parts keep anyway


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    """Two boxes that are 0.4 mm apart."""
    boxes = [
        f"  {name}: {{box: [0.1, 0.1, 0.1], pose: {{position: [{x}, 0, 0]}}}}"
        for name, x in (("a", 0.0), ("b", 0.1004))
    ]
    (tmp_path / "scene.yaml").write_text("\n".join(["scene: s", "epsilon: 0.02", "objects:", *boxes]) + "\n")
    return load_scene(tmp_path / "scene.yaml")


def test_the_original_meshes_keep_a_clearance_that_is_small_beside_epsilon(scene: Scene) -> None:
    """What convex parts keep anyway was left out here, too: a plan with --geometry exact had 0.4 mm of 0.5 mm."""
    exact = GeometryServer(scene, exact=True, clearance=KEPT).surroundings
    assert exact.asked("a") + exact.asked("b") == pytest.approx(KEPT)


def test_convex_parts_are_not_asked_for_what_they_keep_anyway(scene: Scene) -> None:
    bounding = GeometryServer(scene, clearance=KEPT).surroundings
    assert bounding.asked("a") == 0.0 and bounding.kept("a") == KEPT / 2
