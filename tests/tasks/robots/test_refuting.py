"""What is proven impossible before any search is not searched; where there are alternatives, only those that are."""

from pathlib import Path

import pytest

import kabo
from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.tasks import Result, propagator, register
from kabo.tasks.procedures import GeometricProcedures

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pick_and_place"
MORE = """
    placements:
      stood:
        constraints:
          - coincident(this.bottom, support.top)
          - aligned(this.axis, world.up)
        retreat: {against: tool.approach, distance: [0.1, 0.15]}
    features:
      bottom: {plane: {through: [0, 0, -0.125], normal: [0, 0, 1]}}
      axis: {line: {through: [0, 0, 0], along: [0, 0, 1]}}
      center: {point: [0, 0, 0]}
  beyond: {box: [0.4, 0.5, 0.1], pose: {position: [3.5, -0.25, -0.05]}}
  other:
    cylinder: {radius: 0.02, height: 0.25}
    pose: {position: [3.5, -0.25, 0.125]}
    movable: true
    grasps:
      side: {constraints: ["coincident(tool.tcp, this.center)"]}
regions:
  near: {box: [0.2, 0.2, 0.3], support: table, pose: {position: [0.55, -0.2, 0.15]}}
  far: {box: [0.2, 0.2, 0.3], support: beyond, pose: {position: [3.5, -0.2, 0.15]}}
"""


@propagator()
def bring(scene, properties, seed):
    """The other object, brought onto the table by what kabo does not know."""
    return Result(scene)


register(bring, "refuting/Bring")
TASK = """
name: bring
properties: {{robot: {{type: robot, default: arm}}, object: {{type: body, default: object}}}}
max_solutions: 1
stages:
  - {{name: start, stage: CurrentState}}
{stages}
"""
TAKE = "  - {name: take, stage: pick}\n"
THERE, HERE = "{name: there, stage: place, region: far}", "{name: here, stage: place, region: near}"


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    text = (EXAMPLE / "scene.yaml").read_text().replace("../../meshes", str(EXAMPLE.parents[1] / "meshes"))
    path = tmp_path_factory.mktemp("scene") / "scene.yaml"
    path.write_text(text.rstrip() + MORE)
    return kabo.load_scene(path)


def choice(kind, *stages):
    inside = "".join(f"      - {stage}\n" for stage in stages)
    return f"  - name: put\n    stage: {kind}\n    stages:\n{inside}"


def planned(folder, scene, stages):
    path = folder / "bring.yaml"
    path.write_text(TASK.format(stages=stages))
    return kabo.plan_task(path, scene).content["runs"][0]


def test_a_task_that_is_proven_impossible_is_refused_without_any_grasp(tmp_path, scene):
    run = planned(tmp_path, scene, TAKE + f"  - {THERE}\n")
    assert run["exhausted"] and not run["solutions"]
    assert sum(stage["calls"] for stage in run["stages"].values()) == 0
    assert run["explanation"]["stage"] == "there/put/place pose IK/place pose"
    assert run["explanation"]["failures"] == {"out_of_reach": 1}
    (told,) = run["explanation"]["examples"]
    assert told == "far is 1.985 m out of reach of arm with object"


@pytest.mark.parametrize("kind", ["Fallbacks", "Alternatives"])
@pytest.mark.parametrize("stages", [(THERE, HERE), (HERE, THERE)])
def test_of_several_ways_only_the_impossible_one_is_left_out(tmp_path, scene, kind, stages):
    run = planned(tmp_path, scene, TAKE + choice(kind, *stages))
    assert len(run["solutions"]) == 1
    refused = run["stages"]["put/there/put/place pose IK/place pose"]
    assert refused["failures"] == {"out_of_reach": 1}
    assert sum(one["calls"] for path, one in run["stages"].items() if path.startswith("put/there")) == 0


def test_a_task_whose_every_way_is_impossible_is_refused_at_once(tmp_path, scene):
    run = planned(tmp_path, scene, TAKE + choice("Fallbacks", THERE, THERE.replace("there", "again")))
    assert run["exhausted"] and sum(stage["calls"] for stage in run["stages"].values()) == 0
    assert run["explanation"]["text"].count("out_of_reach 1") == 2  # noqa: PLR2004


def test_what_a_robot_holds_it_does_not_take_again(tmp_path, scene):
    run = planned(tmp_path, scene, TAKE + TAKE.replace("take", "again"))
    assert run["explanation"]["stage"] == "again/grasp/grasp pose IK/grasp pose"
    assert run["explanation"]["examples"] == ["arm holds object already"] and run["exhausted"]


def test_an_offset_of_a_joint_beyond_its_limits_is_told_with_them(tmp_path, scene):
    run = planned(tmp_path, scene, "  - {name: turn, stage: MoveRelative, direction: {joints: {joint_2: -7}}}\n")
    (told,) = run["explanation"]["examples"]
    assert told.startswith("joint_2 would be at -7.524, outside its limits of -"), told


def test_where_an_object_is_at_first_proves_nothing_once_a_stage_has_moved_it(tmp_path, scene):
    """The second robot stage that takes it finds it elsewhere."""
    moved = "  - {name: bring, stage: refuting/Bring}\n"
    run = planned(tmp_path, scene, moved + "  - {name: take, stage: pick, object: other}\n")
    assert run["stages"]["bring"]["calls"] == 1
    run = planned(tmp_path, scene, "  - {name: take, stage: pick, object: other}\n")
    assert sum(stage["calls"] for stage in run["stages"].values()) == 0


def test_a_procedure_with_fallbacks_is_refuted_only_if_every_way_is(tmp_path, scene):
    (tmp_path / "tasks").mkdir()
    put = TASK.replace("name: bring", "name: put").format(stages=choice("Fallbacks", THERE, HERE))
    (tmp_path / "tasks" / "put.yaml").write_text(put.replace("{name: start, stage: CurrentState}", NOW))
    (tmp_path / "tasks" / "never.yaml").write_text(
        TASK.replace("name: bring", "name: never")
        .format(stages=choice("Fallbacks", THERE, THERE.replace("there", "again")))
        .replace("{name: start, stage: CurrentState}", NOW)
    )
    server = GeometricProcedures(GeometryServer(scene), tmp_path)
    pick = GroundCall("pick", ("arm", "object"), ())
    start = Situation.of(scene.start)
    picked = server.call(pick, start)
    assert isinstance(picked, Success)
    held = start.replace(picked.changes)
    put, never = (GroundCall(name, ("arm", "object"), ()) for name in ("put", "never"))
    assert server.refuted(put) is None and isinstance(server.call(put, held), Success)
    refused = server.call(never, held)
    assert isinstance(refused, Refusal) and refused.proof and server.refuted(never) is not None


NOW = """name: start
    stage: PredicateFilter
    attached: [<PARENT:object>, <PARENT:robot>]
    wrapped: {name: now, stage: CurrentState}"""
