"""Every constraint of docs/explanation/sampling.md#which-constraints measures what it says, and is missed."""

import numpy as np
import pytest

from kabo.language.scene_description import Constraint, Feature, FeatureName
from kabo.verify.motion.constraints import Role, UnknownFeatureError, measures, missed

FEATURES = {
    "p": Feature("point", (0.0, 0.0, 0.0)),
    "l": Feature("line", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "e": Feature("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
}


def turned(x: float, shift=(0.0, 0.0, 0.0)) -> Role:
    """The features turned about x by an angle [rad], then moved."""
    world_T = np.eye(4)
    world_T[1:3, 1:3] = [[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]]
    world_T[:3, 3] = shift
    return Role(FEATURES, world_T)


def holds(kind, first, second, this, lower=None, upper=None) -> bool:
    constraint = Constraint(kind, FeatureName("this", first), FeatureName("other", second), lower, upper)
    return missed([constraint], {"this": this, "other": Role(FEATURES, np.eye(4))}) is None


FLIP, SIDE, ALIKE = np.pi, np.pi / 2, 0.0


@pytest.mark.parametrize(
    ("kind", "first", "second", "angles"),
    [
        ("parallel", "l", "l", {ALIKE, FLIP}),
        ("parallel", "e", "e", {ALIKE, FLIP}),
        ("parallel", "l", "e", {SIDE}),  # a line that is parallel to a plane
        ("aligned", "l", "l", {ALIKE}),
        ("aligned", "l", "e", {ALIKE}),
        ("opposed", "l", "l", {FLIP}),
        ("opposed", "e", "e", {FLIP}),
        ("perpendicular", "l", "l", {SIDE}),
        ("perpendicular", "e", "e", {SIDE}),
        ("perpendicular", "l", "e", {ALIKE, FLIP}),  # a line along the normal
        ("coincident", "l", "l", {ALIKE, FLIP}),
        ("coincident", "e", "e", {ALIKE, FLIP}),
    ],
)
def test_directions_hold_at_these_angles_only(kind, first, second, angles):
    for angle in (ALIKE, SIDE, FLIP):
        assert holds(kind, first, second, turned(angle)) is (angle in angles)
        for off, fine in ((5e-4, True), (2e-3, False)):
            if angle in angles:
                assert holds(kind, first, second, turned(angle + off)) is fine


@pytest.mark.parametrize(
    ("first", "second", "shift", "fine"),
    [
        ("p", "p", (0, 0, 0.002), False),
        ("p", "p", (0, 0, 0.0005), True),
        ("p", "l", (0, 0, 5), True),
        ("p", "l", (0.002, 0, 0), False),
        ("p", "e", (5, 5, 0), True),
        ("p", "e", (0, 0, -0.002), False),
        ("l", "l", (0, 0, 5), True),
        ("l", "l", (0, 0.002, 0), False),
        ("e", "e", (5, 5, 0), True),
        ("e", "e", (0, 0, 0.002), False),
    ],
)
def test_coincidence_leaves_the_freedoms_that_it_should(first, second, shift, fine):
    assert holds("coincident", first, second, turned(0.0, shift)) is fine


def test_bounds_are_kept_on_both_sides():
    for height, fine in ((0.05, True), (0.12, True), (0.0485, False), (0.1215, False), (-0.07, False)):
        assert holds("height", "p", "e", turned(0.0, (1, 1, height)), 0.05, 0.12) is fine
    for distance, fine in ((0.1, True), (0.102, False), (0.0, True)):
        assert holds("distance", "p", "l", turned(0.0, (0, distance, 3)), None, 0.1) is fine
    for angle, fine in ((0.1, True), (0.17, True), (0.18, False)):
        assert holds("angle", "l", "l", turned(angle), None, np.radians(10)) is fine


def test_the_excess_says_by_how_much():
    constraint = Constraint("distance", FeatureName("this", "p"), FeatureName("world", "origin"), None, 0.1)
    (measure,) = measures(constraint, {"this": turned(0.0, (0.3, 0, 0))})
    assert measure.excess == pytest.approx(0.2) and measure.kind == "length"


def test_features_that_nobody_has_are_named():
    constraint = Constraint("aligned", FeatureName("this", "x"), FeatureName("world", "up"))
    with pytest.raises(UnknownFeatureError, match=r"this\.x"):
        missed([constraint], {"this": turned(0.0)})
    with pytest.raises(UnknownFeatureError, match=r"tool\.l"):
        missed([Constraint("aligned", FeatureName("tool", "l"), FeatureName("world", "up"))], {})
