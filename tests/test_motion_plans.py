"""Motions planned without a domain: limits, rest at both ends, verified plans, reasons a person can act on."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pytest

import kabo
from kabo.errors import InputError
from kabo.geometry_server import GeometryServer
from kabo.motion_plans import Motion, find_motion
from kabo.scene import Attachment, Scene, link_poses, motion_limits, world_T
from kabo.tasks.robots import TaskScene

EXAMPLES = Path(__file__).parents[1] / "examples"
# A box between the two configurations of a Panda: the straight way goes through it.
WALL = """
scene: wall
epsilon: 0.01
packages: {example-robot-data: installed}
robots:
  arm:
    urdf: package://example-robot-data/robots/panda_description/urdf/panda.urdf
    joints: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7]
    configurations:
      home: [-0.8, 0.4, 0, -1.8, 0, 2.2, 0.8]
      there: [0.8, 0.4, 0, -1.8, 0, 2.2, 0.8]
      inside: [0, 0.4, 0, -1.8, 0, 2.2, 0.8]
    allowed_contacts: [[panda_link5, panda_link7], [panda_link5, panda_hand], [panda_leftfinger, panda_rightfinger]]
objects:
  wall: {box: [0.6, 0.05, 1.0], pose: {position: [0.6, 0, 0.5]}}
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    path = tmp_path_factory.mktemp("wall") / "scene.yaml"
    path.write_text(WALL)
    return kabo.load_scene(path)


@pytest.fixture(scope="module")
def motion(scene: Scene) -> Motion:
    return find_motion(scene, "arm", "home", "there", seed=1)


def test_the_way_round_a_wall_is_verified_with_its_certificate(scene: Scene, motion: Motion):
    assert len(motion.trajectory.waypoints) > 2
    plan = motion.plan()
    assert plan.certificate is not None
    found = kabo.verify(scene, plan)
    assert found.ok, found


def test_it_rests_at_both_ends_and_keeps_the_limits(scene: Scene, motion: Motion):
    trajectory, robot = motion.trajectory, scene.robots["arm"]
    limits = motion_limits(robot, robot.planned_joints)
    assert np.allclose(trajectory.at(trajectory.times[0]), robot.configurations["home"], atol=1e-9)
    assert np.allclose(trajectory.at(trajectory.times[-1]), robot.configurations["there"], atol=1e-9)
    samples = trajectory.sampled(1000.0)
    for order, most in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
        assert (np.abs(trajectory.at(samples.times, order)).max(axis=0) <= most * (1 + 1e-6)).all()
    for order in (1, 2):
        assert np.abs(trajectory.at(np.array(trajectory.times)[[0, -1]], order)).max() < 1e-6


def test_the_same_seed_gives_the_same_motion_and_another_another(scene: Scene, motion: Motion):
    assert kabo.plan_motion(scene, "arm", "home", "there", seed=1) == motion.trajectory
    assert kabo.plan_motion(scene, "arm", "home", "there", seed=2) != motion.trajectory


def test_an_end_in_collision_names_the_pair_and_how_deep_it_is(scene: Scene):
    with pytest.raises(InputError, match=r"at the goal arm\.\w+ and wall overlap by up to [\d.]+ mm"):
        kabo.plan_motion(scene, "arm", "home", "inside")


def test_where_no_way_is_found_it_says_what_was_in_the_way(scene: Scene):
    with pytest.raises(kabo.NoMotionError, match="wall"):
        kabo.plan_motion(scene, "arm", "home", "there", samples=1)


def test_values_that_are_not_given_stay_and_limits_are_named(scene: Scene):
    goal = {"panda_joint1": -1.2}
    found = kabo.plan_motion(scene, "arm", "start", goal)
    assert found.waypoints[-1] == (-1.2, *scene.robots["arm"].configurations["home"][1:])
    with pytest.raises(InputError, match="panda_joint1 at 9"):
        kabo.plan_motion(scene, "arm", "start", {"panda_joint1": 9.0})
    with pytest.raises(InputError, match="not finite"):
        kabo.plan_motion(scene, "arm", "start", {"panda_joint1": float("nan")})
    with pytest.raises(InputError, match="no planned joint"):
        kabo.plan_motion(scene, "arm", "start", {"joint1": 0.0})


