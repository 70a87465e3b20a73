"""Messages of ROS 2: the plan's own polynomials, whole nanoseconds, the schema, the bytes that rosbags reads."""

import jsonschema
import numpy as np
import pytest
import zenoh
from scipy.interpolate import BPoly

from kabo.exporting import key_of_topic, put_trajectory, ros_trajectories
from kabo.plan import Plan, schema
from tests.exporting.conftest import close
from tests.support import export_readers as readers


def test_an_arm_that_passes_a_border_of_segments_gets_one_message(moving: Plan) -> None:
    arm, hand = ros_trajectories(moving, node="n0")
    assert (arm.joints, hand.joints) == (("a_1", "a_2"), ("finger",))
    assert arm.points[-1].nanoseconds == 2_000_000_000 and "then cup is held by left.hand" in hand.note


def test_polynomials_between_points_are_the_plans_own(moving: Plan) -> None:
    arm = ros_trajectories(moving, node="n0")[0]
    times = [point.nanoseconds * 1e-9 for point in arm.points]
    ends = [[*zip(point.positions, point.velocities, point.accelerations, strict=True)][0] for point in arm.points]
    spline = BPoly.from_derivatives(times, ends)
    first, second, _ = moving.nodes["n0"].motion
    t = np.linspace(0.0, 2.0, 101)
    assert close(spline(t), first.trajectory.joined(second.trajectory).at(t)[:, 0])


def test_nodes_that_move_at_once_begin_on_one_clock(moving: Plan) -> None:
    begins = {each.nodes: each.begin for each in ros_trajectories(moving, branch="false")}
    assert begins[("n3",)] == 3.5 and begins[("n4",)] == 3.5  # n3 ends at 4 s, and n4 begins half a second before
    assert [each.nodes for each in ros_trajectories(moving, node="n3")][-1] == ("n4",)


@pytest.mark.parametrize("kind", ["trajectory", "moveit"])
def test_bytes_and_yaml_fit_the_schema_and_what_rosbags_reads(moving: Plan, kind: str) -> None:
    for message in ros_trajectories(moving, kind, branch="true", rate=125.0):
        (body,) = readers.documents(message.to_yaml())
        name = {"trajectory": "joint-trajectory-1", "moveit": "robot-trajectory-1"}[kind]
        jsonschema.validate(body, schema(name))
        assert readers.bytes_of_rosbags(body, message.ros_type) == message.to_cdr()
        read = readers.message_of_rosbags(message.to_cdr(), message.ros_type)
        motion = read if kind == "trajectory" else read.joint_trajectory
        assert tuple(motion.joint_names) == message.joints
        assert tuple(motion.points[-1].positions) == message.points[-1].positions


def test_a_message_arrives_on_the_key_that_the_bridge_maps(moving: Plan) -> None:
    config = zenoh.Config.from_json5('{mode: "peer", scouting: {multicast: {enabled: false}}}')
    message = ros_trajectories(moving, node="n0")[0]
    with zenoh.open(config) as session:
        subscriber = session.declare_subscriber("**")
        put_trajectory(session, "/arm_controller/joint_trajectory", message, namespace="/robot_1")
        put_trajectory(session, "/arm_controller/joint_trajectory", message)
        sample, other = (
            subscriber.recv(),
            subscriber.recv(),
        )  # the reader's queue: a callback runs in its own thread
    assert str(sample.key_expr) == "robot_1/arm_controller/joint_trajectory"
    assert str(other.key_expr) == "arm_controller/joint_trajectory"
    read = readers.message_of_rosbags(sample.payload.to_bytes(), "trajectory_msgs/msg/JointTrajectory")
    assert tuple(read.joint_names) == message.joints and len(read.points) == len(message.points)


@pytest.mark.parametrize("topic", ["arm/joint_trajectory", "/arm//x", "/arm/*", "/1arm", "/", ""])
def test_what_is_no_full_name_of_ros_is_no_key(topic: str) -> None:
    with pytest.raises(ValueError, match="is no full name of ROS"):
        key_of_topic(topic)
