"""The answers of `kabo explore`: every one has the form of its schema, which is that of the code."""

import json
from pathlib import Path

import jsonschema

import kabo
from kabo.exploration import Exploration, NoParametersError, Space
from kabo.trials.answers import (
    ANSWERS,
    ask_answer,
    infer_answer,
    nothing_answer,
    run_answer,
    schema,
    show_answer,
    tell_answer,
)
from tests.support.discs import explored

SCHEMA = Path(kabo.__file__).parent / "plan" / "schemas" / "kabo-explore-1.schema.json"


def test_the_schema_is_that_of_the_code():
    assert json.loads(SCHEMA.read_text()) == schema()


def kinds(answer):
    """The answers whose form an object has."""
    found = []
    for each in ANSWERS:
        whole = {**schema(), "anyOf": [{"$ref": f"#/$defs/{each.__name__}"}]}
        if jsonschema.Draft202012Validator(whole).is_valid(answer):
            found.append(each.__name__)
    return found


def test_each_answer_has_the_form_of_one_kind_alone():
    made = explored(30)
    error = NoParametersError("out_of_range", "too far", made.infer({"torque": 0.5}))
    answers = {
        "Shown": show_answer(made, "m.jsonl"),
        "Ran": run_answer(made, "m.jsonl", 30, None, None),
        "Asked": ask_answer(made, made.ask()),
        "Told": tell_answer(made, made.trials[-1]),
        "InferredAnswer": infer_answer(made.infer({"torque": 0.5})),
        "Nothing": nothing_answer("infer", error),
    }
    for name, answer in answers.items():
        assert kinds(json.loads(json.dumps(answer))) == [name]
    assert len(answers) == len(ANSWERS)


def test_an_exploration_without_trials_has_answers_too():
    made = Exploration(Space({"a": (0.0, 1.0)}, {"k": ["x", "y"]}), ["o"])
    answer = show_answer(made, "m.jsonl")
    assert kinds(json.loads(json.dumps(answer))) == ["Shown"]
    assert [each["trials"] for each in answer["cases"]] == [0, 0]
