"""A bar of unknown balance: its physics against the statics of a bar between two pads, its model, its plans."""

import runpy
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "lifting_a_bar"
GRAVITY = 9.81
SWING = 1.25  # how much heavier a bar is while the hand begins to rise, at most
BARS = {  # mass [kg], balance [m], friction, force that it bears [N]
    "heavy": (0.8, 0.03, 0.55, 60.0),
    "light": (0.3, -0.04, 0.9, 60.0),
    "even": (0.5, 0.0, 0.7, 60.0),
}
PLACES, FORCES = (-0.07, -0.03, 0.0, 0.025, 0.06), (1.2, 2.5, 4.0, 8.0, 14.0, 22.0, 32.0)


@cache
def names() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE / "lifting_a_bar.py"))


def made(name: str) -> Any:
    return names()["Bar"](*BARS[name])


def kind(bar: Any, along: float, force: float) -> str:
    """What comes of a lift without errors: `valid`, or the reason why it is not."""
    fault = names()["fault"](bar, names()["simulate"](bar, along, force))
    return "valid" if fault is None else str(fault.reason)


def forces_needed(bar: Any, along: float) -> tuple[float, float]:
    """The forces [N] below which no bar stays level, and above which every one does: statics of four points a pad.

    The corners of both pads carry a quarter of the force each. Below the first force friction is less than the weight,
    or the torque of friction at these points less than that of the weight. Above the second even the point where both
    act in one direction has enough of it.
    """
    weight, radius = bar.mass * GRAVITY, float(np.hypot(*names()["PAD"]))
    lever = abs(along - bar.balance) / radius
    return weight * max(1.0, lever) / (2 * bar.friction), weight * (1.0 + lever) / (2 * bar.friction)


@pytest.mark.parametrize("name", BARS)
def test_statics_forbid_no_lift_that_is_valid_and_permit_all_that_are_not(name: str) -> None:
    bar = made(name)
    told = {(along, force): kind(bar, along, force) for along in PLACES for force in FORCES}
    needed = {along: forces_needed(bar, along) for along in PLACES}
    assert {told[a, f] for a, f in told if f < needed[a][0]} <= {"dropped", "hanging"}
    assert {told[a, f] for a, f in told if f > needed[a][1] * SWING} == {"valid"}
    assert set(told.values()) == {"dropped", "hanging", "valid"}, "the places and forces reach every zone"


@pytest.mark.parametrize("name", BARS)
def test_the_torque_at_the_wrist_is_the_weight_times_its_distance_from_the_balance(name: str) -> None:
    bar = made(name)
    for along in PLACES:
        found = names()["simulate"](bar, along, 1.5 * forces_needed(bar, along)[1])
        expected = bar.mass * GRAVITY * (along - bar.balance)
        assert found.torque == pytest.approx(expected, abs=2e-3)


def test_a_bar_that_is_held_at_its_balance_is_level_and_without_torque() -> None:
    for name in BARS:
        bar = made(name)
        found = names()["simulate"](bar, bar.balance, 20.0)
        assert (found.torque, found.tilt) == pytest.approx((0.0, 0.0), abs=1e-3)
        assert found.raised == pytest.approx(names()["LIFT"], abs=5e-3)


def test_friction_bears_the_weight_at_the_balance_from_the_force_on_that_statics_name() -> None:
    for name in BARS:
        bar = made(name)
        needed = forces_needed(bar, bar.balance)[0]
        kinds = [kind(bar, bar.balance, share * needed) for share in (0.9, SWING)]
        assert kinds == ["dropped", "valid"]


def test_a_bar_is_crushed_by_more_force_than_it_bears_and_not_by_less() -> None:
    bar = names()["Bar"](0.4, 0.01, 0.8, 20.0)
    assert [kind(bar, 0.01, force) for force in (18.0, 19.5, 20.5, 35.0)] == [
        "valid",
        "valid",
        "crushed",
        "crushed",
    ]


def test_the_same_seed_gives_the_same_outcome_to_the_last_bit_and_another_one_another() -> None:
    def outcomes(seed: int) -> list[Any]:
        return [names()["lift"]({"bar": bar}, {"along": 0.01, "force": 13.0}, seed) for bar in ("wood", "steel")]

    assert repr(outcomes(3)) == repr(outcomes(3))
    assert outcomes(3)[0].outcomes != outcomes(4)[0].outcomes


def test_without_mujoco_the_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r'pip install "kabo\[simulation\]"'):
        names()["lift"]({"bar": "wood"}, {"along": 0.0, "force": 10.0}, 0)
