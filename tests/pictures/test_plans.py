"""Pictures of plans: strips, animations, and what a motion sweeps."""

from io import BytesIO

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.phases import heard_by
from kabo.pictures.film import Film
from kabo.pictures.plans import animation, film_strip
from kabo.pictures.sweeps import sweep_drawing
from kabo.pictures.views import ViewWishes
from kabo.plan import Node, ObjectPose, Plan, Segment, StateChange, branch_of
from kabo.scene import load_scene, world_T
from tests.pictures.scenes import table_and_arm

START = StateChange({"arm": {"turn": 0.0}}, {"cup": ObjectPose("world", (0.3, 0.0, 0.05), (0.0, 0.0, 0.0, 1.0))})
TURN = Segment("arm", ("turn",), ((0.0,), (1.2,)), (0.0, 1.5), "move")
PLAN = Plan(
    "turning",
    {},
    {},
    "n0",
    {
        "n0": Node("sense", "look", on="empty(cup)", branches={"false": "n2", "true": "n1"}),
        "n1": Node("action", "turn", {"r": "arm"}, next="n2", motion=(TURN,)),
        "n2": Node("goal"),
    },
    START,
)


@pytest.fixture
def scene(tmp_path):
    return load_scene(table_and_arm(tmp_path))


def opened(picture: bytes):
    pytest.importorskip("pyvista")
    from PIL import Image

    return Image.open(BytesIO(picture))


def test_a_strip_shows_the_start_and_the_end_of_each_motion_side_by_side(scene):
    pytest.importorskip("pyvista")
    made = film_strip(PLAN, scene, None, ViewWishes(size=(200, 150)), "plan.json")
    assert opened(made).width > 2 * 200 > opened(made).height
    assert made == film_strip(PLAN, scene, "true", ViewWishes(size=(200, 150)), "plan.json")


def test_an_animation_moves_begins_again_and_stays_at_its_end(scene):
    pytest.importorskip("pyvista")
    made = animation(PLAN, scene, None, ViewWishes(size=(160, 120)), "plan.json")
    image = opened(made)
    assert image.n_frames > 10 and image.info["loop"] == 0
    first = np.asarray(image.convert("RGB"), float)
    image.seek(image.n_frames - 1)
    assert np.abs(first - np.asarray(image.convert("RGB"), float)).max() > 50 and image.info["duration"] >= 1500


def test_who_waits_for_a_picture_hears_of_its_frames(scene, monkeypatch):
    pytest.importorskip("pyvista")
    monkeypatch.setattr("kabo.phases.EVERY_S", 0.0)
    heard = []
    with heard_by(heard.append):
        image = opened(animation(PLAN, scene, None, ViewWishes(size=(160, 120)), "plan.json"))
        assert max(each.done for each in heard) == heard[0].total >= image.n_frames
        heard.clear()
        film_strip(PLAN, scene, None, ViewWishes(size=(200, 150)), "plan.json")
    assert [(each.done, each.total, each.unit) for each in heard[:3]] == [(n, 2, "frames") for n in range(3)]


def test_a_branch_on_which_nothing_moves_is_refused_with_the_remedy(scene):
    with pytest.raises(InputError, match=r"nothing moves on this branch\n.*\.svg"):
        film_strip(PLAN, scene, "false", ViewWishes(), "plan.json")


def test_a_sweep_contains_the_link_wherever_it_comes_by_and_little_more(scene):
    drawing, said = sweep_drawing(PLAN, scene, "n1", 0.01, "plan.json")
    (swept,) = drawing.glass[-1].solids
    film = Film(PLAN, scene, branch_of(PLAN, "n1", "plan.json"))
    hand = scene.robots["arm"].links["hand"].mesh.vertices
    points = []
    for time in np.linspace(0.0, 1.5, 31):
        pose = world_T(scene, film.at("n1", time), "arm.hand")
        points.append(hand @ pose[:3, :3].T + pose[:3, 3])
    low, high = np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)
    moving = swept.vertices[swept.vertices[:, 2] > 0.2]  # the base stands still below
    assert (moving.min(axis=0)[:2] <= low[:2]).all() and (moving.max(axis=0)[:2] >= high[:2]).all()
    assert (np.abs(moving.max(axis=0) - high) < 0.03).all() and "polyhedra" in said


@pytest.mark.parametrize(
    ("wanted", "said"),
    [("n0", "these do: n1"), ("n1:2", "n1:1 to n1:1"), ("n1:x", 'no segment "x"'), ("n11", 'did you mean "n1"')],
)
def test_a_sweep_of_what_is_not_there_is_one_message_with_the_remedy(scene, wanted, said):
    with pytest.raises(InputError) as error:
        sweep_drawing(PLAN, scene, wanted, 0.01, "plan.json")
    assert said in str(error.value)
