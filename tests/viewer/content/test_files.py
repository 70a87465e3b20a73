"""Files given to the viewer: what each is, what cannot be viewed and why, where a plan's problem is."""

import json
import shutil
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.plan import Plan
from kabo.viewer.content.files import given_file, problem_of_plan
from kabo.whole_files import file_hash

REPOSITORY = Path(__file__).parents[3]


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("domains/bartender/scene.yaml", "scene"),
        ("domains/bartender/four_bottles.yaml", "problem"),
        ("examples/pick_and_place/task.yaml", "task"),
    ],
)
def test_a_file_is_what_its_keys_say(name, kind):
    assert given_file(REPOSITORY / name).kind == kind


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        ({"format": "kabo-plan/1"}, "plan"),
        ({"format": "kabo-task/2"}, "report"),
        ({"verdict": "no_plan", "counterfactuals": []}, "explanation"),
    ],
)
def test_json_is_what_its_format_says(tmp_path, content, kind):
    path = tmp_path / "some.json"
    path.write_text(json.dumps(content))
    assert given_file(path).kind == kind


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("other.json", '{"format": "kabo-plan/9"}', 'the format "kabo-plan/9" is not known here'),
        ("list.json", "[]", "no `format` of kabo"),
        ("broken.json", '{"a": \n oops', "broken.json:2:2: this is no JSON"),
        ("notes.yaml", "a: 1", "nothing that can be viewed"),
        ("domain.yaml", "domain: d\nactions: {}", "a file of kind domain"),
    ],
)
def test_what_cannot_be_viewed_is_refused_with_what_can(tmp_path, name, text, said):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match="kabo|JSON") as refused:
        given_file(path)
    assert said in str(refused.value)


def plan_for(problem: Path) -> Plan:
    files = {name: file_hash(problem.parent / name) for name in (problem.name, "domain.yaml")}
    return Plan("parcels", files, {}, "n0", {})


def test_the_problem_of_a_plan_is_found_below_its_folder_by_name_and_content(tmp_path):
    shutil.copytree(REPOSITORY / "tests/acceptance/parcels", tmp_path / "below" / "parcels")
    problem = next(
        each for each in (tmp_path / "below" / "parcels").glob("*.yaml") if "problem:" in each.read_text()
    )
    plan = plan_for(problem)
    assert problem_of_plan(plan, tmp_path / "plan.json").path == problem
    problem.write_text(problem.read_text() + "\n# changed\n")
    with pytest.raises(InputError, match="--problem"):
        problem_of_plan(plan, tmp_path / "plan.json")