def test_an_end_that_is_too_near_says_how_much_there_is_and_how_much_is_to_be_kept(tmp_path: Path):
    """What is uncertain is no matter of epsilon, and the message must not blame it."""
    path = tmp_path / "scene.yaml"
    path.write_text(WALL + "uncertain: {wall: 290mm}\n")
    with pytest.raises(InputError) as found:
        kabo.plan_motion(kabo.load_scene(path), "arm", "home", "there")
    (one,) = found.value.diagnostics
    told = re.fullmatch(
        r"at the start arm\.\w+ and wall are ([\d.]+) mm apart, but 290 mm are to be kept", one.message
    )
    assert told is not None, one.message
    assert 0.0 < float(told[1]) < 290.0


def distance_of_meshes(scene: Scene, q: tuple[float, ...], link: str) -> float:
    """How far the mesh of a link is from that of the wall [m], as coal has it; 0 where they touch."""
    arm, wall = scene.robots["arm"], scene.bodies["wall"]
    pose = link_poses(arm, (*q, *scene.start.robots["arm"][len(q) :]))[link]
    placed = []
    for mesh, at in ((arm.links[link].mesh, pose), (wall.mesh, world_T(scene, scene.start, "wall"))):
        assert mesh is not None
        model, corners, faces = coal.BVHModelOBBRSS(), coal.StdVec_Vec3s(), coal.StdVec_Triangle()
        corners.extend(np.array(mesh.vertices))
        faces.extend([coal.Triangle(*map(int, face)) for face in mesh.faces])
        model.beginModel(len(faces), len(corners))
        model.addSubModel(corners, faces)
        model.endModel()
        placed += [model, coal.Transform3s(at[:3, :3].copy(), at[:3, 3].copy())]
    return max(0.0, float(coal.distance(*placed, coal.DistanceRequest(), coal.DistanceResult())))


@pytest.mark.parametrize("kept", [0.0, 0.005])
def test_the_distance_that_an_end_is_told_to_have_is_that_of_the_meshes(scene: Scene, kept: float):
    """It was that of the convex parts, which is less: `overlap by up to 0.4 mm` where 2.8 mm were left."""
    near, *others = scene.robots["arm"].configurations["home"]
    kinds = set()
    for turned in np.linspace(-0.34, -0.1, 100):
        goal = (near + 0.8 + turned, *others)[:7]
        try:
            kabo.plan_motion(scene, "arm", "home", goal, epsilon=0.03, clearance=kept, samples=1)
        except kabo.NoMotionError:
            continue
        except InputError as refused:
            said = refused.diagnostics[0].message
            link = re.search(r"arm\.(\w+) and wall", said)
            assert link is not None, said
            apart = 1000.0 * distance_of_meshes(scene, goal, link[1])
            told = re.search(r"are ([\d.]+) mm apart", said)
            kinds.add("apart" if told else "touches")
            assert (float(told[1]) if told else 0.0) == pytest.approx(apart, abs=0.051), said
            missing = re.search(r", but 5 mm are to be kept", said)
            assert told is None or (missing is not None) == (kept > 0.0 and apart < 4.95), said  # noqa: PLR2004
            finer = re.search(r"\(try --epsilon ([\d.e-]+)\)", said)
            same = abs(apart - 1000.0 * kept) < 0.1  # told alike: no epsilon is proposed  # noqa: PLR2004
            assert told is None or missing is not None or finer is not None or same, said
            if finer is not None and float(finer[1]) >= 0.001:  # noqa: PLR2004
                again = TaskScene.of(GeometryServer(scene, float(finer[1]), clearance=kept).context(), scene.start)
                hit = again.at("arm", np.array((*goal, *scene.start.robots["arm"][7:]))).hit("arm")
                assert hit != (f"arm.{link[1]}", "wall"), said
                kinds.add("finer")
    assert kinds == {"apart", "touches", "finer"}


