"""No argument of a stage does nothing without a word: what means nothing is refused with its name, or is documented.

Every stage and every property is gone through with empty and degenerate values. A value of the declared type is either
refused by name, or the property's own text says what it means.
"""

import math
from pathlib import Path
from typing import Any

import pytest

from kabo.errors import InputError
from kabo.tasks.core import Property, Stage
from kabo.tasks.files import load_task_file
from kabo.tasks.files.checking import declared_by
from kabo.tasks.files.registry import find, names
from kabo.tasks.robots import STAGES

DEGENERATE: list[Any] = ["", " ", [], {}, (), 0, 0.0, -1, -0.5, math.nan, math.inf, [""], [0, 0], [0, 0, 0], [1]]
DEGENERATE += [{"vector": [0, 0]}, {"vector": [0, 0, 0]}, {"twist": [0.0] * 6}, {"joints": {}}, {"nothing": 1}]

# What a value that is let through means, by a phrase of the property's own text; each stands for a class of values.
DOCUMENTED = {
    "empty": ("empty:", "an empty name"),
    "zero": ("0:", "0 ", "as the scene"),
}
# Properties whose values are data for Python functions, or read where they are used, with places: see the tests below.
READ_LATER = {
    ("FixedState", "scene"),  # a scene made in Python
    ("FixedState", "configurations"),  # names of robots: looked up when planning begins
    ("ComputeIK", "target"),  # what a sampler has written
    ("MoveTo", "goal"),  # names and joints of a robot: looked up where the robot is known
    ("SampleConfiguration", "configurations"),
    ("Reparameterise", "acceleration"),
    ("AddGeometry", "pose"),
    ("GraspPoses", "grasp"),
    ("PlacePoses", "pose"),
    ("PoseGenerator", "poses"),
    ("MonitoredPoses", "poses"),
}


def cases() -> list[Any]:
    found = []
    for name in sorted(STAGES):
        for key, declared in declared_by(STAGES[name]).items():
            found += [
                pytest.param(name, key, value, id=f"{name}-{key}-{value!r}")
                for value in DEGENERATE
                if fits(declared, value)
            ]
    return found


def fits(declared: Property, value: Any) -> bool:
    return declared.accepts(value)


@pytest.mark.parametrize(("name", "key", "value"), cases())
def test_a_degenerate_value_is_refused_by_name_or_documented(name: str, key: str, value: Any) -> None:
    declared = declared_by(STAGES[name])[key]
    fault = declared.fault(value)
    if fault is not None:
        assert fault.split()[0] in ("is", "has", "names", "goes"), "it follows the property's name"
        assert "\n" not in fault
        return
    empty = isinstance(value, str | list | tuple | dict) and not (
        value.strip() if isinstance(value, str) else value
    )
    if isinstance(value, bool) or (name, key) in READ_LATER and not empty:
        return
    if (name, key) in READ_LATER and key in ("scene", "target"):
        return
    kind = "empty" if empty else "zero"
    assert any(phrase in declared.doc for phrase in DOCUMENTED[kind]), f"{value!r} is let through: {declared.doc}"


def test_every_property_that_may_be_absent_says_what_that_means() -> None:
    silent = [
        f"{name}.{key}: {declared.doc}"
        for name in sorted(STAGES)
        for key, declared in declared_by(STAGES[name]).items()
        if declared.default is None and not any(word in declared.doc for word in ("none", "None"))
    ]
    assert silent == []


# ------------------------------------------------------------------------------ the same through files, at its place
def refused(folder: Path, stage: str) -> str:
    path = folder / "t.yaml"
    path.write_text(f"name: t\nstages:\n  - {{name: now, stage: CurrentState}}\n  - {stage}\n")
    with pytest.raises(InputError) as told:
        load_task_file(path)
    assert "t.yaml:4:" in str(told.value)
    return str(told.value)


@pytest.mark.parametrize(
    ("stage", "told"),
    [
        ("{name: s, stage: MoveRelative, robot: arm, direction: {vector: [0, 0]}}", "a vector that is 3 numbers"),
        (
            "{name: s, stage: MoveRelative, robot: arm, direction: {vector: [0, 0, 0]}}",
            '"direction" of "s" has no length',
        ),
        ("{name: s, stage: MoveRelative, robot: arm, direction: {joints: {}}}", "has no joints to move"),
        ("{name: s, stage: MoveTo, robot: arm, goal: home, group: hand}", '"group" of "s" is arm or gripper'),
        ("{name: s, stage: MoveTo, robot: arm, goal: home, if_missing: stop}", "fail or stay"),
        (
            "{name: s, stage: MoveTo, robot: arm, goal: {j1: .nan}}",
            "a value of j1 that is a finite number, not '.nan'",
        ),
        (
            "{name: s, stage: MoveTo, robot: arm, goal: {pse: {position: [0, 0, 1]}}}",
            "no 'pse', did you mean \"pose\"?",
        ),
        (
            "{name: s, stage: MoveRelative, robot: arm, direction: {vector: [0, 0, 1], fram: world}}",
            "no 'fram' beside 'vector', did you mean \"frame\"?",
        ),
        ("{name: s, stage: MoveRelative, robot: arm, direction: up}", "{vector: [x, y, z], frame}"),
        ("{name: s, stage: MoveTo, robot: arm, goal: [0, up]}", '"goal" of "s" is 2 finite numbers'),
        ("{name: s, stage: AllowContact, pairs: []}", '"pairs" of "s" has no pairs'),
        ("{name: s, stage: AllowContact, pairs: [[a, b]], links: touching}", "all or touch"),
        ("{name: s, stage: Wait, robot: '', duration: 1}", '"robot" of "s" names nothing'),
        ("{name: s, stage: Wait, robot: arm, duration: -1}", "at least 0"),
        ("{name: s, stage: AddGeometry, body: b, shape: {box: [1, 1, 0]}}", "sizes above 0"),
        ("{name: s, stage: Limit, max_solutions: -1, wrapped: {name: n, stage: NoOp}}", "at least 0, not -1"),
    ],
)
def test_a_file_is_told_where_its_value_means_nothing(tmp_path: Path, stage: str, told: str) -> None:
    assert told in refused(tmp_path, stage)


def test_every_stage_of_files_is_one_of_those_gone_through_or_holds_stages() -> None:
    ours = [(name, find(name) or Stage) for name in names() if name not in STAGES]
    others = {name for name, kind in ours if kind.__module__.startswith("kabo.")}
    elsewhere = {"LearnedParameters"}  # tests/tasks/files/test_learned_files.py
    assert others == {"SerialContainer", "Alternatives", "Fallbacks", "Limit", *elsewhere}
