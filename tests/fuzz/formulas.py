"""Random formulas: sentences of the grammar, and near misses, over the names of the small domain."""

import random

from tests.fuzz.mutations import NUMBERS

_NAMES = (
    "hand_empty",
    "grasped",
    "robot_grasps",
    "at_place",
    "combination",
    "weight",
    "robot",
    "item",
    "r",
    "o",
    "l",
)
_TERMS = ("r", "o", "l", "anywhere", "can", "x", "this", "weight(o)", "combination(r)", "1", "0.5", "-3", "o.axis")


def formula(rng: random.Random, depth: int = 3) -> str:
    """A text that is a formula, an update or nearly one."""
    if depth == 0 or rng.random() < 0.2:
        return _leaf(rng)
    inner = [formula(rng, depth - 1) for _ in range(3)]
    name = rng.choice(_NAMES)
    return rng.choice(
        (
            f"K({inner[0]})", f"Kw({inner[0]})", f"Kv({_term(rng)})", f"not {inner[0]}", f"{inner[0]} and {inner[1]}",
            f"{inner[0]} or {inner[1]}", f"({inner[0]})", f"forall({name} x) {inner[0]}",
            f"exists({name} x, {name} y) {inner[0]}", f"forall({name} x: {inner[0]}) {inner[1]}",
            f"when {inner[0]} then {inner[1]}", f"add(Kf, {inner[0]})", f"del(Kf, {inner[0]}, {inner[1]})",
            f"add(Kx, {inner[0]}, {inner[1]})", f"add(Kv, {_term(rng)})", f"add(LCW, {inner[0]})",
            f"initially {inner[0]}", f"always {inner[0]}", f"{inner[0]} => {inner[1]}", f"{inner[0]} {inner[1]}",
            f"add(Kf, {_term(rng)} = {_term(rng)} + {rng.choice(NUMBERS)})", f"oneof({inner[0]}, {inner[1]})",
        )
    )  # fmt: skip


def _leaf(rng: random.Random) -> str:
    atom = f"{rng.choice(_NAMES)}({', '.join(_term(rng) for _ in range(rng.randrange(4)))})"
    compared = f"{_term(rng)} {rng.choice(('=', '!=', '<', '<=', '>', '==', 'in'))} {_term(rng)}"
    return rng.choice(
        (atom, atom, compared, rng.choice(_NAMES), rng.choice(NUMBERS), "true", "()", "", "K()", "[1, 2]")
    )


def _term(rng: random.Random) -> str:
    if rng.random() < 0.15:
        return f"{_term(rng)} {rng.choice('+-*/^')} {rng.choice(NUMBERS)}"
    return rng.choice(_TERMS)