def test_where_no_way_is_found_it_says_how_much_is_to_be_kept(tmp_path: Path):
    path = tmp_path / "scene.yaml"
    path.write_text(WALL + "uncertain: {wall: 4mm, arm: 1mm}\n")
    with pytest.raises(kabo.NoMotionError, match=r"wall \(\d+ times, 5 mm are to be kept\)"):
        kabo.plan_motion(kabo.load_scene(path), "arm", "home", "there", samples=1)


HAND = """    gripper:
      joints: [panda_finger_joint1]
      open: {panda_finger_joint1: 0.04}
      closed: {panda_finger_joint1: 0}
      touch_links: [panda_leftfinger, panda_rightfinger]
      force: FORCE
    allowed_contacts:"""
BALL = "  ball: {sphere: {radius: 0.02}, mass: 2, movable: true, pose: {position: [2, 2, 2]}}\n"


def _carrying(path: Path, force: float) -> Scene:
    """The scene with the wall, and a ball of 2 kg in a hand of this force [N]."""
    path.write_text(WALL.replace("    allowed_contacts:", HAND.replace("FORCE", str(force)), 1) + BALL)
    scene = kabo.load_scene(path)
    held = Attachment("arm.panda_hand", (0.0, 0.0, 0.16), (1.0, 0.0, 0.0, 0.0))
    return replace(scene, start=replace(scene.start, objects={**scene.start.objects, "ball": held}))


def test_what_is_too_heavy_for_the_hand_is_refused_with_weight_and_force(tmp_path: Path):
    with pytest.raises(InputError, match=r"arm cannot hold ball, even at rest: .* 5 N"):
        kabo.plan_motion(_carrying(tmp_path / "scene.yaml", 5.0), "arm", "home", {"panda_joint1": -1.2})


def test_a_motion_while_carrying_is_slower_in_a_weaker_hand(tmp_path: Path):
    goal, path = {"panda_joint1": -1.2}, tmp_path / "scene.yaml"
    strong, weak = (kabo.plan_motion(_carrying(path, force), "arm", "home", goal) for force in (200.0, 42.0))
    assert strong.duration < weak.duration


TOOL = "    tool: {frame: panda_hand, features: {axis: {line: {through: [0, 0, 0.1], along: [0, 0, 1]}}}}\n    gripper:"
CUP = """  cup:
    cylinder: {radius: 0.02, height: 0.06}
    mass: 1
    movable: true
    pose: {frame: arm.panda_hand, position: [0, 0, 0.12]}
"""
KEPT = """motion_constraints:
  down:
    - angle(tool.axis, world.up) >= 165 deg
  hanging:
    - angle(this.axis, world.up) >= 165 deg
"""


