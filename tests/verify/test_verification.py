"""A right plan is verified; every way of spoiling it is caught, and the finding names what is wrong."""

import json
import math
import re
from dataclasses import replace

from kabo.language import load_problem
from kabo.plan import Node, ObjectPose, PlanBuilder, Segment, StateChange
from kabo.verify import Report, verify_plan
from tests.verify import counter as by_hand


def found(report: Report, pattern: str, node: str | None = None) -> None:
    """Some finding says this, and stands at this node."""
    assert not report.ok
    text = str(report)
    places = [f.node for f in report.findings if re.search(pattern, f.message)]
    assert places, f"no finding says {pattern!r}:\n{text}"
    assert node is None or node in places, f"{pattern!r} stands at {places}, not at {node}:\n{text}"


def test_a_right_plan_is_verified(counter):
    report = verify_plan(counter.problem, counter.plan)
    assert report.ok, str(report)
    assert (report.leaves, report.branches, report.motions) == (2, 1, 5)
    assert report.pairs > 100 and report.least is not None and 0 < report.least.distance < 0.03
    assert json.loads(json.dumps(report.to_dict()))["ok"] is True


# ------------------------------------------------------------------------------------------------ collisions
def test_a_body_that_tunnels_through_a_thin_plate_between_two_way_points_is_caught(counter):
    direct = by_hand.carry("place", None)[0]
    waypoints = (by_hand.WEIGH, by_hand.at(-0.3, -0.6), by_hand.at(0.3, -0.6), by_hand.at(0.3, by_hand.HIGH))
    times = tuple(2.0 * i for i in range(4))
    first = replace(direct, waypoints=waypoints, times=times)
    rest = by_hand.carry("place", None)[1]
    rest = replace(rest, times=tuple(t + 7.0 for t in rest.times))
    plan = counter.with_node("put", motion=by_hand.let_go("place", (first, rest)))
    report = verify_plan(counter.problem, plan)
    found(report, "mug and plate collide|plate and mug collide", counter.node("put"))
    finding = next(f for f in report.findings if set(f.bodies) == {"mug", "plate"})
    assert 2.0 < finding.time < 4.0


def test_a_way_point_inside_an_obstacle_is_caught(counter):
    waypoints = (by_hand.HOME, (-0.3, 0.3, -0.7, 0.0), by_hand.at(-0.3, -0.7))
    plan = counter.with_segment("take", 0, waypoints=waypoints, times=(0.0, 1.0, 2.0))
    report = verify_plan(counter.problem, plan)
    found(report, "bin", counter.node("take"))


def test_a_body_that_begins_wholly_inside_another_is_caught(tmp_path):
    scene = by_hand.SCENE.replace(
        "  mug:\n", "  crate: {box: [1.9, 1.9, 1.9], pose: {position: [0, 0, 1.2]}}\n  mug:\n"
    )
    path = by_hand.write_counter(tmp_path)
    (tmp_path / "scene.yaml").write_text(scene)
    problem = load_problem(path)
    report = verify_plan(problem, by_hand.build(problem))
    found(report, "one lies inside the other")


def test_another_robot_in_the_way_is_caught(tmp_path):
    path = by_hand.write_counter(tmp_path)
    (tmp_path / "scene.yaml").write_text(by_hand.SCENE.replace("[0.3, 0.45, 0.5]", "[0.2, 0, 0.5]"))
    problem = load_problem(path)
    report = verify_plan(problem, by_hand.build(problem))
    found(report, "gate.bar")


