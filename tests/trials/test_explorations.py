"""Explorations of files: every option arrives, a start is assumed where kabo makes the trials, other files are refused."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.exploration import NoParametersError
from kabo.language.exploration_description import ExplorationDescription
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.yaml.exploration_file import read_exploration_text
from kabo.trials import exploration_of, require_same

TEXT = """\
exploration: lift
trial: bars/Lift
parameters: {along: {from: -0.08, to: 0.08, unit: m}, force: {from: 1, to: 41}}
cases: {bar: [steel, wood]}
outcomes: {torque: {unit: Nm}, tilt: }
validity: {scale: 0.2, noise: 0.1, alpha: 0.8}
invalid_budget: 0.3
start: {along: 0.01, force: 12}
retry: {dropped: {force: 3}}
"""


def described(text: str) -> ExplorationDescription:
    findings = Findings()
    found = read_exploration_text(SourceFile(Path("e.yaml"), "e.yaml", text), findings)
    assert found is not None and not findings.errors, findings.diagnostics
    return found


def test_every_option_of_a_file_arrives() -> None:
    assert exploration_of(described(TEXT), seed=7).header == {
        "format": "kabo-exploration/1",
        "name": "lift",
        "space": {
            "parameters": {"along": {"from": -0.08, "to": 0.08, "unit": "m"}, "force": {"from": 1.0, "to": 41.0}},
            "cases": {"bar": ["steel", "wood"]},
        },
        "outcomes": {"torque": {"unit": "Nm"}, "tilt": {}},
        "validity": {"scale": 0.2, "noise": 0.1, "alpha": 0.8},
        "invalid_budget": 0.3,
        "start": {"along": 0.01, "force": 12.0},
        "retry": {"dropped": {"force": 3.0}},
        "seed": 7,
    }
    assert exploration_of(described(TEXT), invalid_budget=0.1).invalid_budget == 0.1


def test_without_a_start_kabo_begins_in_the_middle_but_asks_nobody_else_to() -> None:
    text = TEXT.replace("start: {along: 0.01, force: 12}\n", "")
    assert exploration_of(described(text)).ask({"bar": "wood"}).parameters == {"along": 0.0, "force": 21.0}
    told = exploration_of(described(text.replace("trial: bars/Lift\n", "")))
    with pytest.raises(NoParametersError) as caught:
        told.ask({"bar": "wood"})
    assert caught.value.reason == "not_explored"


def test_a_model_of_the_same_file_may_be_gone_on_with_whatever_its_seed_and_budget() -> None:
    file = described(TEXT)
    require_same(file, exploration_of(file, seed=3, invalid_budget=0.2))
    require_same(file, exploration_of(file, seed=3, invalid_budget=0.2), seed=3, invalid_budget=0.2)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("from: 1,", "from: 2,", "space"),
        ("[steel, wood]", "[steel]", "space"),
        ("alpha: 0.8", "alpha: 0.7", "validity"),
        ("unit: Nm", "unit: mNm", "outcomes"),
        ("exploration: lift", "exploration: hold", "name"),
        ("force: 12}", "force: 13}", "start"),
        ("{force: 3}", "{force: 4}", "retry"),
    ],
)
def test_a_model_of_another_file_is_refused_with_what_differs(old: str, new: str, what: str) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(InputError, match=rf"e\.yaml:1:14: the model was made with another {what}\n"):
        require_same(described(TEXT.replace(old, new)), exploration_of(described(TEXT)))


def test_another_seed_or_budget_than_the_models_is_refused_if_it_is_asked_for() -> None:
    file = described(TEXT)
    with pytest.raises(InputError, match="another seed"):
        require_same(file, exploration_of(file, seed=3), seed=4)
    with pytest.raises(InputError, match="another invalid_budget"):
        require_same(file, exploration_of(file, invalid_budget=0.2), invalid_budget=0.1)


NUMBERS = st.sampled_from(
    ["0", "1", "-1", "0.5", "0.99", "1e-300", "-5e-324", "1e300", "1e100", "1.7e308", "3", "1e-12", "0.01", "10"]
)


@given(st.data())
def test_whatever_the_reader_accepts_is_an_exploration_that_can_be_asked(data: st.DataObject) -> None:
    lower, upper, scale, noise, alpha, budget, start, change = (data.draw(NUMBERS) for _ in range(8))
    text = f"""\
exploration: e
trial: t
parameters: {{x: {{from: {lower}, to: {upper}}}}}
outcomes: {{c: }}
validity: {{scale: {scale}, noise: {noise}, alpha: {alpha}}}
invalid_budget: {budget}
start: {{x: {start}}}
retry: {{fell: {{x: {change}}}}}
"""
    findings = Findings()
    for line in data.draw(st.sets(st.sampled_from(["validity", "invalid_budget", "start", "retry"]))):
        text = "\n".join(each for each in text.split("\n") if not each.startswith(line))
    found = read_exploration_text(SourceFile(Path("e.yaml"), "e.yaml", text), findings)
    if found is None or findings.errors:
        return
    exploration = exploration_of(found)
    for valid in (False, True):
        parameters = exploration.ask().parameters
        exploration.tell({}, parameters, valid, {"c": 1.0} if valid else None, "" if valid else "fell")
