"""Arms of given structure with any link lengths and any frames: what closed forms must know by their axes alone."""

import numpy as np
import pinocchio as pin

from kabo.scene.tree import KinematicTree
from tests.kinematics.trees import Twin, twin

FORMS = (
    "wrist and two parallel axes",
    "wrist and two crossing axes",
    "wrist and two parallel axes, mirrored",
    "wrist and two crossing axes, mirrored",
    "wrist at the base",
    "three parallel axes",
    "three parallel axes, backwards",
    "five axes",
    "seven axes",
)


def arm(rng, form, limits=np.pi) -> Twin:
    """A random arm of a structure: its axes at zero are drawn, then a frame anywhere on each of them."""
    axes = _axes(rng, form)
    if form in ("wrist at the base", "three parallel axes, backwards"):
        axes = axes[::-1]
    parts, before = [], pin.SE3.Identity()
    for j, (z, p) in enumerate(axes):
        x = np.cross(z, unit(rng))
        x /= np.linalg.norm(x)
        here = pin.SE3(np.stack([x, np.cross(z, x), z], axis=1), p + rng.uniform(-0.3, 0.3) * z)
        parts.append((j, 0, before.actInv(here), j, float(rng.choice([-1.0, 1.0])), rng.uniform(-1, 1)))
        before = here
    return twin(parts, limits)


def unit(rng):
    """A random direction."""
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _axes(rng, form):
    place = lambda: rng.uniform(-0.5, 0.5, 3)  # noqa: E731
    if form == "five axes":
        n = unit(rng)
        return [
            (_beside(rng, n), place()),
            *((rng.choice([-1, 1]) * n, place()) for _ in range(3)),
            _tilted(rng, n),
        ]
    if form.startswith("three parallel"):
        n, centre = unit(rng), place()
        z5 = _beside(rng, n)
        bends = [(rng.choice([-1, 1]) * n, place()) for _ in range(3)]
        return [(_beside(rng, n), place()), *bends, (z5, centre), (_beside(rng, z5), centre)]
    centre, meeting, n = place(), place(), unit(rng)
    z4 = unit(rng)
    z5 = _beside(rng, z4)
    wrist = [(z4, centre), (z5, centre), (_beside(rng, z5), centre)]
    if "crossing" in form or form == "seven axes":
        second = _beside(rng, n)
        first = [(n, meeting), (second, meeting), (unit(rng), place())]
        if form == "seven axes":
            first.insert(2, (_beside(rng, second), meeting))
    else:
        first = [(_beside(rng, n), place()), (n, place()), (-n, place())]
    return (first[::-1] if "mirrored" in form else first) + wrist


def _beside(rng, z):
    """A direction at 60 to 120 degrees from another."""
    while True:
        v = unit(rng)
        if abs(v @ z) < 0.5:
            return v


def _tilted(rng, n):
    return _beside(rng, n), rng.uniform(-0.5, 0.5, 3)


def narrowed(tree: KinematicTree, rng) -> KinematicTree:
    """The tree with narrower limits, some of more than a turn."""
    middle, half = rng.uniform(-1, 1, tree.size), rng.uniform(0.5, 4.5, tree.size)
    return tree._replace(lower=middle - half, upper=middle + half)
