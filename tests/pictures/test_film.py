"""Films of plans: branches are found by outcomes and nodes, and states are those that the plan says."""

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.pictures.film import Film
from kabo.plan import Node, ObjectPose, Plan, Segment, StateChange, branch_of
from kabo.planner.solve import solve
from kabo.scene import load_scene, world_T
from tests.pictures.scenes import table_and_arm
from tests.support.giving_gantries import giving_gantries


def plan(**nodes: Node) -> Plan:
    return Plan("shown", {}, {}, "n0", nodes)


BRANCHED = plan(
    n0=Node("sense", "look", on="empty(a)", branches={"false": "n1", "true": "n2"}),
    n1=Node("sense", "look", on="colour(a)", branches={"red": "n3", "blue": "n2"}),
    n2=Node("action", "wash", next="n3"),
    n3=Node("goal"),
)


def names(wanted: str | None) -> list[str]:
    return [name for name, _ in branch_of(BRANCHED, wanted, "plan.json")]


def test_outcomes_choose_a_branch_and_fewer_of_them_its_beginning():
    assert names("false,blue") == ["n0", "n1", "n2", "n3"]
    assert names("false, red") == ["n0", "n1", "n3"]
    assert names("true") == ["n0", "n2", "n3"]


def test_a_node_chooses_the_shortest_branch_through_it():
    assert names("n2") == ["n0", "n2", "n3"]


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ("n9", "nodes are n0 to n3"),
        ("treu", 'did you mean "true"'),
        ("false,blu", 'did you mean "blue"'),
        ("false,red,red", "nothing is left to observe"),
    ],
)
def test_a_branch_that_is_not_there_is_one_message_with_a_remedy(wanted, said):
    with pytest.raises(InputError) as error:
        names(wanted)
    assert said in str(error.value) and len(error.value.diagnostics) == 1


def test_what_is_taken_moves_with_the_hand_and_stays_where_it_is_let_go(tmp_path):
    scene = load_scene(table_and_arm(tmp_path))
    turn = Segment("arm", ("turn",), ((0.0,), (1.0,)), (0.0, 2.0), "move", attach=(("cup", "arm.hand"),))
    back = Segment("arm", ("turn",), ((1.0,), (0.4,)), (2.0, 4.0), "move", detach=("cup",))
    start = StateChange(
        {"arm": {"turn": 0.0}}, {"cup": ObjectPose("world", (0.3, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))}
    )
    shown = Plan(
        "shown",
        {},
        {},
        "n0",
        {"n0": Node("action", "carry", motion=(turn, back), next="n1"), "n1": Node("goal")},
        start,
    )
    film = Film(shown, scene, branch_of(shown, None, "plan.json"))
    assert film.at("n0", 1.0).robots["arm"] == (0.5,)
    taken = film.at("n0", 2.0)
    before, after = (world_T(scene, state, "cup") for state in (taken, film.at("n0", 3.0)))
    hand = [world_T(scene, state, "arm.hand") for state in (taken, film.at("n0", 3.0))]
    assert taken.objects["cup"].parent == "arm.hand"
    assert np.allclose(before, world_T(scene, film.start, "cup"), atol=1e-8)  # it does not jump into the hand
    assert np.allclose(np.linalg.inv(hand[0]) @ before, np.linalg.inv(hand[1]) @ after, atol=1e-8)
    assert not np.allclose(before, after)
    assert film.end.objects["cup"].parent == "world" and np.allclose(
        world_T(scene, film.end, "cup"), world_T(scene, film.at("n0", 3.999999), "cup"), atol=1e-5
    )


def test_a_node_that_begins_early_moves_while_the_one_before_it_ends(tmp_path):
    table_and_arm(tmp_path)
    text, own = (tmp_path / "scene.yaml").read_text(), "  arm: {urdf: arm.urdf, base: {position: [0, 0, 0.1]}}\n"
    other = own.replace("arm:", "other:").replace("[0, 0,", "[0, 2,")
    (tmp_path / "scene.yaml").write_text(text.replace(own, own + other))
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    first = Segment("arm", ("turn",), ((0.0,), (1.0,)), (0.0, 2.0), "move")
    second = Segment("other", ("turn",), ((0.0,), (1.5,)), (0.0, 3.0), "move")
    nodes = {
        "n0": Node("action", "one", motion=(first,), next="n1"),
        "n1": Node("action", "two", motion=(second,), overlap=0.5, next="n2"),
        "n2": Node("goal"),
    }
    film = Film(plan(**nodes), scene, [("n0", None), ("n1", None), ("n2", None)])
    told = [
        (each.node, each.time, *each.state.robots["arm"], *each.state.robots["other"])
        for each in film.frames(0.25)
    ]
    assert ("n0", 1.5, 0.75, 0.0) in told and ("n0", 1.75, 0.875, 0.125) in told and ("n0", 2.0, 1.0, 0.25) in told
    assert [row for row in told if row[0] == "n1"][0] == ("n1", 0.5, 1.0, 0.25) and told[-1] == (
        "n1",
        3.0,
        1.0,
        1.5,
    )
    assert [frame.state.robots["other"] for frame in film.key_frames()] == [(0.0,), (0.25,), (1.5,)]


def test_what_a_hand_gives_stays_in_the_hand_that_has_taken_it(tmp_path):
    problem = giving_gantries(tmp_path)
    plan = solve(problem).plan
    assert plan is not None and problem.scene is not None
    film = Film(plan, load_scene(problem.scene), branch_of(plan, None, "plan.json"))
    given = plan.nodes["n1"].motion
    opened = next(segment.times[-1] for segment in given if segment.detach)
    assert opened < given[-1].times[-1]
    assert film.at("n1", opened - 0.1).objects["rod"].parent == "other.hand"
    assert film.at("n1", opened + 0.1).objects["rod"].parent == "other.hand"