def test_fingers_that_pass_through_the_cup_while_they_approach_are_caught_even_if_permitted(counter):
    narrow = replace(counter.plan.start, robots={**counter.plan.start.robots})
    motion = by_hand.motion(
        "pick",
        ([(0.045,), (0.015,)], "open", {}),
        ([by_hand.HOME, by_hand.at(-0.3, -0.7)], "reach", {}),
        (
            [by_hand.at(-0.3, -0.7), by_hand.at(-0.3, by_hand.LOW)],
            "approach",
            {"allowed_contacts": by_hand.FINGERS},
        ),
        ([(0.015,), (0.02,)], "close", {"attach": (("mug", "arm.palm"),), "allowed_contacts": by_hand.FINGERS}),
    )
    plan = replace(counter.with_node("take", motion=motion), start=narrow)
    found(verify_plan(counter.problem, plan), "arm.left and mug collide", counter.node("take"))


def test_an_object_that_is_pressed_into_its_support_is_caught_although_contact_is_permitted(counter):
    low, high = by_hand.at(-0.3, by_hand.LOW), by_hand.at(-0.3, by_hand.HIGH)
    lift = (low, by_hand.at(-0.3, by_hand.LOW - 0.008), high)
    plan = counter.with_segment("take", 3, waypoints=lift, times=(3.0, 3.5, 4.0))
    found(verify_plan(counter.problem, plan), "mug and table collide", counter.node("take"))


# -------------------------------------------------------------------------------------------------- contacts
def test_an_extra_permitted_contact_is_caught(counter):
    plan = counter.with_segment("weigh", 0, allowed_contacts=(*by_hand.FINGERS, ("arm.palm", "plate")))
    found(verify_plan(counter.problem, plan), "permits contact of arm.palm and plate", counter.node("weigh"))


def test_contact_with_the_support_is_permitted_only_where_the_object_stands(counter):
    plan = counter.with_segment("weigh", 0, allowed_contacts=by_hand.FINGERS + by_hand.MUG_TABLE)
    found(verify_plan(counter.problem, plan), "permits contact of mug and table", counter.node("weigh"))


# ------------------------------------------------------------------------------------------- what moves, how
def test_a_jump_between_two_segments_is_caught(counter):
    waypoints = (by_hand.at(-0.3, -0.69), by_hand.at(-0.3, by_hand.LOW))
    plan = counter.with_segment("take", 1, waypoints=waypoints)
    found(verify_plan(counter.problem, plan), "jumps: z of arm", counter.node("take"))


def test_a_jump_between_two_actions_is_caught(counter):
    segment = counter.plan.nodes[counter.node("weigh")].motion[0]
    plan = counter.with_segment("weigh", 0, waypoints=(by_hand.at(-0.31, by_hand.HIGH), segment.waypoints[1]))
    found(verify_plan(counter.problem, plan), "jumps: x of arm", counter.node("weigh"))


def test_too_high_a_velocity_is_caught(counter):
    plan = counter.with_segment("weigh", 0, times=(0.0, 0.3))
    found(verify_plan(counter.problem, plan), "z of arm moves at .* its limit is 1", counter.node("weigh"))


def test_times_that_run_backwards_are_caught(counter):
    plan = counter.with_segment("weigh", 0, times=(1.0, 1.0))
    found(verify_plan(counter.problem, plan), "times do not increase", counter.node("weigh"))


def test_segments_that_overlap_in_time_are_caught(counter):
    segment = counter.plan.nodes[counter.node("take")].motion[1]
    plan = counter.with_segment("take", 1, times=tuple(t - 0.5 for t in segment.times))
    found(verify_plan(counter.problem, plan), "begins before the one before it has ended", counter.node("take"))


def test_a_joint_beyond_its_limit_is_caught(counter):
    end = (-0.3, 0.0, 0.02, 0.0)
    plan = counter.with_segment(
        "weigh", 0, waypoints=(by_hand.at(-0.3, by_hand.HIGH), end, by_hand.WEIGH), times=(0, 2, 4)
    )
    found(verify_plan(counter.problem, plan), "z of arm is at 0.02, beyond its limit", counter.node("weigh"))


