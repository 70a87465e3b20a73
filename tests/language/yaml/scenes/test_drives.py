"""`moves` of a base: what is read, and what is refused at its place."""

import math
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.language.scene_description import DriveDescription
from tests.support.carts import CART, SCENE


def read(folder: Path, moves: str, regions: str = "box: [3, 2, 0.1]") -> DriveDescription | None:
    """The drive of a scene file with this `moves`."""
    (folder / "cart.urdf").write_text(CART % "")
    (folder / "scene.yaml").write_text(SCENE % (f"moves: {moves}", "", regions))
    return load_scene_description(folder / "scene.yaml").robots["cart"].drive


def test_a_region_is_enough(tmp_path: Path) -> None:
    found = read(tmp_path, "{within: hall}")
    assert found == DriveDescription("hall")
    assert found is not None and found.joints == ("base_x", "base_y", "base_yaw")


def test_every_key_is_read(tmp_path: Path) -> None:
    given = "{kind: planar, within: hall, joints: [x, y, w], speed: 1.2, turn_speed: 90 deg, turn: [0, 1], travel: home}"
    found = read(tmp_path, given)
    assert found == DriveDescription("hall", ("x", "y", "w"), 1.2, math.pi / 2, (0.0, 1.0), "home")


WRONG = [
    ("{}", '`moves` needs the key "within"'),
    ("{within: hal}", 'did you mean "hall"?'),
    ("{within: hall, kind: differential}", "a base of the kind differential cannot go sideways"),
    ("{within: hall, kind: plane}", 'unknown kind "plane" of a base that moves'),
    ("{within: hall, wihtin: hall}", 'unknown key "wihtin" of `moves`'),
    ("{within: hall, joints: [x, y]}", "a base that moves has three joints: [x, y, yaw]"),
    ("{within: hall, joints: [x, y, x]}", "a base that moves has three joints: [x, y, yaw]"),
    ("{within: hall, turn: [1, 0]}", "`turn` is crossed"),
    ("{within: hall, turn_speed: 0}", "the turn_speed of a base is not above 0"),
    ("{within: hall, speed: -1}", "the speed"),
    ("{within: hall, travel: hom}", 'did you mean "home"?'),
]


@pytest.mark.parametrize(("moves", "said"), WRONG)
def test_what_is_wrong_is_told(tmp_path: Path, moves: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        read(tmp_path, moves)
    assert said in str(error.value)
    assert "scene.yaml:6:" in str(error.value)


def test_a_floor_that_drives_along_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='hangs on "cart", which drives itself'):
        read(tmp_path, "{within: hall}", "box: [3, 2, 0.1], pose: {frame: cart.body}")
