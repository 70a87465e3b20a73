"""Groups of objects: whatever is hung on something else takes what hangs together with it along, and stays in place."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import Refusal
from kabo.scene import attachment
from kabo.tasks.core import Result
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.motion.groups import hung
from tests.tasks.robots.conftest import first
from tests.tasks.robots.test_stages import forward, only

GEARBOX = "assembly/gearbox.yaml"
NAMES = ("o1", "o2", "o3", "o4")


def at(scene: TaskScene) -> dict[str, np.ndarray]:
    return {name: scene.pose(name) for name in NAMES}


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(
    links=st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from((*NAMES, "world"))), min_size=1, max_size=6)
)
def test_whatever_is_hung_on_whatever_nothing_moves_and_nothing_hangs_on_itself(links):
    scene = first(GEARBOX)
    before, linked = at(scene), set()
    for name, parent in links:
        if parent != "world" and scene.situation.root(parent) == scene.situation.root(name):
            continue
        group = set(scene.situation.group(name))
        scene = hung(scene, name, parent, np.eye(4) if parent == "world" else scene.pose(parent))
        assert scene.situation.attachment(name).parent == parent
        assert group <= set(scene.situation.group(name))
        if parent == "world":
            assert scene.situation.root(name) == name
        linked.add(parent != "world")
    event(f"groups: {len({scene.situation.root(name) for name in NAMES})}")
    after = at(scene)
    for name in NAMES:
        assert after[name] == pytest.approx(before[name], abs=1e-7)


def held(scene: TaskScene, name: str, robot: str) -> TaskScene:
    """The scene with an object in a hand, 0.5 m above the table, wherever that is."""
    return scene.placing(name, attachment(f"{robot}.tool0", np.eye(4)))


def test_what_hangs_on_something_in_a_hand_is_held_as_well(first_scene: Callable[..., TaskScene]) -> None:
    scene = held(hung(first_scene(GEARBOX), "o2", "o3", first_scene(GEARBOX).pose("o3")), "o3", "robot_1")
    assert scene.holder("o2") == scene.holder("o3") == "robot_1"
    assert set(scene.workspace("robot_1").carried) == {"o2", "o3"}
    touched = {name for pair in scene.workspace("robot_1").touching("o2") for name in pair}
    assert not touched, "the fingers hold the pipe, not what is in it"


def test_parts_in_one_hand_are_not_put_together(first_scene: Callable[..., TaskScene]) -> None:
    scene = held(held(first_scene(GEARBOX), "o1", "robot_1"), "o3", "robot_1")
    failure = only(forward(scene, "Join", object="o1", onto="o3"))
    assert isinstance(failure, Refusal)
    assert failure.comment == "nobody brings o1 to o3"


def test_a_part_that_is_let_go_hangs_on_the_other_one(first_scene: Callable[..., TaskScene]) -> None:
    scene = held(first_scene(GEARBOX), "o1", "robot_1")
    scene = scene.permitting([("o1", f"robot_1.{link}") for link in scene.robot("robot_1").links])
    result = only(forward(scene, "Join", object="o1", onto="o4"))
    assert isinstance(result, Result)
    after: TaskScene = result.scene
    assert after.situation.attachment("o1").parent == "o4"
    assert after.pose("o1") == pytest.approx(scene.pose("o1"), abs=1e-7)
    (motion,) = result.motion or ()
    assert (motion.robot, motion.attach, motion.detach) == ("robot_1", (("o1", "o4"),), ("o1",))


def test_only_who_is_said_to_hand_something_over_gives_it_away(first_scene: Callable[..., TaskScene]) -> None:
    scene = held(first_scene(GEARBOX), "o1", "robot_1")
    refused = only(forward(scene, "Attach", object="o1", to="robot_2"))
    assert isinstance(refused, Refusal)
    assert "robot_1 holds o1 already" in refused.comment
    everything = [
        (a, f"{b}.{link}") for a in ("o1",) for b in ("robot_1", "robot_2") for link in scene.robot(b).links
    ]
    given_over = only(forward(scene.permitting(everything), "Attach", object="o1", to="robot_2", of="robot_1"))
    assert isinstance(given_over, Result)
    assert given_over.scene.holder("o1") == "robot_2"
    let_go = only(forward(given_over.scene, "Detach", object="o1", of="robot_1"))
    assert let_go.scene.holder("o1") == "robot_2"
    assert [(motion.robot, motion.detach) for motion in let_go.motion] == [("robot_1", ("o1",))]