def test_a_robot_that_the_arguments_do_not_name_may_not_move(counter):
    segment = counter.plan.nodes[counter.node("weigh")].motion[0]
    swing = replace(segment, robot="gate", joints=("swing",), waypoints=((0.0,), (0.1,)), allowed_contacts=())
    plan = counter.with_node("weigh", motion=(*counter.plan.nodes[counter.node("weigh")].motion, swing))
    found(verify_plan(counter.problem, plan), "moves gate, which it does not name", counter.node("weigh"))


def test_a_segment_with_half_of_the_joints_is_caught(counter):
    plan = counter.with_segment("weigh", 0, joints=("x", "y"), waypoints=((-0.3, 0.0), (-0.3, 0.1)))
    found(
        verify_plan(counter.problem, plan), "neither its planned joints nor its gripper's", counter.node("weigh")
    )


def test_an_action_with_geometry_and_no_motion_is_refused(counter):
    for action in ("take", "put", "weigh"):
        plan = counter.with_node(action, motion=(), after=None)
        found(verify_plan(counter.problem, plan), "has no motion", counter.node(action))


# -------------------------------------------------------------------------------------- taking, keeping, ending
def test_taking_at_a_wrong_pose_is_caught(counter):
    high = by_hand.at(-0.3, by_hand.LOW + 0.02)
    motion = by_hand.motion(
        "pick",
        ([by_hand.HOME, high], "reach", {}),
        ([(0.045,), (0.02,)], "close", {"attach": (("mug", "arm.palm"),), "allowed_contacts": by_hand.FINGERS}),
        (
            [high, by_hand.at(-0.3, by_hand.HIGH)],
            "lift",
            {"allowed_contacts": by_hand.FINGERS + by_hand.MUG_TABLE},
        ),
    )
    plan = counter.with_node("take", motion=motion)
    found(
        verify_plan(counter.problem, plan),
        r"not taken as any.*top: coincident.* missed by 20 mm",
        counter.node("take"),
    )


def test_fingers_that_do_not_close_are_caught(counter):
    plan = counter.with_segment("take", 2, waypoints=((0.045,), (0.03,)))
    found(verify_plan(counter.problem, plan), "finger is at 0.03, not 0.02", counter.node("take"))


def test_a_cup_that_is_tilted_on_the_way_is_caught(counter):
    waypoints = (
        by_hand.WEIGH,
        (0.0, 0.0, by_hand.OVER, 0.2),
        by_hand.at(0.3, by_hand.OVER),
        by_hand.at(0.3, by_hand.HIGH),
    )
    plan = counter.with_segment("carry", 0, waypoints=waypoints, times=(0.0, 0.7, 1.4, 2.3))
    report = verify_plan(counter.problem, plan)
    found(report, r"upright: angle\(this.up, world.up\) is missed by", counter.node("carry"))


def test_a_cup_tilted_a_hair_beyond_its_bound_is_caught_and_one_within_it_is_not(counter):
    for degrees, fine in ((10.0, True), (10.2, False)):
        tilted = (0.0, 0.0, by_hand.OVER, math.radians(degrees))
        waypoints = (by_hand.WEIGH, tilted, by_hand.at(0.3, by_hand.OVER), by_hand.at(0.3, by_hand.HIGH))
        plan = counter.with_segment("carry", 0, waypoints=waypoints, times=(0.0, 0.6, 1.2, 2.0))
        assert verify_plan(counter.problem, plan).ok is fine


def test_a_motion_that_must_keep_a_constraint_and_does_not_name_it_is_caught(counter):
    plan = counter.with_segment("carry", 0, constraint=None)
    found(verify_plan(counter.problem, plan), "must keep upright", counter.node("carry"))


