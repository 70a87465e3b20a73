"""Features, those given for nothing included."""

import math

from hypothesis import given
from hypothesis import strategies as st

from kabo.language import load_problem
from kabo.language.scene_description import Feature, Shape
from kabo.language.yaml.scenes.features import WORLD_FEATURES, given_features
from tests.language.conftest import SCENE, Kitchen


def test_a_box_has_eight_features_for_nothing() -> None:
    features = given_features(Shape("box", size=(2.0, 4.0, 6.0)))
    assert sorted(features) == ["axis", "bottom", "center", "top", "up", "x_axis", "y_axis"]
    assert features["top"] == Feature("plane", (0.0, 0.0, 3.0), (0.0, 0.0, 1.0))
    assert features["bottom"] == Feature("plane", (0.0, 0.0, -3.0), (0.0, 0.0, 1.0))
    assert features["y_axis"] == Feature("line", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def test_a_cylinder_has_no_sides_and_a_sphere_only_a_center() -> None:
    assert sorted(given_features(Shape("cylinder", size=(1.0, 1.0, 2.0)))) == [
        "axis",
        "bottom",
        "center",
        "top",
        "up",
    ]
    assert sorted(given_features(Shape("sphere", size=(1.0, 1.0, 1.0)))) == ["center"]
    assert given_features(Shape("mesh")) == {}


def test_the_world_has_an_origin_an_up_and_a_floor() -> None:
    assert {name: feature.kind for name, feature in WORLD_FEATURES.items()} == {
        "origin": "point",
        "up": "line",
        "floor": "plane",
    }


def test_what_a_body_declares_replaces_what_it_has_for_nothing(kitchen: Kitchen) -> None:
    own = "features: {top: {plane: {through: [0, 0, 1], normal: [0, 0, -3]}}}, pose: {position: [0, 0, -0.02]}"
    kitchen.write(scene=SCENE.replace("pose: {position: [0, 0, -0.02]}", own))
    scene = load_problem(kitchen.problem).scene
    assert scene is not None
    assert scene.bodies["table"].features["top"] == Feature("plane", (0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
    assert "center" in scene.bodies["table"].features


@given(direction=st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3).filter(any))
def test_directions_are_normalised_however_small_or_large(direction: tuple[float, float, float]) -> None:
    from pathlib import Path

    from kabo.language.findings import Findings
    from kabo.language.source import SourceFile
    from kabo.language.yaml.documents import read_document
    from kabo.language.yaml.scenes.features import read_features
    from kabo.language.yaml.values import Reader

    text = f"f: {{line: {{through: [0, 0, 0], along: [{', '.join(map(repr, direction))}]}}}}"
    findings = Findings()
    feature = read_features(Reader(findings), read_document(SourceFile(Path("f"), "f", text), findings))["f"]
    assert not findings.diagnostics and feature is not None and feature.direction is not None
    assert abs(math.hypot(*feature.direction) - 1.0) < 1e-12
