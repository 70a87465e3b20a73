import json

import jsonschema
import pytest

from kabo.errors import InputError
from kabo.plan import plan_from_json, plan_to_json, schema

MOTION, LEARNED = "$.nodes.n1.motion[0]", "$.nodes.n1.learned"


def spoiled(plan, *path, to=None, drop=False) -> bytes:
    """The plan's file with one value replaced, or one key taken away."""
    value = json.loads(plan_to_json(plan))
    inner = value
    for step in path[:-1]:
        inner = inner[step]
    if drop:
        del inner[path[-1]]
    else:
        inner[path[-1]] = to
    return json.dumps(value).encode()


def said(content: bytes) -> str:
    with pytest.raises(InputError) as caught:
        plan_from_json(content, file="p.json")
    return str(caught.value)


CASES = [
    (("format",), "kabo-plan/9", '$.format: expected "kabo-plan/2"'),
    (("root",), 3, "$.root: expected a text, found 3"),
    (("root",), "first", '$.root: "first" is no node id'),
    (("nodes", "n1", "kind"), "acton", 'did you mean "action"?'),
    (("nodes", "n1", "next"), None, "$.nodes.n1.next: expected a text, found null"),
    (("nodes", "n1", "motion"), [], "$.nodes.n1.motion: expected at least 1, found 0"),
    (("nodes", "n1", "motion", 0, "times"), [0, "1"], f'{MOTION}.times[1]: expected a finite number, found "1"'),
    (("nodes", "n1", "motion", 0, "times"), [0, -1], f"{MOTION}.times[1]: a time is never negative"),
    (("nodes", "n1", "motion", 0, "times"), [0, 1, 2], f"{MOTION}.times: 3 times for 2 way points"),
    (
        ("nodes", "n1", "motion", 0, "waypoints"),
        [[0, 1], [2]],
        f"{MOTION}.waypoints[1]: expected 2 entries, found 1",
    ),
    (
        ("nodes", "n1", "motion", 0, "allowed_contacts"),
        [["a"]],
        f"{MOTION}.allowed_contacts[0]: expected 2 entries",
    ),
    (("nodes", "n1", "motion", 0, "speed"), 1, 'unknown key "speed"'),
    (("nodes", "n1", "overlap"), 0, "$.nodes.n1.overlap: an overlap is a span of time above 0"),
    (("nodes", "n3", "overlap"), 1.0, "$.nodes.n3: unknown key"),
    (("nodes", "n1", "learned"), [], "$.nodes.n1.learned: expected at least 2, found 0"),
    (("nodes", "n1", "learned"), 3, "$.nodes.n1.learned: expected an object, found 3"),
    (("nodes", "n1", "learned", "model"), "", f"{LEARNED}.model: expected the path of a model file"),
    (("nodes", "n1", "learned", "validity"), 0, f"{LEARNED}.validity: a validity is a probability above 0"),
    (("nodes", "n1", "learned", "validity"), 1.01, f"{LEARNED}.validity: a validity is a probability above 0"),
    (("nodes", "n1", "learned", "parameters"), {}, f"{LEARNED}.parameters: expected at least one parameter"),
    (
        ("nodes", "n1", "learned", "parameters", "along"),
        "1",
        f"{LEARNED}.parameters.along: expected a finite number",
    ),
    (
        ("nodes", "n1", "learned", "expected", "torque"),
        None,
        f"{LEARNED}.expected.torque: expected a finite number",
    ),
    (("nodes", "n1", "learned", "case", "cup"), 3, f"{LEARNED}.case.cup: expected a text, found 3"),
    (("nodes", "n1", "learned", "trials"), 60, 'unknown key "trials"'),
    (("nodes", "n3", "learned"), {}, '$.nodes.n3: unknown key "learned"'),
    (("nodes", "n1", "after"), {}, "$.nodes.n1.after: nothing changes"),
    (("nodes", "n1", "after", "objects", "cup", "quaternion"), [0, 0, 0, 2], "has length 1"),
    (("nodes", "n0", "branches"), {}, "$.nodes.n0.branches: a node that branches has at least one branch"),
    (("nodes", "n2", "delivers"), [], "$.nodes.n2.delivers: expected at least 1, found 0"),
    (("problem", "files", "domain.yaml"), "md5:12", '$.problem.files.domain.yaml: "md5:12" is no hash'),
    (("options", "seed"), -1, "$.options.seed: expected a number 0, 1, 2, …, found -1"),
    (("options", "geometry"), "rough", '$.options.geometry: "rough" is none of bounding, exact, none'),
    (("nodes",), [], "$.nodes: expected an object, found a list"),
    (("nodes",), {}, "$.nodes: a plan has at least one node"),
]


@pytest.mark.parametrize(("path", "value", "message"), CASES)
def test_what_is_wrong_is_said_with_its_path(plan, path, value, message):
    assert message in said(spoiled(plan, *path, to=value))


MISSING = [("root",), ("nodes", "n1", "next"), ("nodes", "n1", "motion", 0, "constraint")]
MISSING += [("nodes", "n1", "learned", key) for key in ("model", "case", "parameters", "validity", "expected")]


@pytest.mark.parametrize("path", MISSING)
def test_missing_keys_are_named(plan, path):
    assert f'"{path[-1]}" is missing' in said(spoiled(plan, *path, drop=True))


def test_all_findings_come_at_once(plan):
    value = json.loads(plan_to_json(plan))
    value["root"], value["nodes"]["n1"]["action"], value["options"]["seed"] = 1, 2, "three"
    text = said(json.dumps(value).encode())
    assert all(place in text for place in ("$.root", "$.nodes.n1.action", "$.options.seed"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not JSON"),
        (b'{"a":', "not JSON"),
        (b"\xff\xfe", "not UTF-8"),
        (b"[" * 100_000, "nested deeper than 40"),
        (b'{"a":' * 100_000, "nested deeper than 40"),
        (b'{"format":"kabo-plan/1","format":"kabo-plan/1"}', 'the key "format" stands twice'),
        (b'{"x":NaN}', "$.x: NaN is no number of JSON"),
        (
            b'{"format":"kabo-plan/2","nodes":{"n0":{"after":[1,-Infinity]}}}',
            "$.nodes.n0.after[1]: -Infinity is no",
        ),
        (b'{"x":' + b"9" * 5000 + b"}", "not usable as JSON"),
        (b"[]", "$: expected an object, found a list"),
    ],
)
def test_files_that_are_no_json_objects_are_refused_and_never_crash(content, message):
    assert message in said(content)


def test_what_the_reader_refuses_in_form_the_schema_refuses_too(plan):
    """But times without way points, and hashes of quaternions, which JSON Schema cannot say."""
    validator = jsonschema.Draft202012Validator(schema("kabo-plan-2"))
    beyond = ("3 times for 2", "expected 2 entries, found 1", "has length 1")
    for path, value, message in CASES:
        if not any(text in message for text in beyond):
            assert not validator.is_valid(json.loads(spoiled(plan, *path, to=value))), message


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("kabo-task/2", "this is a report of a task\n      = kabo task export makes a plan of a solution in it"),
        ("kabo-task/1", "this is a report of a task"),
        ("kabo-state/1", "this is the state of a run"),
    ],
)
def test_another_file_of_kabo_is_one_finding_that_says_what_it_is(name, message):
    content = json.dumps({"format": name, "task": "pick", "runs": [], "stages": {}})
    assert said(content.encode()).startswith("p.json:1:1: a plan is needed here, " + message)
    assert "unknown key" not in said(content.encode())
