"""Pictures of files: what is drawn, its size, the same bytes each time, and one message where nothing can be."""

import json
import struct
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.pictures import PictureWishes, ViewWishes, picture_of_file
from kabo.plan import Node, Plan, plan_to_json
from tests.pictures.scenes import table_and_arm

SENSED = {
    "n0": Node("sense", "look", {"o": "cup & <saucer>"}, on="empty(cup)", branches={"false": "n1", "true": "n2"}),
    "n1": Node("action", "fill", {"o": "cup"}, next="n2"),
    "n2": Node("goal"),
}


@pytest.fixture
def scene(tmp_path):
    table_and_arm(tmp_path)
    return tmp_path / "scene.yaml"


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.json"
    path.write_bytes(
        plan_to_json(
            Plan("cups", {}, {"search": "best", "seed": 0, "epsilon": 0.01, "geometry": "none"}, "n0", SENSED)
        )
    )
    return path


def drawn(path, view: ViewWishes | None = None, **wishes):
    pytest.importorskip("pyvista")
    return picture_of_file(path, ".png", PictureWishes(view=view or ViewWishes(size=(300, 200)), **wishes))


def pixels(picture: bytes) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(BytesIO(picture)).convert("RGB"))


def refused(path, ending=".png", **wishes) -> str:
    with pytest.raises(InputError) as error:
        picture_of_file(path, ending, PictureWishes(**wishes))
    assert len(error.value.diagnostics) == 1
    return str(error.value)


def test_a_graph_names_every_node_and_outcome_and_is_well_formed(plan):
    picture = picture_of_file(plan, ".svg", PictureWishes())
    texts = [
        "".join(each.itertext()) for each in ElementTree.fromstring(picture).iter() if each.tag.endswith("text")
    ]
    assert {"look", "cup & <saucer>", "fill", "goal", "false", "true", "n0", "n1", "n2"} <= set(texts)
    assert picture == picture_of_file(plan, ".svg", PictureWishes())


def test_a_scene_is_drawn_in_the_size_that_is_asked_for_and_the_same_each_time(scene):
    picture = drawn(scene)
    assert struct.unpack(">II", picture[16:24]) == (300, 200)
    assert picture == drawn(scene)


def test_a_picture_is_not_half_empty(scene):
    filled = (pixels(drawn(scene, ViewWishes(labels=False))) < 250).any(axis=2)
    rows, columns = np.nonzero(filled)
    assert np.ptp(rows) > 0.85 * filled.shape[0] and np.ptp(columns) > 0.85 * filled.shape[1]


def test_names_are_written_unless_they_are_not_wanted(scene):
    with_names, without = (
        pixels(drawn(scene, ViewWishes(size=(500, 400), labels=labels))) for labels in (True, False)
    )
    changed = (with_names != without).any(axis=2).mean()
    assert 0.01 < changed < 0.3


def test_a_camera_that_is_asked_for_is_taken(scene):
    above = drawn(scene, ViewWishes(camera=(0.0, 0.0, 4.0), size=(300, 300), labels=False))
    side = drawn(scene, ViewWishes(camera=(4.0, 0.0, 0.2), size=(300, 300), labels=False))
    filled = [(pixels(each) < 250).any(axis=2).mean() for each in (above, side)]
    assert filled[0] > 2.0 * filled[1]  # from above the table fills the picture


def test_a_thing_that_is_looked_at_fills_the_picture(scene):
    near = pixels(drawn(scene, ViewWishes(look_at="cup", size=(300, 200), labels=False)))
    assert near[100, 150].max() - near[100, 150].min() > 40  # the cup's colour, in the middle


def test_samples_of_a_grasp_that_is_not_there_are_refused(scene):
    pytest.importorskip("pyvista")
    assert 'did you mean "arm"?' in refused(scene, samples="am:cup.side")
    assert "ROBOT:OBJECT.GRASP" in refused(scene, samples="arm")


@pytest.mark.parametrize(
    ("ending", "wishes", "said"),
    [
        (".svg", {}, "a scene is not drawn as .svg"),
        (".gif", {}, "plans are also drawn"),
        (".jpg", {}, "end it with .png, .svg, .gif"),
        (".png", {"sweep": "n1"}, "--sweep"),
        (".png", {"branch": "true"}, "this is for a plan, and a scene was given"),
    ],
)
def test_what_does_not_fit_a_scene_is_one_message_with_the_remedy(scene, ending, wishes, said):
    assert said in refused(scene, ending, **wishes)


def test_what_does_not_fit_a_plan_is_one_message_with_the_remedy(plan, tmp_path):
    assert "was not found" in refused(plan)
    assert "shows all of it" in refused(plan, ".svg", at="n1")
    (tmp_path / "other.json").write_text(json.dumps({"format": "kabo-plan/9"}))
    assert "kabo-plan/9" in refused(tmp_path / "other.json")


def test_a_robots_file_is_sent_to_kabo_robot(tmp_path):
    table_and_arm(tmp_path)
    assert "kabo robot" in refused(tmp_path / "arm.urdf")


def test_without_the_library_the_message_says_what_to_install(scene, monkeypatch):
    monkeypatch.setattr("kabo.pictures.files.find_spec", lambda name: None)
    assert 'pip install "kabo[pictures]"' in refused(scene)