@pytest.fixture(scope="module")
def hand(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """A Panda with a cup between its fingers, without the wall."""
    path = tmp_path_factory.mktemp("hand") / "scene.yaml"
    text = WALL[: WALL.index("  wall: ")].replace("    allowed_contacts:", HAND.replace("FORCE", "100"), 1)
    path.write_text(text.replace("    gripper:", TOOL, 1) + CUP + KEPT)
    return kabo.load_scene(path)


def _tilt(found: Motion) -> float:
    """The greatest tilt of the hand [rad], by samples."""
    fingers = found.start[found.scene.robots["arm"].planned :]
    rows = found.trajectory.sampled(50.0).positions.tolist()
    states = [found.scene.start.replace({"arm": (*row, *fingers)}) for row in rows]
    cosines = [-world_T(found.scene, state, "arm.panda_hand")[2, 2] for state in states]
    return float(np.arccos(np.clip(cosines, -1.0, 1.0)).max())


def test_a_constraint_of_the_tool_alone_is_kept_with_an_empty_hand(hand: Scene):
    free, kept = (
        find_motion(hand, "arm", "home", "there", keep=keep, holding="cup") for keep in (None, "hanging")
    )
    alone = find_motion(
        hand, "arm", "home", {"panda_joint2": 0.1, "panda_joint4": -1.5, "panda_joint6": 1.6}, keep="down"
    )
    assert alone.plan(certificate=False).nodes["n0"].motion[0].constraint == "down"
    for found in (free, kept, alone):
        report = kabo.verify(hand, found.plan())
        assert report.ok, report
    assert max(_tilt(kept), _tilt(alone)) <= np.radians(15.0) + 1e-6


def test_a_body_in_the_hand_is_carried_from_where_the_scene_has_it(hand: Scene):
    found = find_motion(hand, "arm", "home", "there", holding="cup")
    start = found.plan(certificate=False).start
    assert start is not None
    held = start.objects["cup"]
    assert held.parent == "arm.panda_hand" and np.allclose(held.position, (0.0, 0.0, 0.12), atol=1e-6)


def test_what_cannot_be_held_is_told(hand: Scene, scene: Scene):
    for wanted, words in (("cap", "no movable body 'cap'"), ("world", "no movable body 'world'")):
        with pytest.raises(InputError, match=words) as told:
            kabo.plan_motion(hand, "arm", "home", "there", holding=wanted)
        assert wanted != "cap" or 'did you mean "cup"?' in str(told.value)
    with pytest.raises(InputError, match="has no tool"):
        kabo.plan_motion(scene, "arm", "home", "there", holding="wall")
    with pytest.raises(InputError, match="holds nothing that hanging fits"):
        kabo.plan_motion(hand, "arm", "home", "there", keep="hanging")


def test_a_clearance_is_kept_told_and_proven(scene: Scene, motion: Motion):
    found = find_motion(scene, "arm", "home", "there", seed=1, clearance=0.02)
    plan = found.plan()
    assert plan.options["clearance"] == 0.02 and "clearance" not in motion.plan(certificate=False).options
    assert plan.certificate is not None
    assert all(each.clearance is None or each.clearance >= 0.02 for each in plan.certificate.segments)
    report = kabo.verify(scene, plan)
    assert report.ok, str(report)
    claimed = replace(plan, options={**plan.options, "clearance": 0.2})
    assert not kabo.verify(scene, claimed).ok


def test_the_plan_of_a_motion_is_proven_with_the_epsilon_that_the_motion_was(tmp_path: Path):
    """It was proven with that of the scene: where that is too coarse, the plan had no certificate and was refused."""
    path = tmp_path / "scene.yaml"
    path.write_text(WALL.replace("epsilon: 0.01", "epsilon: 0.05"))
    scene = kabo.load_scene(path)
    found = find_motion(scene, "arm", "home", "there", seed=1, epsilon=0.005, clearance=0.02)
    plan = found.plan()
    assert plan.options["epsilon"] == found.epsilon == 0.005  # noqa: PLR2004
    assert plan.certificate is not None and plan.certificate.epsilon == 0.005  # noqa: PLR2004
    report = kabo.verify(scene, plan)
    assert report.ok, str(report)
    assert find_motion(scene, "arm", "home", "home").epsilon == scene.epsilon


def test_a_clearance_that_cannot_be_had_says_for_whom_and_how_much_there_is(scene: Scene):
    with pytest.raises(
        InputError, match=r"at the start arm\.\w+ and \S+ are [\d.]+ mm apart, but 290 mm are to be kept"
    ):
        kabo.plan_motion(scene, "arm", "home", "there", clearance=0.29)
    with pytest.raises(kabo.NoMotionError, match=r"wall \(\d+ times, 4 mm are to be kept\)"):
        kabo.plan_motion(scene, "arm", "home", "there", clearance=0.004, samples=1)
    for wrong in (-0.001, 0.5, float("nan"), "3mm"):
        with pytest.raises(ValueError, match=r"clearance must be a length from 0 to 0\.3 m"):
            kabo.plan_motion(scene, "arm", "home", "there", clearance=wrong)


# ------------------------------------------------------------------------------------------------ installed robots
SLIDER = """<robot name="slider"><link name="base"/>
  <link name="cart"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="10"/></joint></robot>"""
INSTALLED = """
scene: rail
epsilon: 0.01
packages: {toy: installed}
robots:
  cart: {urdf: package://toy/slider.urdf, joints: [slide], configurations: {home: [0], there: [0.5]}}
"""


def installed_plan(folder: Path) -> tuple[Path, kabo.Plan]:
    folder.mkdir(parents=True)
    path = folder / "scene.yaml"
    path.write_text(INSTALLED)
    return path, find_motion(kabo.load_scene(path), "cart", "home", "there").plan()


def test_a_plan_with_an_installed_robot_is_the_same_in_any_folder_and_verified_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    toy = tmp_path / "environment" / "share" / "toy"
    toy.mkdir(parents=True)
    (toy / "slider.urdf").write_text(SLIDER)
    monkeypatch.setattr("sys.prefix", str(tmp_path / "environment"))
    _, here = installed_plan(tmp_path / "here")
    there, same = installed_plan(tmp_path / "far" / "away" / "there")
    assert "package://toy/slider.urdf" in here.files
    assert here == same
    scene = kabo.load_scene(there)
    assert kabo.verify(scene, here).ok
    old = {
        name.replace("package://toy", "../../../environment/share/toy"): each for name, each in here.files.items()
    }
    assert kabo.verify(scene, replace(here, files=old)).ok  # as plans were once written
    more = {**here.files, "package://toy/gone.stl": "sha256:0", "package://toy/slider.urdf": "sha256:0"}
    said = str(kabo.verify(scene, replace(here, files=more)))
    assert "package://toy/gone.stl does not exist any more" in said and "slider.urdf has changed since" in said
    other = there.with_name("other.yaml")
    other.write_text("scene: rail\nepsilon: 0.01\n")
    assert "slider.urdf does not exist" not in str(kabo.verify(kabo.load_scene(other), here))
    (toy / "slider.urdf").write_text(SLIDER + "<!-- another -->")
    assert "package://toy/slider.urdf has changed since" in str(kabo.verify(scene, here))


def test_a_robot_that_nothing_could_meet_is_verified(tmp_path: Path):
    (tmp_path / "slider.urdf").write_text(SLIDER)
    path = tmp_path / "scene.yaml"
    path.write_text(INSTALLED.replace("packages: {toy: installed}\n", "").replace("package://toy/", ""))
    scene = kabo.load_scene(path)
    report = kabo.verify(scene, find_motion(scene, "cart", "home", "there").plan())
    assert report.ok and report.pairs == 0, str(report)


@pytest.mark.parametrize(
    ("argument", "wrong", "words"),
    [
        ("robot", {"robot": "harm"}, "the scene has no robot 'harm'"),
        ("start", {"start": "nowhere"}, "arm has no configuration 'nowhere'"),
        ("goal", {"goal": {"panda_joint1": 9.0}}, "the goal has panda_joint1 at 9"),
        ("goal", {"goal": [0.0]}, "the goal has 1 value, and arm plans 7 joints"),
        ("goal", {"goal": None}, "the goal has 1 value, and arm plans 7 joints"),
        ("goal", {"goal": [[0.0] * 7]}, "the goal has 1 value, and arm plans 7 joints"),
        ("goal", {"goal": ["a", 0, 0, 0, 0, 0, 0]}, "the goal has 'a' for panda_joint1, which is no number"),
        ("start", {"start": {"panda_joint1": "5deg"}}, "the start has '5deg' for panda_joint1"),
        ("start", {"start": {0: 0.5}}, "the start names 0, which is no planned joint"),
        ("holding", {"holding": "cap"}, "no movable body 'cap'"),
        ("keep", {"keep": "lying"}, "no motion constraint 'lying'"),
    ],
)
def test_a_wrong_argument_is_told_by_its_name(hand: Scene, argument: str, wrong: dict[str, Any], words: str):
    with pytest.raises(InputError, match=words) as told:
        kabo.plan_motion(hand, **{"robot": "arm", "start": "home", "goal": "there"} | wrong)
    assert told.value.diagnostics[0].file == argument


def test_a_robot_is_given_by_its_name(hand: Scene):
    with pytest.raises(TypeError, match="robot must be a str, and is of type Robot"):
        kabo.plan_motion(hand, hand.robots["arm"], "home", "there")  # type: ignore[arg-type]
