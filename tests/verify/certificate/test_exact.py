"""Exact arithmetic agrees with floating point, and is exact where that is not."""

import math
from fractions import Fraction

import numpy as np
import pytest

from kabo.geometry.collision.separation_proofs import Unproven
from kabo.verify import verify_plan
from kabo.verify.certificate.exact import BITS, ExactFrames, ExactSide, integers, product, sine_and_cosine
from kabo.verify.certificate.pair_proof import ProvenPair
from tests.properties.test_certificates import scenery
from tests.verify.certified import Parts, with_certificate


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.3, -0.3, 1.6, 3.2, -6.2, 100.5, -12345.678])
def test_sines_and_cosines_are_those_of_the_library(angle):
    sine, cosine = sine_and_cosine(Fraction(angle))
    assert sine / 2**BITS == pytest.approx(math.sin(angle), abs=1e-16)
    assert cosine / 2**BITS == pytest.approx(math.cos(angle), abs=1e-16)
    assert abs((sine * sine + cosine * cosine >> BITS) - (1 << BITS)) < 1 << 20, "to 140 bits"


def test_integers_hold_every_bit_of_a_number():
    values = np.array([0.1, -1.0 / 3.0, 1e-30, 0.0])
    whole = integers(values)
    assert [Fraction(int(v), 1 << BITS) for v in whole[:2]] == [Fraction(v) for v in values[:2]]
    assert product(integers(np.eye(2)), integers(np.array([2.0, -0.5]))).tolist() == [2 << BITS, -(1 << BITS - 1)]


@pytest.mark.parametrize("seed", range(12))
def test_poses_boxes_and_axes_are_those_of_floating_point(seed):
    scene = scenery(seed)
    if isinstance(scene.found, Unproven | None):
        return
    parts = {"first": Parts(scene.given(scene.first)), "second": Parts(scene.given(scene.second))}
    things = scene.things()
    exact = ProvenPair(ExactFrames(scene.path()), *things, lambda thing: parts[thing.name], ExactSide)
    assert exact.check(scene.proof, 0.01).least == pytest.approx(
        scene.couple().check(scene.proof, 0.01).least, abs=1e-11
    )


def test_a_certificate_holds_in_exact_arithmetic_too(counter):
    report = verify_plan(counter.problem, with_certificate(counter), paranoid=True)
    assert report.ok and report.certificate is not None and report.certificate.paranoid
    assert "in exact arithmetic" in str(report)
