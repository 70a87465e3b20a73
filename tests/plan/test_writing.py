import hashlib
import json
from dataclasses import replace

import jsonschema
import pytest

from kabo.plan import (
    Certificate,
    Clearance,
    plan_from_json,
    plan_hash,
    plan_to_json,
    schema,
    write_plan,
)
from kabo.whole_files import write_atomically


def test_the_file_is_canonical_and_fits_the_schema(plan):
    content = plan_to_json(plan)
    assert content.endswith(b"}\n") and content.count(b"\n") == 1 and b": " not in content and b", " not in content
    value = json.loads(content)
    assert json.dumps(value, sort_keys=True, separators=(",", ":")).encode() + b"\n" == content
    jsonschema.Draft202012Validator(schema("kabo-plan-2")).validate(value)


def test_writing_and_reading_gives_the_same_plan(plan):
    certified = replace(
        plan, certificate=Certificate(0.02, (Clearance("n1", 0, 0.01, ("a", "b"), (("c", "d"),)),))
    )
    for one in (plan, certified):
        assert plan_from_json(plan_to_json(one)) == one


def test_numbers_are_rounded_and_never_negative_zero(plan):
    name = next(n for n, node in plan.nodes.items() if node.motion)
    node = plan.nodes[name]
    rough = replace(node.motion[0], waypoints=((-0.0, 1.0), (0.50000000049, -1e-12)), times=(0.0, 0.4999999))
    content = plan_to_json(replace(plan, nodes={**plan.nodes, name: replace(node, motion=(rough,))}))
    assert b'"waypoints":[[0.0,1.0],[0.5,0.0]]' in content
    assert b'"times":[0.0,0.5]' in content
    assert b"-0.0," not in content and b"-0.0]" not in content


def test_one_record_of_what_was_learned_is_an_object_and_several_are_a_list(plan):
    node = plan.nodes["n1"]
    assert json.loads(plan_to_json(plan))["nodes"]["n1"]["learned"]["validity"] == 0.97
    other = replace(
        node.learned[0], validity=0.1 + 0.2, parameters={"along": -0.0}, expected={"torque": 1e-20 / 3}
    )
    two = replace(plan, nodes={**plan.nodes, "n1": replace(node, learned=(*node.learned, other))})
    jsonschema.validate(json.loads(plan_to_json(two)), schema("kabo-plan-2"))
    assert b'"parameters":{"along":0.0},"validity":0.3}' in plan_to_json(two)
    assert b'"torque":3.33333333e-21' in plan_to_json(two)
    again = plan_from_json(plan_to_json(two))
    assert plan_to_json(again) == plan_to_json(two) and len(again.nodes["n1"].learned) == 2
    none = replace(plan, nodes={**plan.nodes, "n1": replace(node, learned=())})
    assert b"learned" not in plan_to_json(none)


def test_numbers_that_are_not_finite_are_refused(plan):
    for wrong in (float("nan"), float("inf")):
        with pytest.raises(ValueError):
            plan_to_json(replace(plan, options={**plan.options, "epsilon": wrong}))


def test_the_hash_is_that_of_the_file(plan, tmp_path):
    path = tmp_path / "plan.json"
    said = write_plan(plan, path)
    assert said == plan_hash(plan) == "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest()
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


def test_a_file_that_cannot_be_written_leaves_the_old_one_and_nothing_else(tmp_path):
    path = tmp_path / "plan.json"
    write_atomically(path, b"old")
    with pytest.raises(TypeError):
        write_atomically(path, "text is not bytes")
    assert path.read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 1


def test_every_schema_is_a_schema():
    for name in ("kabo-plan-1", "kabo-plan-2", "kabo-result-1", "kabo-explain-1"):
        jsonschema.Draft202012Validator.check_schema(schema(name))
    with pytest.raises(FileNotFoundError):
        schema("kabo-plan-3")