def test_putting_down_beside_the_region_is_caught(counter):
    def beside(segment):
        moved = tuple((q[0] - 0.08, *q[1:]) if q[0] == 0.3 else q for q in segment.waypoints)
        return replace(segment, waypoints=moved)

    motion = tuple(beside(s) if len(s.joints) == 4 else s for s in counter.plan.nodes[counter.node("put")].motion)
    after = by_hand.change(
        by_hand.at(0.22, by_hand.OVER), 0.045, replace(by_hand.SERVED, position=(0.22, 0.0, 0.05))
    )
    plan = counter.with_node("put", motion=motion, after=after)
    found(verify_plan(counter.problem, plan), "mug ends outside of tray, by 40 mm", counter.node("put"))


def test_letting_go_in_the_air_is_caught(counter):
    motion = list(counter.plan.nodes[counter.node("put")].motion)
    motion = [motion[0], replace(motion[2], times=(4.0, 4.5)), motion[3]]
    motion[2] = replace(motion[2], waypoints=(by_hand.at(0.3, by_hand.HIGH), by_hand.at(0.3, by_hand.OVER)))
    plan = counter.with_node("put", motion=tuple(motion))
    found(verify_plan(counter.problem, plan), "not put down as any of its placements", counter.node("put"))


def test_letting_go_with_the_hand_still_closed_is_caught(counter):
    plan = counter.with_segment("put", 2, waypoints=((0.02,), (0.021,)))
    found(verify_plan(counter.problem, plan), "lets go while finger is not open", counter.node("put"))


def test_a_transfer_that_lets_go_is_caught(counter):
    plan = counter.with_segment("carry", 1, detach=("mug",))
    found(verify_plan(counter.problem, plan), "detaches mug, which it may not", counter.node("carry"))


def test_a_transfer_that_stops_before_it_stands_is_caught(counter):
    motion = counter.plan.nodes[counter.node("carry")].motion[:1]
    plan = counter.with_node("carry", motion=motion, after=by_hand.change(by_hand.at(0.3, by_hand.HIGH), 0.02))
    found(verify_plan(counter.problem, plan), "not put down as any of its placements", counter.node("carry"))


def test_weighing_elsewhere_is_caught(counter):
    plan = counter.with_segment("weigh", 0, waypoints=(by_hand.at(-0.3, by_hand.HIGH), by_hand.at(-0.3, -0.35)))
    found(verify_plan(counter.problem, plan), "does not end in the configuration weigh", counter.node("weigh"))


# ------------------------------------------------------------------------------------------------- states
def test_a_recorded_state_that_is_not_the_motion_s_is_caught(counter):
    wrong = by_hand.change(by_hand.at(-0.3, by_hand.HIGH + 0.001), 0.02, by_hand.HELD)
    found(
        verify_plan(counter.problem, counter.with_node("take", after=wrong)),
        "records z of arm",
        counter.node("take"),
    )
    wrong = by_hand.change(
        by_hand.at(-0.3, by_hand.HIGH), 0.02, replace(by_hand.HELD, position=(0.0, 0.0, -0.1101))
    )
    found(
        verify_plan(counter.problem, counter.with_node("take", after=wrong)), "records mug", counter.node("take")
    )
    wrong = by_hand.change(by_hand.at(-0.3, by_hand.HIGH), 0.02)
    found(verify_plan(counter.problem, counter.with_node("take", after=wrong)), "does not record where mug", None)


def test_a_recorded_change_that_nothing_makes_is_caught(counter):
    after = by_hand.change(by_hand.WEIGH, 0.02, by_hand.SERVED)
    found(verify_plan(counter.problem, counter.with_node("weigh", after=after)), "records a change of mug", None)
    after = StateChange({**by_hand.change(by_hand.WEIGH, 0.02).robots, "gate": {"swing": 1.0}})
    found(verify_plan(counter.problem, counter.with_node("weigh", after=after)), "records a change of gate", None)


