"""Exploration files: every key and value with its place, and every mistake named, all at once."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.errors import Diagnostic
from kabo.language import check_files, is_exploration
from kabo.language.exploration_description import (
    DEFAULT_JOBS,
    ExplorationDescription,
    FunctionTrial,
    TaskTrial,
    TrialReference,
    reference_of,
    words_of,
)
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.yaml.exploration_file import read_exploration_text

PLUCKS = """\
exploration: plucks
trial: plucked_string/Pluck
parameters:
  eta: {from: 0, to: 1}
  deflection: {from: -0.008, to: 0.014, unit: m}
cases: {string: [d4, f#4], direction: [in, out]}
outcomes: {loudness: {unit: dB}}
validity: {scale: 0.12, noise: 0.15, alpha: 0.7}
invalid_budget: 0.2
start: {eta: 0.5, deflection: 0.0}
retry: {no_onset: {deflection: 0.001}, too_hard: {deflection: -0.001}}
"""
REACH = """\
exploration: reach
trial:
  task: task.yaml
  scene: ../scene.yaml
  jobs: 300
  properties: {destination: {position: [<PARAMETER:x>, 0, 0.1]}, object: <CASE:object>, note: "<PARAMETER:x>"}
parameters: {x: {from: 0, to: 1}}
cases: {object: [cup, bowl]}
outcomes: {duration: }
"""


def read(text: str, name: str = "e.yaml") -> tuple[ExplorationDescription | None, list[Diagnostic]]:
    findings = Findings()
    found = read_exploration_text(SourceFile(Path(name), name, text), findings)
    return found, findings.diagnostics


def test_an_exploration_is_read_with_everything_in_the_order_of_the_file() -> None:
    found, diagnostics = read(PLUCKS)
    assert found is not None and not diagnostics
    assert found.name == "plucks"
    assert isinstance(found.trial, FunctionTrial) and found.trial.name == "plucked_string/Pluck"
    assert [(each.name, each.lower, each.upper, each.unit) for each in found.parameters] == [
        ("eta", 0.0, 1.0, ""),
        ("deflection", -0.008, 0.014, "m"),
    ]
    assert [(each.name, each.values) for each in found.cases] == [
        ("string", ("d4", "f#4")),
        ("direction", ("in", "out")),
    ]
    assert [(each.name, each.unit) for each in found.outcomes] == [("loudness", "dB")]
    assert (found.scale, found.noise, found.alpha, found.invalid_budget) == (0.12, 0.15, 0.7, 0.2)
    assert found.start == {"eta": 0.5, "deflection": 0.0}
    assert found.retry == {"no_onset": {"deflection": 0.001}, "too_hard": {"deflection": -0.001}}
    assert (found.parameters[1].place.line, found.parameters[1].place.column) == (5, 3)


def test_what_is_not_given_is_none_or_empty() -> None:
    found, diagnostics = read("exploration: e\nparameters: {x: {from: 0, to: 1}}\noutcomes: {cost: }\n")
    assert found is not None and not diagnostics
    assert (found.trial, found.start, found.cases, found.retry) == (None, None, (), {})
    assert (found.scale, found.noise, found.alpha, found.invalid_budget) == (None, None, None, None)


def test_a_trial_that_plans_a_task_has_paths_from_the_file_on_and_references() -> None:
    found, diagnostics = read(REACH, "deep/inside/e.yaml")
    assert found is not None and not diagnostics
    trial = found.trial
    assert isinstance(trial, TaskTrial)
    assert (trial.task, trial.scene) == (Path("deep/inside/task.yaml"), Path("deep/scene.yaml"))
    assert (trial.jobs, trial.max_solutions) == (300, 1)
    references = [
        reference_of(word)
        for written in trial.properties.values()
        for word in words_of(written)
        if reference_of(word)
    ]
    assert references == [TrialReference("PARAMETER", "x"), TrialReference("CASE", "object")]
    assert read(REACH.replace("  jobs: 300\n", ""))[0].trial.jobs == DEFAULT_JOBS  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"),
    [
        ("exploration: plucks\n", "", 'an exploration needs the key "exploration"', None),
        ("trial: pl", "«trail»: pl", 'unknown key "trail" of an exploration', 'did you mean "trial"?'),
        ("trial: plucked_string/Pluck", "«trial»:", "`trial` has no value", "leave the key out if trials are made elsewhere, and told"),
        ("trial: plucked_string/Pluck", "trial: «[a]»", "`trial` must be one trial, this is a list", "write the name of a registered function"),
        ("trial: plucked_string/Pluck", 'trial: «" a"»', "`trial` is no word: ' a'", "one line of at most 80 characters"),
        ("{from: 0, to: 1}", "{from: 0, to: «0.0»}", 'the parameter "eta": its bounds are equal: 0; a parameter that does not vary is none', None),
        ("{from: 0, to: 1}", "{from: 1, to: «0»}", 'the parameter "eta": its bounds are the wrong way round: from 1 to 0', None),
        ("{from: 0, to: 1}", "{from: -1e308, to: «1e308»}", 'the parameter "eta": its bounds reach beyond 1e+100', None),
        ("{from: 0, to: 1}", "{from: 1, to: «1.0000000001»}", 'the parameter "eta": its bounds are equal but for rounding: 1.0 and 1.0000000001', None),
        ("{from: 0, to: 1}", "{from: «nan», to: 1}", '`from` of the parameter "eta" must be a number, this is "nan"', None),
        ("{from: 0, to: 1}", "{from: 0, to: «.inf»}", '`to` of the parameter "eta" must be a number, this is ".inf"', None),
        ("{from: 0, to: 1}", "{from: 0, to: «1e999»}", '`to` of the parameter "eta" is too large to be a number', None),
        ("  «eta»: {from: 0, to: 1}", "  «eta»: {from: 0}", 'the parameter "eta" needs the key "to"', None),
        ("  «eta»: {from: 0, to: 1}", "  «eta»: 3", 'the parameter "eta" needs its bounds: {from: 0, to: 1, unit: m}', None),
        ("{from: 0, to: 1}", "{from: 0, to: 1, «units»: m}", 'unknown key "units" of the parameter "eta"', 'did you mean "unit"?'),
        ("{loudness: ", "{«Loudness»: ", '"Loudness" cannot be the name of an outcome', 'write "loudness"'),
        ("[d4, f#4]", "[d4, f#4, «d4»]", 'the case variable "string" has the value "d4" twice', None),
        ("{string: [d4, f#4], ", "{«string»: [], ", 'the case variable "string" has no values', "write them as a list: string: [first, second]"),
        ("{string: [", "{«eta»: [", '"eta" is both a parameter and a case variable', None),
        ("[d4, f#4]", '[d4, «""»]', 'a value of the case variable "string" is empty', None),
        ("outcomes: {loudness: {unit: dB}}", "outcomes: «{}»", "an exploration needs at least one outcome: {torque: {unit: Nm}}", None),
        ("{unit: dB}", "{«uint»: dB}", 'unknown key "uint" of the outcome "loudness"', 'did you mean "unit"?'),
        ("scale: 0.12", "scale: «0»", "`scale` of `validity` must be greater than 0", None),
        ("noise: 0.15", "noise: «50»", "`noise` of `validity` must lie between 0.01 and 10, this is 50", None),
        ("alpha: 0.7", "alpha: «1»", "`alpha` must be at least 0.5 and less than 1, this is 1", "only parameters that are more probably valid"),
        ("alpha: 0.7", "«alhpa»: 0.7", 'unknown key "alhpa" of `validity`', 'did you mean "alpha"?'),
        ("invalid_budget: 0.2", "invalid_budget: «1.5»", "`invalid_budget` must lie between 0 and 1, this is 1.5", "it is the share of invalid trials"),
        ("start: {eta: 0.5", "start: {eta: «1.5»", '"eta" of `start` is 1.5, outside its bounds 0 to 1', None),
        ("start: {eta: 0.5, deflection: 0.0}", "«start»: {eta: 0.5}", '`start` lacks the parameter "deflection"', None),
        ("start: {eta: 0.5", "start: {eta: 0.5, «eat»: 3", '`start` names "eat", which is no parameter', 'did you mean "eta"?'),
        ("start: {eta: 0.5, deflection: 0.0}", "start: «5»", "`start` must name parameters with numbers: {along: 0.01}", None),
        ("{deflection: 0.001}", "{«deflektion»: 0.001}", '`retry` after "no_onset" names "deflektion", which is no parameter', 'did you mean "deflection"?'),
        ("{deflection: 0.001}", "{deflection: «0»}", 'the change of "deflection" after "no_onset" is 0, which changes nothing', None),
        ("{deflection: 0.001}", "{deflection: «1»}", 'the change of "deflection" after "no_onset" is larger than its range', "its bounds are -0.008 to 0.014"),
        ("{no_onset: {deflection: 0.001}", "{«no_onset»: {}", '`retry` after "no_onset" must name parameters with numbers: {along: 0.01}', None),
    ],
)  # fmt: skip
def test_a_mistake_is_told_at_its_place_with_the_remedy(
    old: str, new: str, message: str, hint: str | None
) -> None:
    old = old.replace("«", "").replace("»", "")
    assert PLUCKS.count(old) == 1
    check_one(PLUCKS.replace(old, new), message, hint)


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"),
    [
        ("  task: task.yaml\n", "", 'a trial that plans a task needs the key "task"', None),
        ("  jobs: 300", "  «job»: 300", 'unknown key "job" of a trial that plans a task', 'did you mean "jobs"?'),
        ("  jobs: 300", "  jobs: «0»", '`jobs` must be a whole number from 1 on, not "0"', None),
        ("[<PARAMETER:x>, 0", "[«<PARAMETER:z>», 0", 'there is no parameter "z"', "there are x"),
        ("[<PARAMETER:x>, 0", "[«<PARAMETR:x>», 0", '"<PARAMETR:x>" is no reference', "references are <PARAMETER:name> and <CASE:name>"),
        ("[<PARAMETER:x>, 0", "[«<INTERFACE:x>», 0", '"<INTERFACE:x>" is no reference', "references are"),
        ("object: <CASE:object>", "object: «<CASE:objekt>»", 'there is no case variable "objekt"', 'did you mean "object"?'),
        ("object: <CASE:object>", "object: «<PARAMETER:object>»", 'there is no parameter "object"', "there are x"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_trial_that_plans_a_task_is_told_at_its_place(
    old: str, new: str, message: str, hint: str | None
) -> None:
    assert REACH.count(old) == 1
    check_one(REACH.replace(old, new), message, hint)


def check_one(marked: str, message: str, hint: str | None) -> None:
    start = marked.find("«")
    text = marked.replace("«", "").replace("»", "")
    (one,) = read(text)[1]
    assert one.message == message
    assert (one.hint or "").startswith(hint or "") and (one.hint is None) == (hint is None)
    if start >= 0:
        assert (one.line, one.column) == (text.count("\n", 0, start) + 1, start - text.rfind("\n", 0, start))


def test_all_mistakes_are_told_at_once() -> None:
    text = PLUCKS.replace("to: 1}", "to: 0}").replace("alpha: 0.7", "alpha: 3").replace("[in, out]", "[in, in]")
    assert len(read(text.replace("unit: dB", "uint: dB"))[1]) == 4


@pytest.mark.parametrize("count", [6, 7, 12])
def test_more_than_six_parameters_are_refused(count: int) -> None:
    ranges = ", ".join(f"p{number}: {{from: 0, to: 1}}" for number in range(count))
    _, found = read(f"exploration: e\nparameters: {{{ranges}}}\noutcomes: {{cost: }}\n")
    assert [each.message for each in found] == (
        [] if count == 6 else [f"an exploration has at most 6 parameters, these are {count}"]
    )


def test_too_many_cases_are_refused_before_they_are_counted_out() -> None:
    values = ", ".join(map(str, range(30)))
    variables = ", ".join(f"v{number}: [{values}]" for number in range(9))
    _, found = read(
        f"exploration: e\nparameters: {{x: {{from: 0, to: 1}}}}\ncases: {{{variables}}}\noutcomes: {{c: }}\n"
    )
    assert [each.message for each in found] == [
        f"these are {30**9} cases, at most 10000 can be explored: each has a model of its own"
    ]


def test_check_knows_explorations_by_their_keys(tmp_path: Path) -> None:
    file = tmp_path / "e.yaml"
    file.write_text(PLUCKS)
    assert is_exploration(file) and not check_files([file])
    file.write_text(PLUCKS.replace("exploration: plucks\n", ""))
    (one,) = check_files([file])
    assert one.message == 'an exploration needs the key "exploration"'
    assert not is_exploration(tmp_path / "none.yaml")


@given(
    st.lists(
        st.sampled_from([*PLUCKS.splitlines(), *REACH.splitlines(), "cases: {a: {b: c}}", "start: [1]", "retry: 3",
                         "validity: [1]", "parameters: [x]", "outcomes: [y]", "trial: {}", "? [a]", "x: &a [*a]"])
    )
)  # fmt: skip
def test_lines_in_any_order_are_read_without_an_exception(lines: list[str]) -> None:
    found, diagnostics = read("\n".join(lines))
    assert found is not None or diagnostics
