"""What is said of a body that is not inside a region: by how much, and never that it reaches 0 mm out."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from kabo.geometry_server import GeometryServer, Refusal
from kabo.scene import load_scene
from kabo.tasks.robots import STAGES, TaskScene
from kabo.tasks.robots.stages.filters import PredicateFilter
from tests.support.small_robots import write_arm


@pytest.mark.parametrize(
    ("beyond", "told"), [(0.00002, "less than 0.1 mm"), (0.0, "less than 0.1 mm"), (0.0121, "12.1 mm")]
)
def test_a_body_that_reaches_out_of_a_region_is_told_with_a_length(
    tmp_path: Path, beyond: float, told: str
) -> None:
    write_arm(tmp_path)
    (tmp_path / "scene.yaml").write_text(
        "scene: s\nepsilon: 0.01\nrobots:\n  arm: {urdf: small.urdf}\n"
        "objects:\n  cup: {box: [0.1, 0.1, 0.1], movable: true, pose: {position: [1, 0, 0]}}\n"
        f"regions:\n  shelf: {{box: [0.2, 0.2, 0.2], pose: {{position: [{0.95 - beyond!r}, 0, 0]}}}}\n"
    )
    made = load_scene(tmp_path / "scene.yaml")
    scene = TaskScene.of(GeometryServer(made).context(), made.start)
    stage = PredicateFilter("filter", STAGES["CurrentState"]("now"))
    given = dict.fromkeys(("attached", "free_hand", "free", "lets_go", "predicate"), ())
    at_end: Any = SimpleNamespace(end=SimpleNamespace(scene=scene))
    (refused,) = stage.transform(at_end, {**given, "free_hand": None, "inside": ("cup", "shelf")}, 0)
    assert isinstance(refused, Refusal)
    assert refused.comment == f"cup does not stand in shelf: it reaches {told} out of it"
