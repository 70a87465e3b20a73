"""The ends of a motion that a caller gives; tests/test_motion_plans.py has names and values that do not fit."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kabo import InputError, load_scene
from kabo.motion_ends import ends_of
from kabo.scene import Scene

SCENE = Path(__file__).parents[1] / "examples" / "two_cans" / "scene.yaml"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(SCENE)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (True, "has True for panda_joint1, which is no number"),
        (10**400, "not finite"),
        (float("nan"), "not finite"),
        ([1], "which is no number"),
        (1j, "which is no number"),
    ],
)
def test_a_value_that_is_no_number_is_refused(scene: Scene, value: Any, words: str):
    with pytest.raises(InputError, match=words):
        ends_of(scene, scene.robots["arm"], "home", {"panda_joint1": value})


def test_numbers_of_numpy_are_values(scene: Scene):
    start, goal = ends_of(scene, scene.robots["arm"], "home", {"panda_joint1": np.float32(0.5)})
    assert goal == (0.5, *start[1:])


def test_a_configuration_that_is_called_nearly_so_is_suggested(scene: Scene):
    with pytest.raises(InputError, match='did you mean "home"'):
        ends_of(scene, scene.robots["arm"], "hom", "home")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("nowhere", "there are home, start"),
        ("hom", 'did you mean "home"?'),
        ("strat", 'did you mean "start"?'),
        ("Home", 'did you mean "home"?'),
        ("", "there are home, start"),
    ],
)
def test_a_name_of_no_configuration_is_told_with_those_that_there_are(scene: Scene, name: str, remedy: str):
    with pytest.raises(InputError, match="arm has no configuration") as told:
        ends_of(scene, scene.robots["arm"], "home", name)
    assert told.value.diagnostics[0].hint == remedy
