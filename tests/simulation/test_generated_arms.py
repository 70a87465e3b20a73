"""Any arm in physics: joints of all kinds, with and without inertias, motors and couplings, keeps to its trajectory.

Arms are drawn; what a URDF leaves out is guessed so that its motors can do what planning asks of them.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

import kabo
from kabo.execution.motions import Motion, Stretch
from kabo.simulation import SimulatedRobot

pytest.importorskip("mujoco")
MEDIAN, MOST = 0.001, 0.003  # [rad or m], of tracking at 1 kHz; the second of 99 %
AXES = ["0 0 1", "0 1 0", "1 0 0", "0.6 0 0.8", "0 -1 0"]
SHAPES = [
    '<box size="0.05 0.05 0.16"/>',
    '<cylinder radius="0.025" length="0.16"/>',
    '<sphere radius="0.04"/>',
]
INERTIA = """<inertial><origin xyz="0 0 0.08"/><mass value="{mass}"/>
    <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>"""
SCENE = """scene: drawn
epsilon: 0.01
robots:
  arm: {{urdf: arm.urdf, base: {{position: [0, 0, 1], rpy: [0, {tilt}, 0]}}, joints: [{joints}]}}
"""


@st.composite
def joints(draw: st.DrawFn) -> tuple[str, float]:
    """A joint with its link as URDF, without their names, and how far it may be sent."""
    kind = draw(st.sampled_from(["revolute", "revolute", "continuous", "prismatic"]))
    reach = 0.1 if kind == "prismatic" else draw(st.sampled_from([0.5, 2.5]))
    effort = draw(st.sampled_from([0.0, 0.5, 20.0, 300.0]))
    mass = (
        draw(st.sampled_from([None, 0.2])) if effort in (0.0, 300.0) else None
    )  # written masses fit their motors
    inertia = "" if mass is None else INERTIA.format(mass=mass, i=0.001)
    shape = f'<collision><origin xyz="0 0 0.08"/><geometry>{draw(st.sampled_from(SHAPES))}</geometry></collision>'
    ends = "" if kind == "continuous" else f'lower="{-reach}" upper="{reach}"'
    velocity = 0.2 if kind == "prismatic" else draw(st.sampled_from([1.0, 3.0]))
    text = f"""<link name="link_@">{inertia}{shape}</link>
  <joint name="joint_@" type="{kind}"><parent link="link_#"/><child link="link_@"/><origin xyz="0 0 0.2"/>
    <axis xyz="{draw(st.sampled_from(AXES))}"/><limit {ends} velocity="{velocity}" effort="{effort}"/></joint>"""
    event(f"{kind}, effort {effort:g}, {'guessed' if mass is None else 'given'}")
    return text, min(reach, 1.0)


@pytest.mark.slow
@settings(max_examples=25)
@given(st.lists(joints(), min_size=1, max_size=5), st.sampled_from([0.0, 1.2]), st.data())
def test_a_drawn_arm_stands_and_keeps_to_a_trajectory(
    drawn: list[tuple[str, float]], tilt: float, data: st.DataObject
) -> None:
    # What a weak motor carries has to be guessed: written masses farther out may be more than it can bear.
    weak = any(f'effort="{effort}"' in text for text, _ in drawn for effort in (0.5, 20.0))
    assume(not weak or not any("<inertial>" in text for text, _ in drawn))
    names = [f"joint_{k + 1}" for k in range(len(drawn))]
    texts = [text.replace("@", str(k + 1)).replace("#", str(k)) for k, (text, _) in enumerate(drawn)]
    goal = [reach * data.draw(st.sampled_from([-0.7, 0.2, 0.8])) for _, reach in drawn]
    with TemporaryDirectory() as folder:
        (Path(folder) / "arm.urdf").write_text(
            f'<robot name="drawn"><link name="link_0"/>{"".join(texts)}</robot>'
        )
        (Path(folder) / "scene.yaml").write_text(SCENE.format(tilt=tilt, joints=", ".join(names)))
        scene = kabo.load_scene(Path(folder) / "scene.yaml")
        try:
            trajectory = kabo.plan_motion(scene, "arm", "start", goal, samples=2000)
        except (kabo.NoMotionError, kabo.InputError):
            event("no way")
            return
    robot = SimulatedRobot(scene)
    assert robot.doubts == ()
    robot.follow(Motion((Stretch("n0", 0, "arm", trajectory),), (), ("n0",), 0.0, trajectory.duration))
    errors = []
    while robot.state().moving:
        robot.wait(0.001)
        wanted = trajectory.at(min(robot.state().motion_time, trajectory.duration))
        errors.append(np.abs(np.array(robot.state().positions["arm"]) - wanted).max())
    event("followed")
    assert np.median(errors) <= MEDIAN and np.percentile(errors, 99) <= MOST
