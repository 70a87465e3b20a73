"""Round parts in certificates: proofs of them hold, a little less than what was proven does not, and nothing is missing."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry import Enclosure
from kabo.geometry.collision.separation_proofs import Unproven
from kabo.meshes import Mesh, Rounding
from kabo.plan import BodyParts, Certificate
from kabo.plan.certificate_json import certificate_from_json, certificate_to_json
from kabo.plan.checked_json import JsonValue
from kabo.scene import Element
from kabo.verify.certificate.exact import ExactFrames, ExactSide
from kabo.verify.certificate.pair_proof import ProvenPair, Refuted
from tests.properties.test_certificates import scenery
from tests.verify.certified import CUBE, FACES, Parts, Scenery, sought

KINDS = ("sphere", "capsule", "cylinder", "several")
AXIS = (0.36, 0.48, 0.8)


def rounded(kind, size):
    """A round thing of about a size, off its body's origin."""
    ends = np.array([[0.01, 0.0, 0.02], np.array(AXIS) * size + [0.01, 0.0, 0.02]])
    if kind == "sphere":
        return Enclosure((ends[:1],), 0.0, (Rounding(size / 2),))
    if kind == "capsule":
        return Enclosure((ends,), 0.0, (Rounding(size / 3),))
    if kind == "cylinder":
        return Enclosure((ends,), 0.0, (Rounding(disc=size / 3, axis=AXIS),))
    parts, boxed = (ends[:1], ends, ends, CUBE * size / 4 - 0.02), Rounding(0.001)
    return Enclosure(parts, 0.0, (Rounding(size / 2), Rounding(size / 3), Rounding(0.0, size / 4, AXIS), boxed))


def in_place_of(scene: Scenery, kind: str) -> Scenery:
    """The scenery with a round first thing, and what is found of it."""
    size = float(np.ptp(scene.first.mesh.vertices, axis=0).min())
    first = replace(scene.first, exactly=rounded(kind, size))
    return sought(first, scene.second, scene.waypoints)


def grown(parts: BodyParts, by: float) -> BodyParts:
    rounds = np.frombuffer(parts.rounds).reshape(-1, 5).copy()
    rounds[:, :2] += by * (rounds[:, :2] > 0.0)
    return replace(parts, rounds=rounds.tobytes())


@pytest.mark.parametrize("kind", KINDS)
def test_proofs_of_round_things_hold_with_the_same_margin_and_with_no_larger_thing(kind):
    proven = 0
    for seed in range(40):
        scene = in_place_of(scenery(seed), kind)
        if isinstance(scene.found, Unproven | None):
            continue
        proven += 1
        told = scene.couple().check(scene.proof, 0.01)
        assert min(told.least, 0.01) == pytest.approx(min(scene.found.margin, 0.01), abs=1e-9)
        given = {"first": scene.given(scene.first), "second": scene.given(scene.second)}
        things, parts = scene.things(), {name: Parts(each) for name, each in given.items()}
        exact = ProvenPair(ExactFrames(scene.path()), *things, lambda thing, p=parts: p[thing.name], ExactSide)
        assert exact.check(scene.proof, 0.01).least == pytest.approx(told.least, abs=1e-9)
        if scene.found.margin < 0.09 and kind != "cylinder":  # a disc grows in its plane alone
            with pytest.raises(Refuted):
                scene.couple({**given, "first": grown(given["first"], 0.1)}).check(scene.proof, 0.01)
    assert proven > 8


def test_the_file_keeps_roundings():
    parts = BodyParts((1, 2), np.arange(9.0).tobytes(), np.arange(10.0).tobytes())
    bodies = {"sha256:" + "c" * 64: parts, "sha256:" + "d" * 64: replace(parts, rounds=b"")}
    told = certificate_to_json(Certificate(0.01, (), 0.01, bodies))
    assert [set(each) for each in told["bodies"].values()] == [
        {"sizes", "vertices", "rounds"},
        {"sizes", "vertices"},
    ]
    findings: list = []
    assert certificate_from_json(JsonValue(told, "$", "plan.json", findings)).bodies == bodies and not findings


@pytest.mark.parametrize(
    "rounds",
    [[-1.0, 0, 0, 0, 1], [0, np.nan, 0, 0, 1], [0, np.inf, 0, 0, 1], [0, 0.1, 0, 0, 1.1], [0.1, 0, 0, 0, 0]],
)
def test_a_rounding_that_is_none_is_refused(rounds):
    with pytest.raises(ValueError, match="radius|length 1"):
        Parts(BodyParts((1,), np.zeros(3).tobytes(), np.array(rounds, float).tobytes()))


def element(kind, enclosure):
    return Element(kind, Mesh(CUBE * 2.0, FACES), enclosure.parts[0], enclosure.roundings[0])


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
def test_a_round_element_is_covered_by_its_own_part_or_by_parts_around_its_mesh(kind):
    made = rounded(kind, 0.3)
    packed = made.packed
    own = BodyParts((len(made.parts[0]),), made.parts[0].tobytes(), packed.rounds.tobytes())
    assert Parts(own).missing([element(kind, made)]) is None
    assert Parts(grown(own, 0.01)).missing([element(kind, made)]) is None
    assert Parts(grown(own, -1e-9)).missing([element(kind, made)]) == "triangle 0 sticks out"
    moved = replace(own, vertices=(made.parts[0] + 1e-9).tobytes())
    assert Parts(moved).missing([element(kind, made)]) is not None
    around = BodyParts((8,), (CUBE * 2.1).tobytes())
    assert Parts(around).missing([element(kind, made)]) is None
    assert Parts(around).missing([element(kind, made), element(kind, made)]) is None


def test_a_disc_across_another_axis_does_not_cover():
    made = rounded("cylinder", 0.3)
    turned = np.array([[0.0, 0.1, 0.0, 0.0, 1.0]])
    given = BodyParts((2,), made.parts[0].tobytes(), turned.tobytes())
    assert Parts(given).missing([element("cylinder", made)]) is not None


def test_a_box_covers_itself_but_no_larger_one():
    box = Element("box", Mesh(CUBE, FACES), CUBE)
    assert Parts(BodyParts((8,), CUBE.tobytes())).missing([box]) is None
    assert Parts(BodyParts((8,), (CUBE * 0.999).tobytes())).missing([box]) == "triangle 0 sticks out"
