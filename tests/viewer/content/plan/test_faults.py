"""Plans that were spoilt by hand: what cannot be drawn is refused with its place, all else is drawn as it is written."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.pictures import PictureWishes, picture_of_file
from kabo.plan import Node, ObjectPose, Plan, StateChange
from kabo.viewer import Arrays, ViewOptions, document_of_file, page_of
from kabo.viewer.content.plan.faults import plan_warnings, require_drawable
from kabo.viewer.content.plan.plan_view import plan_view

REPOSITORY = Path(__file__).parents[4]
N2 = REPOSITORY / "domains" / "stacked" / "n2.yaml"
OPTIONS = {"search": "best", "seed": 0, "epsilon": 0.01, "geometry": "bounding"}
HERE = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)


def problem_and_start():
    problem = kabo.load_problem(N2)
    scene = kabo.load_scene(problem.scene)
    robots = {
        name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in scene.start.robots.items()
    }
    objects = {name: ObjectPose(at.parent, *HERE) for name, at in scene.start.objects.items()}
    return problem, scene, StateChange(robots, objects)


def a_plan(problem, start, after=None, leads_to="n1", root="n0"):
    nodes = {"n0": Node("action", action="look", next=leads_to, after=after), "n1": Node("goal")}
    return Plan(problem.name, dict(problem.files), OPTIONS, root, nodes, start=start)


@pytest.mark.parametrize(
    ("spoilt", "said"),
    [
        ({"leads_to": "n7"}, "$.nodes.n0: leads to n7"),
        ({"root": "n7"}, "$.root: there is no node n7"),
        ({"leads_to": "n0"}, "the plan has a cycle"),
    ],
)
def test_what_leads_nowhere_is_refused_with_its_place(spoilt, said):
    problem, scene, start = problem_and_start()
    with pytest.raises(InputError) as refused:
        plan_view(a_plan(problem, start, **spoilt), problem, scene, Arrays(), file="mine.json")
    assert said in str(refused.value)
    assert "mine.json" in str(refused.value)


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (StateChange(objects={"o9": ObjectPose("world", *HERE)}), 'no movable object "o9"'),
        (StateChange(objects={"o1": ObjectPose("mobil.hand", *HERE)}), 'no body or link "mobil.hand"'),
        (StateChange(robots={"mobil": {}}), 'no robot "mobil"; did you mean "mobile"?'),
    ],
)
def test_what_is_not_in_the_scene_is_a_warning_on_the_page_and_refused_for_pictures(after, said):
    problem, scene, start = problem_and_start()
    plan = a_plan(problem, start, after=after)
    assert plan_view(plan, problem, scene, Arrays())["nodes"][0]["motion"]["after"] is not None
    assert said in " ".join(each["message"] for each in plan_warnings(plan, problem, scene, "mine.json"))
    with pytest.raises(InputError, match="was the plan made for this problem"):
        require_drawable(plan, scene)


def test_objects_that_hang_on_each_other_are_shown_as_they_are_written():
    problem, scene, start = problem_and_start()
    knot = StateChange(objects={"o1": ObjectPose("o2", *HERE), "o2": ObjectPose("o1", *HERE)})
    made = plan_view(a_plan(problem, start, after=knot), problem, scene, Arrays())
    assert made["nodes"][0]["motion"]["after"]["objects"]["o1"]["parent"] == "o2"


def test_a_plan_of_a_problem_that_has_changed_is_shown_with_a_warning(tmp_path):
    problem = kabo.load_problem(REPOSITORY / "domains" / "doors" / "n3.yaml")
    plan = replace(a_plan(problem, None), files={**problem.files, "n3.yaml": "sha256:" + 64 * "0"})
    plan.save(tmp_path / "plan.json")
    made = document_of_file(tmp_path / "plan.json", ViewOptions(problem=problem.path))
    assert [each["severity"] for each in made.findings] == ["warning"]
    assert "other contents of n3.yaml" in made.findings[0]["message"]
    a_plan(problem, None).save(tmp_path / "plan.json")
    assert not document_of_file(tmp_path / "plan.json", ViewOptions(problem=problem.path)).findings


def test_half_a_character_and_control_characters_are_shown_as_unknown_ones(tmp_path):
    from xml.etree import ElementTree

    problem = kabo.load_problem(REPOSITORY / "domains" / "doors" / "n3.yaml")
    a_plan(problem, None).save(tmp_path / "plan.json")
    text = (tmp_path / "plan.json").read_text().replace('"look"', '"\\ud800 \\u0000 </script>"')
    (tmp_path / "plan.json").write_text(text)
    assert b"</body>" in page_of(document_of_file(tmp_path / "plan.json", ViewOptions(problem=problem.path)))
    drawn = picture_of_file(tmp_path / "plan.json", ".svg", PictureWishes(problem=problem.path))
    assert any("\ufffd" in (each.text or "") for each in ElementTree.fromstring(drawn).iter())


@pytest.mark.parametrize(
    "explanation",
    [
        "[" * 100_000,
        '{"verdict": "no_plan", "counterfactuals": [], "summary": [], "start": NaN}',
        '{"verdict": "no_plan", "counterfactuals": [], "summary": "a sentence"}',
    ],
)
def test_an_explanation_that_kabo_did_not_write_is_refused(tmp_path, explanation):
    (tmp_path / "why.json").write_text(explanation)
    with pytest.raises(InputError, match=r"why\.json"):
        document_of_file(tmp_path / "why.json")


@pytest.mark.parametrize("name", [5, {"a": 1}, "a\0b", "a" * 5000])
def test_an_explanation_of_a_problem_with_a_strange_name_is_shown_without_it(tmp_path, name):
    given = {"verdict": "no_plan", "counterfactuals": [], "summary": ["a sentence"], "problem": name}
    (tmp_path / "why.json").write_text(json.dumps(given))
    assert document_of_file(tmp_path / "why.json").scene is None
