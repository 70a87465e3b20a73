"""Procedures are tasks: pure, in order of their streams whatever the start, and clear about why not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.geometry.bounding.cover_tree import CoverTree
from kabo.geometry_server import Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.language.yaml.procedures import TASK_LIBRARY
from kabo.scene import link_poses, world_T
from kabo.tasks.procedures import GeometricProcedures

BARTENDER, STACKED, FORCE = "bartender/four_bottles.yaml", "stacked/n2.yaml", "force_sensing/n2.yaml"
Servers = Callable[..., GeometricProcedures]


def call(procedure: str, *arguments: str, **options: str) -> GroundCall:
    return GroundCall(procedure, arguments, tuple(sorted(options.items())))


def run(server: GeometricProcedures, *calls: GroundCall) -> Situation:
    situation = Situation.of(server.scene.start)
    for each in calls:
        answer = server.call(each, situation)
        assert isinstance(answer, Success), answer
        situation = situation.replace(answer.changes)
    return situation


PICK = call("pick", "right", "bottle_4")
PLACE = call("place", "right", "bottle_4", "dishwasher")


def test_a_procedure_is_a_pure_function_of_its_arguments_state_and_seed(server: Servers) -> None:
    start = Situation.of(server(BARTENDER).scene.start)
    answers = [server(BARTENDER, seed=3).call(PICK, start) for _ in range(2)]
    assert answers[0] == answers[1]
    busy = server(BARTENDER, seed=3)
    busy.call(call("pick", "left", "bottle_1"), start)
    assert busy.call(PICK, start) == answers[0], "what was asked before must not matter"
    assert server(BARTENDER, seed=4).call(PICK, start) != answers[0]


def test_the_object_is_in_the_hand_after_a_pick_and_does_not_jump(server: Servers) -> None:
    asked = server(BARTENDER)
    situation = run(asked, PICK)
    held = situation.attachment("bottle_4")
    assert held.parent == "right.tool0"
    pick = asked.call(PICK, Situation.of(asked.scene.start))
    assert isinstance(pick, Success)
    closing = next(s for s in pick.motion if s.attach)
    approach = next(s for s in pick.motion if s.stage == "grasp/approach")
    q = (*approach.waypoints[-1], *closing.waypoints[-1])
    robot = asked.scene.robots["right"]
    before = world_T(asked.scene, asked.scene.start, "bottle_4")
    from kabo.scene.transforms import transform

    after = link_poses(robot, q)["tool0"] @ transform(held.position, held.quaternion)
    assert after == pytest.approx(before, abs=1e-8)


def test_segments_follow_each_other_without_a_gap(server: Servers) -> None:
    asked = server(BARTENDER)
    start = asked.scene.start
    q = dict(zip(asked.scene.robots["right"].joint_names, start.robots["right"], strict=True))
    situation = Situation.of(start)
    for each in (PICK, PLACE):
        answer = asked.call(each, situation)
        assert isinstance(answer, Success)
        time = 0.0
        for segment in answer.motion:
            assert segment.waypoints[0] == tuple(q[j] for j in segment.joints)
            assert segment.times[0] == pytest.approx(time)
            assert np.all(np.diff(segment.times) > 0.0)
            q.update(zip(segment.joints, segment.waypoints[-1], strict=True))
            time = segment.times[-1]
        situation = situation.replace(answer.changes)
        assert situation.configuration("right") == tuple(q.values())


def test_the_same_grasp_is_found_from_any_start(server: Servers) -> None:
    """The law of [docs/reference/plans.md#sharing]: streams are keyed by what is sampled, not by where robots start."""
    asked = server(BARTENDER)
    from_home = run(asked, PICK)
    elsewhere = run(asked, call("pick", "right", "bottle_3"), call("place", "right", "bottle_3", "anywhere"))
    answer = asked.call(PICK, elsewhere)
    assert isinstance(answer, Success)
    assert answer.changes["bottle_4"] == from_home.attachment("bottle_4")
    assert answer.changes["right"] == from_home.configuration("right")


def test_asked_again_a_procedure_gives_another_answer(server: Servers) -> None:
    asked = server(BARTENDER)
    start = Situation.of(asked.scene.start)
    first, second = (asked.call(PICK, start, attempt) for attempt in (0, 1))
    assert isinstance(first, Success) and isinstance(second, Success)
    assert first.changes["bottle_4"] != second.changes["bottle_4"]


def test_what_is_out_of_reach_is_a_proof_that_says_how_far(server: Servers) -> None:
    asked = server(BARTENDER)
    failure = asked.call(call("pick", "right", "bottle_1"), Situation.of(asked.scene.start))
    assert isinstance(failure, Refusal)
    assert (failure.reason, failure.proof, failure.reads) == ("out_of_reach", True, frozenset({"bottle_1"}))
    assert failure.missing is not None and 0.0 < failure.missing < 1.0
    assert "right" in failure.comment and "bottle_1" in failure.comment


def test_a_region_out_of_reach_is_foreseen_whatever_the_hold(server: Servers) -> None:
    failure = server(BARTENDER).refuted(call("place", "left", "bottle_1", "dishwasher"))
    assert failure is not None
    assert failure.proof
    assert not failure.reads


def test_what_nothing_speaks_against_is_not_refuted(server: Servers) -> None:
    asked = server(BARTENDER)
    assert asked.refuted(PICK) is None
    assert asked.refuted(PLACE) is None


def test_several_values_are_answered_for_at_once(server: Servers) -> None:
    asked = server(BARTENDER)
    start = Situation.of(asked.scene.start)
    moved = run(asked, call("pick", "left", "bottle_1"), call("place", "left", "bottle_1", "anywhere"))
    both = start.union(moved).replace({"left": start.configuration("left")})
    assert len(both.values("bottle_1")) == 2
    answer = asked.call(PICK, both)
    assert isinstance(answer, Success)
    for segment in answer.motion:
        assert segment.robot == "right"


def test_a_transfer_ends_standing_and_held_and_release_lets_go(server: Servers) -> None:
    asked = server(FORCE)
    calls = [
        call("pick", "arm", "cup_1"),
        call("sense_weight", "arm", "cup_1"),
        call("transfer", "arm", "cup_1", "target", keep="upright"),
    ]
    situation = run(asked, *calls)
    assert situation.attachment("cup_1").parent == "arm.tool0"
    assert asked.server.includes("target", "cup_1", situation.first)
    released = asked.call(call("release", "arm", "cup_1", "target"), situation)
    assert isinstance(released, Success)
    assert asked.server.includes("target", "cup_1", situation.replace(released.changes).first)
    assert not asked.server.includes("target", "cup_1"), "at first it stands elsewhere"


def test_sensing_goes_to_its_configuration_and_keeps_the_constraint(server: Servers) -> None:
    asked = server(FORCE)
    situation = run(asked, call("pick", "arm", "cup_1"), call("sense_weight", "arm", "cup_1"))
    robot = asked.scene.robots["arm"]
    assert situation.configuration("arm")[: robot.planned] == pytest.approx(
        robot.configurations["weigh"], abs=1e-9
    )
    answer = asked.call(call("sense_weight", "arm", "cup_1"), run(asked, call("pick", "arm", "cup_1")))
    assert isinstance(answer, Success)
    carried, held = answer.motion
    assert (carried.constraint, held.stage) == ("upright", "hold still")
    assert held.times[-1] - held.times[0] == pytest.approx(1.0), "the domain's own task weighs for a second"


def test_restack_puts_a_block_on_another_body(server: Servers) -> None:
    asked = server(STACKED)
    start = asked.scene.start
    (name, *_) = [n for n in start.objects if n.startswith("o")]
    top = max(start.objects, key=lambda n: start.objects[n].position[2])
    answer = asked.call(call("restack", "mobile", top, "stack_3"), Situation.of(start))
    assert isinstance(answer, Success)
    at = answer.changes[top]
    pad = asked.scene.fixed_poses["stack_3"][:3, 3]
    assert np.hypot(at.position[0] - pad[0], at.position[1] - pad[1]) < 0.003
    assert {s.procedure for s in answer.motion} == {"restack"}


def test_nothing_is_asked_of_a_robot_that_does_not_hold_the_object(server: Servers) -> None:
    failure = server(BARTENDER).call(PLACE, Situation.of(server(BARTENDER).scene.start))
    assert isinstance(failure, Refusal)
    assert "does not hold" in failure.comment


def test_what_is_found_on_both_sides_but_never_fits_is_said_to_be_so(server: Servers, tmp_path: Path) -> None:
    """Without the permission, carrying ends in a scene other than the one in which the bottle is put down."""
    text = (TASK_LIBRARY / "place.yaml").read_text()
    allow = text[text.index("      - name: allow support") : text.index("      - name: lower")]
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "place.yaml").write_text(text.replace(allow, ""))
    asked = server(BARTENDER)
    held = run(asked, PICK)
    answer = GeometricProcedures(asked.server, tmp_path).call(PLACE, held)
    assert isinstance(answer, Refusal)
    assert "'transfer' found nothing; pairs that never fit: contact of bottle_4" in answer.comment


