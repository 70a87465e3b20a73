"""Whatever a run of a task's trials would refuse is found before it, all at once, and `kabo check` says the same."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.requests import check_files
from kabo.trials import load_exploration_file, trial_findings, trial_of
from tests.trials.conftest import JUMPS, TASK

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pick_and_place"
REACH = (EXAMPLE / "reach.yaml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"),
    [
        ("task: task.yaml", "task: «tasks.yaml»", '"tasks.yaml": there is no such file', 'did you mean "task.yaml"?'),
        ("  jobs: 30\n", "  scene: «gone.yaml»\n  jobs: 30\n", '"gone.yaml": there is no such file', None),
        ("{landing: {at: [<", "{«landin»: {at: [<", 'the task "jump" has no property "landin"', 'did you mean "landing"?'),
        ("{landing: {at: [<PARAMETER:side>, 0]}}", "{landing: {at: [<PARAMETER:side>, 0]}, ground: «[1]»}", '"ground" must be a text', None),
        ("{landing: {at: [<PARAMETER:side>, 0]}}", "{landing: {at: [<PARAMETER:side>, 0]}, far: «long»}", '"far" must be a number', None),
        ("{far: {from: 0, to: 4, unit: m}, side", "{«along»: {from: 0, to: 4}, side", '"along" has no effect: the task "jump" declares no such property', "write <PARAMETER:along> in a value of the trial's `properties`"),
        ("cases: {ground: ", "cases: {«grond»: ", '"grond" has no effect: the task "jump" declares no such property', "write <CASE:grond> in a value of the trial's `properties`"),
        ("{cost: {unit: J}}", "{«costs»: {unit: J}}", 'the outcome "costs" of a task is `cost` or the name of a cost term: unknown cost term "costs"', 'did you mean "constant"?'),
        ("{cost: {unit: J}}", "{«duration»: }", 'the outcome "duration" is a cost of robots, and the trial has no scene', "`cost` is the cost"),
        ("{cost: {unit: J}}", "{«constant»: }", "the outcome \"constant\" of a task is `cost` or the name of a cost term: the cost term constant: missing a required argument: 'value'", "it is constant("),
    ],
)  # fmt: skip
def test_a_mistake_is_told_at_its_place_with_the_remedy(
    jumps: Path, old: str, new: str, message: str, hint: str | None
) -> None:
    marked = JUMPS.replace(old, new)
    assert marked != JUMPS
    start, text = marked.find("«"), marked.replace("«", "").replace("»", "")
    if "along" in message:
        text = text.replace("start: {far: 0.5", "start: {along: 0.5")
    jumps.write_text(text)
    found = [each for each in check_files([jumps]) if each.file == str(jumps)]
    one = next(each for each in found if each.message == message)
    assert (one.hint or "").startswith(hint or "")
    assert (one.line, one.column) == (text.count("\n", 0, start) + 1, start - text.rfind("\n", 0, start))
    with pytest.raises(InputError) as caught:
        trial_of(load_exploration_file(jumps))
    assert one in caught.value.diagnostics


def test_a_parameter_whose_property_is_given_another_value_has_no_effect(jumps: Path) -> None:
    jumps.write_text(JUMPS.replace("{landing:", "{far: 2, landing:"))
    (one,) = check_files([jumps])
    assert one.message == '"far" has no effect: `properties` gives another value'


def test_a_required_property_that_nothing_gives_is_missing(jumps: Path) -> None:
    text = JUMPS.replace("{landing:", "{ground: sand, landing:").replace("far: {from: 0, to: 4, unit: m}, ", "")
    jumps.write_text(text.replace("far: 0.5, ", "").replace("cases: {ground: [grass, ice]}\n", ""))
    (one,) = check_files([jumps])
    assert (one.message, one.line) == ('the number "far" must be given', 2)


def test_errors_of_the_task_file_are_told_there_beside_those_of_the_exploration(jumps: Path) -> None:
    task = jumps.with_name("task.yaml")
    task.write_text(TASK.replace("jumping/Jump", "jumping/Leap"))
    jumps.write_text(JUMPS.replace("{cost:", "{costs:"))
    found = check_files([jumps])
    assert [(each.file, each.line) for each in found] == [(str(jumps), 8), (str(task), 8)]
    assert found[1].message == 'unknown stage "jumping/Leap"'


def test_stages_that_do_not_fit_together_are_found_without_planning(jumps: Path) -> None:
    jumps.with_name("task.yaml").write_text(TASK.replace("  - {name: tries, stage: jumping/Tries}\n", ""))
    (one,) = check_files([jumps])
    assert one.file == str(jumps.with_name("task.yaml")) and "jump" in one.message


def test_a_value_that_is_wrong_at_the_end_of_a_range_alone_is_found(jumps: Path) -> None:
    jumps.write_text(JUMPS.replace("to: 4, unit: m", "to: 4.5, unit: m"))
    (one,) = check_files([jumps])
    assert one.file == str(jumps.with_name("task.yaml")) and one.message.endswith("is at most 4, not 4.5")


def test_a_task_with_robots_needs_a_scene(tmp_path: Path) -> None:
    path = tmp_path / "reach.yaml"
    (tmp_path / "task.yaml").write_text((EXAMPLE / "task.yaml").read_text())
    path.write_text(REACH.replace("  scene: scene.yaml\n", ""))
    (one,) = check_files([path])
    assert one.message == 'the task "pick and place" moves robots and needs a scene'


def reach(tmp_path: Path, old: str, new: str) -> Path:
    """The example, changed in one place."""
    assert REACH.count(old) == 1
    text = REACH.replace(old, new)
    for name in ("task", "scene"):
        text = text.replace(f"{name}: {name}.yaml", f"{name}: {EXAMPLE / name}.yaml")
    path = tmp_path / "reach.yaml"
    path.write_text(text)
    return path


def test_a_thing_that_the_scene_lacks_is_found_for_every_value_of_a_case(tmp_path: Path) -> None:
    text = "outcomes: {duration: {unit: s}}"
    (one,) = check_files([reach(tmp_path, text, f"cases: {{object: [object, cup]}}\n{text}")])
    assert one.message == '"object" is cup, which is no body of the scene'


def test_a_value_that_makes_no_sense_anywhere_within_the_bounds_is_found(tmp_path: Path) -> None:
    old = "[<PARAMETER:x>, <PARAMETER:y>, 0.125]"
    (one,) = check_files([reach(tmp_path, old, "[<PARAMETER:x>, <PARAMETER:y>]")])
    assert one.file.endswith("task.yaml") and one.line == 56
    assert one.message.endswith("position: three finite numbers, not [0.6, -0.15]")


def test_the_example_has_no_findings_and_its_trial_is_a_function() -> None:
    file = load_exploration_file(EXAMPLE / "reach.yaml")
    assert not trial_findings(file) and callable(trial_of(file))
