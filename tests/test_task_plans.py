"""Solutions of tasks as plans of one node: the verifier judges their motion in the scene, and refuses what was spoilt."""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.plan import Plan, Segment
from kabo.requests import verify_task_report
from kabo.task_plans import is_report, only_planned, plan_of_report, plans_of_report
from kabo.tasks import TaskReport
from kabo.tasks.files.report_form import read_report, report_bytes

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
EXAMPLE = EXAMPLES / "pick_and_place"
LIBRARY = Path(kabo.__file__).parent / "tasks" / "library"
NODE = "n0"


@pytest.fixture(scope="module")
def report() -> TaskReport:
    return kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=2)


@pytest.fixture(scope="module")
def plan(report: TaskReport) -> Plan:
    return kabo.task_plan(report)


def spoilt(plan: Plan, number: int, **changes) -> Plan:
    node = plan.nodes[NODE]
    motion = list(node.motion)
    motion[number] = replace(motion[number], **changes)
    nodes = {**plan.nodes, NODE: replace(node, motion=tuple(motion))}
    return replace(plan, nodes=nodes, certificate=None)


def numbered(plan: Plan, stage: str) -> tuple[int, Segment]:
    return next((k, each) for k, each in enumerate(plan.nodes[NODE].motion) if each.stage == stage)


def test_the_plan_of_a_solution_is_verified_with_its_certificate_and_grants(report: TaskReport, plan: Plan):
    found = kabo.verify(report.scene, plan)
    assert found.ok, found
    assert plan.certificate is not None
    assert [node.kind for node in plan.nodes.values()] == ["action", "goal"]
    granted = [grant.kind for segment in plan.nodes[NODE].motion for grant in segment.grants]
    assert {"grasp", "support"} == set(granted)


def test_the_cheapest_solution_is_taken_unless_another_is_chosen(report: TaskReport, plan: Plan):
    costs = [solution.cost for solution in report.solutions]
    cheapest = costs.index(min(costs)) + 1
    assert kabo.task_plan(report, cheapest, certificate=False).nodes == plan.nodes
    assert kabo.task_plan(report, 3 - cheapest, certificate=False).nodes != plan.nodes
    with pytest.raises(InputError, match="there is no solution 3"):
        kabo.task_plan(report, 3)


@pytest.mark.parametrize(
    ("scene", "task", "given"),
    [
        ("bottle_pouring/scene.yaml", EXAMPLES / "bottle_pouring" / "task.yaml", {}),
        ("retract_transit_approach/scene.yaml", EXAMPLES / "retract_transit_approach" / "task.yaml", {}),
        (
            "two_arms/scene.yaml",
            EXAMPLES / "two_arms" / "tasks" / "take_both.yaml",
            {"first": "left", "this": "red", "second": "right", "that": "blue"},
        ),
        ("two_cans/scene.yaml", LIBRARY / "pick.yaml", {"robot": "arm", "object": "can_1"}),
    ],
)
def test_what_tasks_find_is_verified(scene: str, task: Path, given: dict[str, str]):
    """Pouring, padding, two robots at once, and a public robot."""
    made = kabo.plan_task(task, EXAMPLES / scene, given, max_solutions=1)
    found = kabo.verify(made.scene, kabo.task_plan(made))
    assert found.ok, found
    said = only_planned(made.content, 1)  # the verifier knows no padding: whoever exports is told
    assert ("padding of" in said) if "retract" in scene else said is None


def test_grasps_that_differ_in_the_width_of_the_hand_alone_are_told_apart(tmp_path: Path):
    """The first family fits the pose, too, but not the width: the verifier would refuse what it allows."""
    text = (EXAMPLES / "two_arms" / "scene.yaml").read_text().replace("../../meshes", str(ROOT / "meshes"))
    begin, end = text.index("      side:"), text.index("    placements:")
    wider = text[begin:end].replace("side:", "wider:").replace("finger_joint: 0.03", "finger_joint: 0.0325")
    (tmp_path / "scene.yaml").write_text(text[:begin] + wider + text[begin:])
    given = {"robot": "left", "object": "red", "grasp": "side"}
    made = kabo.plan_task(LIBRARY / "pick.yaml", tmp_path / "scene.yaml", given, max_solutions=1)
    plan = kabo.task_plan(made)
    named = {g.by for segment in plan.nodes[NODE].motion for g in segment.grants if g.kind == "grasp"}
    assert named == {"side"}
    found = kabo.verify(made.scene, plan)
    assert found.ok, found