def test_a_start_that_is_not_the_scene_s_is_caught(counter):
    start = counter.plan.start
    moved = ObjectPose("world", (-0.3, 0.01, 0.05), (0.0, 0.0, 0.0, 1.0))
    plan = replace(counter.plan, start=replace(start, objects={"mug": moved}))
    found(verify_plan(counter.problem, plan), "start: mug is not where the scene puts it")
    plan = replace(counter.plan, start=replace(start, robots={**start.robots, "gate": {"swing": 0.5}}))
    found(verify_plan(counter.problem, plan), "start: gate does not begin")
    plan = replace(counter.plan, start=replace(start, objects={}))
    found(verify_plan(counter.problem, plan), "start: mug is missing")


def test_a_component_that_a_motion_moves_has_one_value_only(counter):
    """`let_go` also follows `put`: there the arm can then be in two configurations."""
    put = replace(counter.plan.nodes[counter.node("put")], next=counter.node("let_go"))
    plan = replace(counter.plan, nodes={**counter.plan.nodes, counter.node("put"): put})
    found(verify_plan(counter.problem, plan), "arm can be in 2 different states here", counter.node("let_go"))


def swung_gate(plan):
    """The plan, but the gate is swung before it if the sun shines: everything after finds it in two places."""
    swing = Segment("gate", ("swing",), ((0.0,), (-1.57,)), (0.0, 2.0), "move")
    after = StateChange({"gate": {"swing": -1.57}})
    builder, handles = PlanBuilder(), {}
    for name in sorted(plan.nodes, key=lambda n: int(n[1:]), reverse=True):
        node = plan.nodes[name]
        following = {o: handles[n] for o, n in node.branches.items()}
        handles[name] = builder.add(replace(node, next=handles.get(node.next), branches=following))
    moved = Node("action", "swing", {"r": "gate"}, next=handles["n0"], motion=(swing,), after=after)
    branches = {"true": builder.add(moved), "false": handles["n0"]}
    root = builder.add(Node("sense", "look", {"r": "gate"}, on="sunny(gate)", branches=branches))
    values = {"problem": plan.problem, "files": plan.files, "options": plan.options, "start": plan.start}
    return builder.build(root, **values)


def test_motions_are_verified_against_every_place_where_another_component_can_be(tmp_path):
    """Branches meet again while the gate is open in one and closed in the other."""
    path = by_hand.write_counter(tmp_path)
    report = verify_plan(load_problem(path), swung_gate(by_hand.build(load_problem(path))))
    assert report.ok and (report.leaves, report.motions) == (4, 6), str(report)
    (tmp_path / "scene.yaml").write_text(by_hand.SCENE.replace("[0.3, 0.45, 0.5]", "[0.3, 0.3, 0.5]"))
    problem = load_problem(path)
    plan = by_hand.build(problem)
    assert verify_plan(problem, plan).ok  # a closed gate is out of the way
    report = verify_plan(problem, swung_gate(plan))
    assert not report.ok and all("gate.bar" in f.bodies for f in report.findings), str(report)


def test_a_robot_that_can_be_in_two_places_may_not_be_moved(counter):
    """The same gate, moved again after the branches have met."""
    plan = swung_gate(counter.plan)
    take = next(name for name, node in plan.nodes.items() if node.action == "take")
    again = Segment("gate", ("swing",), ((-1.57,), (0.0,)), (0.0, 2.0), "move")
    last = Node(
        "action", "swing", {"r": "gate"}, next=take, motion=(again,), after=StateChange({"gate": {"swing": 0.0}})
    )
    nodes = {**plan.nodes, "n50": last}
    first = plan.nodes["n0"]
    swung = next(n for n, node in plan.nodes.items() if node.action == "swing")
    nodes |= {
        "n0": replace(first, branches={**first.branches, "false": "n50"}),
        swung: replace(nodes[swung], next="n50"),
    }
    found(
        verify_plan(counter.problem, replace(plan, nodes=nodes)), "gate can be in 2 different states here", "n50"
    )


