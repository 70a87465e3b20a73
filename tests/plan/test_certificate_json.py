"""The certificate in the plan's file: kept byte for byte, and what is wrong in its form is told with its place."""

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from kabo.errors import InputError
from kabo.plan import (
    BodyParts,
    Certificate,
    Clearance,
    PairProof,
    Plan,
    StretchProof,
    plan_from_json,
    plan_to_json,
    schema,
)

MESH = "sha256:" + "c" * 64
AXES = np.array([1, -2, 3], "<i2").tobytes() + np.array([0.1, 0.2, -0.3], "<f8").tobytes()


@pytest.fixture
def certified(plan: Plan) -> Plan:
    parts = BodyParts((1, 2), np.arange(9, dtype="<f8").tobytes())
    pair = PairProof("arm.finger", "cup", 1, "tafbe", AXES)
    told = Clearance("n1", 0, 0.005, ("arm.finger", "cup"), (("cup", "table"),))
    made = Certificate(0.02, (told,), 0.01, {MESH: parts}, (StretchProof("n1", (0, 1), (pair,)),))
    return replace(plan, certificate=made)


def test_it_is_read_as_it_was_written(certified):
    content = plan_to_json(certified)
    assert plan_from_json(content) == certified
    jsonschema.Draft202012Validator(schema("kabo-plan-2")).validate(json.loads(content))


def test_an_old_certificate_is_read_as_before(certified):
    old = replace(certified, certificate=Certificate(0.02, certified.certificate.segments))
    written = json.loads(plan_to_json(old))["certificate"]
    assert set(written) == {"epsilon", "segments"} and plan_from_json(plan_to_json(old)) == old


WRONG = {
    "base64": (("bodies", MESH, "vertices"), "?", "is not base64"),
    "half a vertex": (("bodies", MESH, "vertices"), "AAAA", "no whole number"),
    "sizes": (("bodies", MESH, "sizes"), [1, 1], "3 vertices, but 2"),
    "letters": (("proofs", 0, "pairs", 0, 3), "tax", "letters of a walk"),
    "too few axes": (("proofs", 0, "pairs", 0, 3), "ta", "30 bytes for axes that need 6"),
    "thing": (("proofs", 0, "pairs", 0, 1), 7, "there are 2 things"),
    "pair": (("proofs", 0, "pairs", 0), [0, 1], "5 entries"),
    "near": (("near",), -1.0, "a distance above 0"),
    "number": (("near",), "x", "a finite number"),
    "node": (("proofs", 0, "node"), "m1", "no node id"),
    "nothing": (("proofs",), None, "a list"),
}


@pytest.mark.parametrize(("path", "value", "message"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_told_with_its_place(certified, path, value, message):
    content = json.loads(plan_to_json(certified))
    inner = content["certificate"]
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    with pytest.raises(InputError) as caught:
        plan_from_json(json.dumps(content).encode())
    assert message in str(caught.value) and "$.certificate" in str(caught.value)


def test_half_a_certificate_is_refused(certified):
    content = json.loads(plan_to_json(certified))
    del content["certificate"]["things"]
    with pytest.raises(InputError, match="things"):
        plan_from_json(json.dumps(content).encode())