# A wall behind the arm, padding of the hand and of what it takes; all but the wall are gone at the end.
GUARDED = """
name: guarded
properties: {robot: {type: robot}, object: {type: body}}
max_solutions: 1
stages:
  - {name: start, stage: CurrentState}
  - {name: wall, stage: AddGeometry, body: wall, shape: {box: [0.05, 1.0, 1.0]}, pose: {position: [-0.9, 0, 0.5]}}
  - {name: thick hand, stage: Pad, things: [arm.panda_link4], distance: 0.01}
  - {name: take, stage: pick, object: <PARENT>}
  - {name: thick, stage: Pad, things: [can_1], distance: 0.01}
  - {name: home, stage: MoveTo, goal: home}
  - {name: thin, stage: Unpad, things: [can_1, arm.panda_link4]}
  - {name: aside, stage: MoveTo, goal: {panda_joint1: 0.3}}
"""


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> TaskReport:
    path = tmp_path_factory.mktemp("guarded") / "guarded.yaml"
    path.write_text(GUARDED)
    return kabo.plan_task(path, EXAMPLES / "two_cans" / "scene.yaml", {"robot": "arm", "object": "can_1"})


def judged(report: TaskReport, spoil=lambda change: None):
    """The verdict on the only solution, with its changes spoilt."""
    changes = deepcopy(report.content["runs"][0]["solutions"][0]["motion"]["changes"])
    for change in changes:
        spoil(change)
    return kabo.verify(report.scene, kabo.task_plan(report, certificate=False), changes=changes)


def test_what_stages_add_is_kept_away_from_and_told(guarded: TaskReport):
    found = judged(guarded)
    assert found.ok, found
    (note,) = [each for each in found.notes if "stages added" in each]
    assert all(name in note for name in ("wall", "padding of can_1", "padding of arm.panda_link4"))


def resized(name: str, size: list[float]):
    def spoil(change):
        if "body" in change and change["body"]["name"] == name:
            (kind,) = change["body"]["shape"]
            change["body"]["shape"][kind] = size

    return spoil


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("wall", [2.4, 1.0, 1.0]),  # up to the arm
        ("padding of arm.panda_link4", [1.0, 1.0, 0.6]),
        ("padding of can_1", [0.5, 0.5, 1.0]),  # which the hand carries
    ],
)
def test_a_motion_that_touches_what_a_stage_adds_is_refused(guarded: TaskReport, name: str, size: list[float]):
    found = judged(guarded, resized(name, size))
    assert any(name in str(each) for each in found.findings), found


def test_padding_counts_from_when_it_is_there_until_it_is_gone(guarded: TaskReport):
    """At the end the arm turns without padding: as large as the scene, it is touched by nothing then."""
    changes = guarded.content["runs"][0]["solutions"][0]["motion"]["changes"]
    (gone,) = {change["segment"] for change in changes if change["change"] == "unpad"}

    def late(change):
        resized("padding of can_1", [3.0, 3.0, 3.0])(change)
        change["segment"] = gone if change["change"] in ("pad", "unpad") else change["segment"]

    assert judged(guarded, late).ok


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("parent", "arm.panda_link44", "attached to arm.panda_link44, which the scene does not have"),
        ("shape", {"pyramid": [1.0, 1.0, 1.0]}, "is no body"),
        ("shape", {"box": [1.0, -1.0, 1.0]}, "is no body"),
        ("shape", {"box": [1.0, 1.0]}, "is no body"),
        ("position", [float("nan"), 0.0, 0.0], "is no body"),
        ("quaternion", [0.0, 0.0, 0.0, 0.0], "is no body"),
    ],
)
def test_what_is_no_body_of_the_scene_is_told(guarded: TaskReport, key: str, value, words: str):
    def spoil(change):
        if change["change"] == "add":
            change["body"][key] = value

    assert any(words in str(each) for each in judged(guarded, spoil).findings)


# Padding of a robot that stands, of what it could take, and a body on a link of it without geometry.
STANDING = """
name: standing
max_solutions: 1
stages:
  - {name: start, stage: CurrentState}
  - {name: thick, stage: Pad, things: [right.link_4, blue], distance: 0.01}
  - name: tip
    stage: AddGeometry
    body: tip
    shape: {sphere: {radius: 0.01}}
    parent: right.tool0
    pose: {position: [0, 0, 0.3]}
  - {name: take, stage: pick, robot: left, object: red}
"""