@pytest.mark.parametrize(
    ("direction", "told"),
    [
        ("{vector: [0, 0]}", '"direction" of "stroke" has a vector that is 3 numbers'),
        ("{vector: [0, 0, 1], frame: nowhere}", "'stroke': "),
    ],
)
def test_an_error_of_a_stage_of_a_domains_own_task_is_told_at_its_place(
    server: Servers, tmp_path: Path, direction: str, told: str
) -> None:
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "stroke.yaml").write_text(
        "name: stroke\nproperties:\n  robot: {type: robot}\nstages:\n  - {name: now, stage: CurrentState}\n"
        f"  - {{name: stroke, stage: MoveRelative, direction: {direction}}}\n"
    )
    asked = GeometricProcedures(server(BARTENDER).server, tmp_path)
    with pytest.raises(InputError) as refused:
        asked.call(call("stroke", "left"), Situation.of(asked.scene.start))
    assert told in str(refused.value)
    assert "stroke.yaml:6:" in str(refused.value)


def test_a_body_that_is_not_movable_is_refused_not_a_defect(server: Servers, tmp_path: Path) -> None:
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "hang.yaml").write_text(
        "name: hang\nproperties:\n  robot: {type: robot}\n  object: {type: body}\nstages:\n"
        "  - {name: now, stage: CurrentState}\n  - {name: hang, stage: Attach, to: <PARENT:robot>}\n"
    )
    asked = GeometricProcedures(server(BARTENDER).server, tmp_path)
    fixed = next(name for name in asked.scene.bodies if name not in asked.scene.movable)
    answer = asked.call(call("hang", "left", fixed), Situation.of(asked.scene.start))
    assert isinstance(answer, Refusal)
    assert f"{fixed} is not movable" in answer.comment
    known = asked.refuted(call("pick", "left", fixed))  # before any sample is drawn
    assert known is not None and known.proof and f"{fixed} is not movable" in known.comment


def test_calls_at_effort_0_divide_no_part(server: Servers, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = server(BARTENDER, epsilon=0.001)
    coarse, fine = (asked.server.context(coarse=each).surroundings for each in (True, False))
    assert coarse.budget.geometry > 4 * fine.budget.geometry and coarse.enclosures is fine.enclosures

    def divide(*_: object) -> None:
        raise AssertionError("a part was divided")

    monkeypatch.setattr(CoverTree, "finer", divide)
    situation = run(asked, PICK, PLACE)
    blocked = asked.call(call("pick", "left", "bottle_4"), situation)
    assert isinstance(blocked, Refusal) or blocked.motion