# ------------------------------------------------------------------------------------------ files, geometry none
def test_a_plan_for_other_files_is_verified_and_says_so(counter):
    files = {**counter.plan.files, "scene.yaml": "sha256:" + "0" * 64}
    report = verify_plan(counter.problem, replace(counter.plan, files=files))
    found(report, "made for other files: scene.yaml has changed since")
    assert report.motions == 5 and len(report.findings) == 1
    files = {name: digest for name, digest in counter.plan.files.items() if name != "gantry.urdf"}
    found(verify_plan(counter.problem, replace(counter.plan, files=files)), "gantry.urdf is not recorded")
    files = {**counter.plan.files, "gone.stl": "sha256:" + "0" * 64}
    found(verify_plan(counter.problem, replace(counter.plan, files=files)), "gone.stl does not exist")


def test_a_plan_without_geometry_is_verified_only_on_the_knowledge_level(counter):
    nodes = {name: replace(node, motion=(), after=None) for name, node in counter.plan.nodes.items()}
    plan = replace(counter.plan, nodes=nodes, start=None)
    found(verify_plan(counter.problem, plan), "use --knowledge-only")
    report = verify_plan(counter.problem, plan, knowledge_only=True)
    assert report.ok and "--geometry none" in str(report)
    report = verify_plan(counter.problem, counter.plan, knowledge_only=True)
    assert report.ok and "only the knowledge was verified" in str(report)


# ---------------------------------------------------------------------------------------------------- knowledge
def test_swapped_branches_are_caught(counter):
    branches = counter.plan.nodes[counter.node("weigh")].branches
    plan = counter.with_node("weigh", branches={"true": branches["false"], "false": branches["true"]})
    report = verify_plan(counter.problem, plan, knowledge_only=True)
    found(report, 'precondition 2 of "put" does not hold', counter.node("put"))
    found(report, 'precondition 2 of "carry" does not hold', counter.node("carry"))


def test_a_missing_branch_is_caught(counter):
    branches = counter.plan.nodes[counter.node("weigh")].branches
    plan = counter.with_node("weigh", branches={"true": branches["true"]})
    found(verify_plan(counter.problem, plan), r"no branch for full\(mug\) = false", counter.node("weigh"))


def test_a_goal_that_comes_early_is_caught(counter):
    goal = counter.plan.nodes[counter.node("put")].next
    plan = counter.with_node("carry", next=goal)
    found(verify_plan(counter.problem, plan), "the goal does not hold at this leaf", goal)


def test_branching_on_what_was_not_sensed_is_caught(counter):
    plan = counter.with_node("weigh", on="holding(arm, mug)")
    found(verify_plan(counter.problem, plan), r'"weigh" does not sense holding\(arm, mug\)', counter.node("weigh"))


def test_a_plan_that_runs_in_a_circle_is_caught(counter):
    plan = counter.with_node("put", next=counter.node("weigh"))
    found(verify_plan(counter.problem, plan), "runs in a circle")


def test_nodes_that_nothing_reaches_and_successors_that_do_not_exist_are_caught(counter):
    plan = replace(counter.plan, nodes={**counter.plan.nodes, "n99": Node("goal")})
    found(verify_plan(counter.problem, plan), "no way leads to this node", "n99")
    found(
        verify_plan(counter.problem, counter.with_node("put", next="n77")),
        "n77, which is no node",
        counter.node("put"),
    )


def test_unknown_actions_and_wrong_arguments_are_caught(counter):
    cases = [
        ({"action": "tak"}, 'unknown action "tak"; did you mean "take"'),
        ({"arguments": {"r": "arm"}}, 'argument "c" of action "take" is missing'),
        ({"arguments": {"r": "arm", "c": "tray"}}, "tray is no cup"),
        ({"arguments": {"r": "arm", "c": "mug", "k": "mug"}}, 'has no parameter "k"'),
    ]
    for changes, text in cases:
        name = counter.node("take")
        nodes = {**counter.plan.nodes, name: replace(counter.plan.nodes[name], **changes)}
        found(verify_plan(counter.problem, replace(counter.plan, nodes=nodes)), text, name)