def test_what_is_added_to_a_robot_that_does_not_move_stands_with_it(tmp_path: Path):
    """The judge knew the configurations of robots that move alone, and ended in `KeyError: 'right'`."""
    path = tmp_path / "standing.yaml"
    path.write_text(STANDING)
    report = kabo.plan_task(path, EXAMPLES / "two_arms" / "scene.yaml")
    found = judged(report)
    assert found.ok, found
    for name, size in (("padding of right.link_4", [3.0, 3.0, 3.0]), ("tip", [2.0, 2.0, 2.0])):
        assert any(name in str(each) for each in judged(report, resized(name, size)).findings)


@pytest.mark.parametrize(
    ("kind", "key"),
    [("permit", "pairs"), ("attach", "to"), ("add", "body"), ("unpad", "object"), ("detach", "object")],
)
def test_a_change_that_lacks_what_it_changes_is_told(guarded: TaskReport, kind: str, key: str):
    content = json.loads(report_bytes(guarded.content))
    changes = content["runs"][0]["solutions"][0]["motion"]["changes"]
    changes.append({"change": kind, "stage": "x", "segment": 0, "time": 0.0})
    with pytest.raises(InputError, match=rf"motion.changes\[{len(changes) - 1}\] lacks `(object|{key})`"):
        read_report(json.dumps(content).encode(), "r.json")


def test_a_change_after_no_segment_is_told(guarded: TaskReport):
    assert any(
        "after segment 99" in str(each) for each in judged(guarded, lambda c: c.update(segment=99)).findings
    )


def test_a_report_of_added_bodies_is_judged_with_them(guarded: TaskReport, tmp_path: Path):
    scene = EXAMPLES / "two_cans" / "scene.yaml"
    guarded.save(tmp_path / "good.json")
    bad = deepcopy(guarded.content)
    for change in bad["runs"][0]["solutions"][0]["motion"]["changes"]:
        resized("wall", [2.4, 1.0, 1.0])(change)
    (tmp_path / "bad.json").write_bytes(report_bytes(bad))
    verdicts = [
        judged.ok for name in ("good", "bad") for _, judged in verify_task_report(scene, tmp_path / f"{name}.json")
    ]
    assert verdicts == [True, False]


def test_a_motion_through_the_table_is_refused(report: TaskReport, plan: Plan):
    number, carried = numbered(plan, "move to place")
    low = [*carried.waypoints[0]]
    low[1] += 0.5
    rows = (carried.waypoints[0], tuple(low), carried.waypoints[-1])
    times = (carried.times[0], sum(carried.times[:: len(carried.times) - 1]) / 2, carried.times[-1])
    found = kabo.verify(report.scene, spoilt(plan, number, waypoints=rows, times=times, trajectory=None))
    assert any("collide" in str(each) for each in found.findings), found


def test_an_object_that_is_never_taken_does_not_move(report: TaskReport, plan: Plan):
    number, _ = numbered(plan, "pick/close hand")
    assert not kabo.verify(report.scene, spoilt(plan, number, attach=())).ok


def test_a_contact_that_nothing_grants_is_refused(report: TaskReport, plan: Plan):
    number, lifted = numbered(plan, "pick/lift")
    assert not kabo.verify(report.scene, spoilt(plan, number, grants=())).ok
    assert not kabo.verify(report.scene, spoilt(plan, number, allowed_contacts=(), grants=())).ok
    gone = tuple(replace(each, bodies=("object", "arm.link_3")) for each in lifted.grants)
    assert not kabo.verify(report.scene, spoilt(plan, number, grants=gone)).ok


def test_a_recorded_end_that_is_not_reached_is_refused(report: TaskReport, plan: Plan):
    node = plan.nodes[NODE]
    assert node.after is not None
    moved = {name: replace(pose, position=(0.5, 0.0, 0.125)) for name, pose in node.after.objects.items()}
    nodes = {**plan.nodes, NODE: replace(node, after=replace(node.after, objects=moved))}
    assert not kabo.verify(report.scene, replace(plan, nodes=nodes, certificate=None)).ok


def test_a_plan_of_a_task_is_no_plan_of_a_problem(plan: Plan):
    """Or a motion alone would be taken for the goal."""
    problem = kabo.load_problem(EXAMPLES / "two_cans" / "problem.yaml")
    assert not kabo.verify(problem, plan).ok


def test_a_saved_report_gives_the_same_plan(report: TaskReport, plan: Plan, tmp_path: Path):
    saved = tmp_path / "report.json"
    report.save(saved)
    assert is_report(saved)
    number, read, scene, unknown = plan_of_report(saved)
    assert kabo.plan_to_json(read) == kabo.plan_to_json(plan)
    assert unknown is None
    assert [k for k, *_ in plans_of_report(saved)] == [1, 2]
    assert kabo.verify(scene, read).ok and number in (1, 2)


def test_a_report_that_ends_too_early_is_a_faulty_report_and_not_called_something_else(
    report: TaskReport, tmp_path: Path
):
    saved = tmp_path / "report.json"
    report.save(saved)
    whole = saved.read_bytes()
    for size in (40, len(whole) // 2, len(whole) - 3):
        saved.write_bytes(whole[:size])
        assert is_report(saved)
        with pytest.raises(InputError, match="this is no JSON"):
            plan_of_report(saved)
    for other in (b"", b"{", b'{"format": "kabo-plan/2", ', b'{"format": "\xff", '):
        saved.write_bytes(other)
        assert not is_report(saved)


def test_a_clearance_of_a_report_is_proven(tmp_path: Path):
    made = kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1, clearance=0.003)
    saved = tmp_path / "report.json"
    made.save(saved)
    assert made.content["clearance"] == 0.003
    ((_, read, scene, _),) = plans_of_report(saved)
    assert read.options["clearance"] == 0.003
    assert read.certificate is not None
    assert kabo.verify(scene, read).ok
    assert min(each.clearance for each in read.certificate.segments if each.clearance is not None) >= 0.003


def test_a_scene_that_lacks_what_a_report_moves_is_refused(report: TaskReport, tmp_path: Path):
    saved = tmp_path / "report.json"
    report.save(saved)
    with pytest.raises(InputError, match="which the scene does not have"):
        plan_of_report(saved, EXAMPLES / "two_cans" / "scene.yaml")


def test_a_report_whose_scene_is_not_there_is_refused(report: TaskReport, tmp_path: Path):
    content = json.loads(json.dumps(report.content)) | {"scene": "gone.yaml"}
    saved = tmp_path / "report.json"
    saved.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"was planned in gone\.yaml, which is not there"):
        plan_of_report(saved)


def test_a_report_without_solutions_says_so(tmp_path: Path):
    made = kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1, timeout=0.0)
    assert not made.solutions
    with pytest.raises(InputError, match="the report has no solution"):
        kabo.task_plan(made)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("segments", 0, "joints", 0), "elbow"),
        (("segments", 2, "attach", 0, "object"), "ghost"),
        (("segments", 2, "attach", 0, "to"), "arm.nothing"),
        (("segments", 0, "waypoints", 0), [0.0]),
        (("segments", 0, "times", 0), -1.0),
        (("segments", 0, "robot"), "legs"),
        (("segments", 0, "trajectory", "times"), []),
        (("segments", 0, "trajectory", "coefficients", 0, 0, 0), 1e9),
        (("after", "objects"), {}),
    ],
)
def test_motions_that_are_none_are_refused_or_not_verified(report: TaskReport, path, value, tmp_path: Path):
    """With a message, or by the verifier; never with a traceback, never accepted."""
    content = json.loads(json.dumps(report.content))
    here = content["runs"][0]["solutions"][0]["motion"]
    for key in path[:-1]:
        here = here[key]
    here[path[-1]] = value
    saved = tmp_path / "report.json"
    saved.write_text(json.dumps(content))
    try:
        _, plan, scene, _ = plan_of_report(saved, EXAMPLE / "scene.yaml", 1, certificate=False)
    except InputError:
        return
    assert not kabo.verify(scene, plan).ok


@pytest.mark.parametrize("far", [1e5, 1e18, 1e300])
def test_a_motion_that_leads_nowhere_is_refused_at_once(report: TaskReport, plan: Plan, far: float):
    """Proofs along it would never end, or numbers would overflow."""
    number, carried = numbered(plan, "move to place")
    followed = carried.trajectory
    assert followed is not None
    first = ((far, *followed.coefficients[0][0][1:]), *followed.coefficients[0][1:])
    astray = replace(followed, coefficients=(first, *followed.coefficients[1:]))
    away = (*carried.waypoints[:-1], (far, *carried.waypoints[-1][1:]))
    for changes in ({"trajectory": astray}, {"waypoints": away, "trajectory": None}):
        found = kabo.verify(report.scene, spoilt(plan, number, **changes))
        assert any("farther than" in str(each) or "too far" in str(each) for each in found.findings), found
