"""What MuJoCo leaves out of contacts in a hand: see `Physics`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.compilation import kernel
from kabo.simulation.kernels.bias import TURNS, bias

Shorts = NDArray[np.int32]


class Touches(NamedTuple):
    """What does not change: of geoms (G,) and bodies (B,)."""

    body: Integers  # (G,)
    hand: Integers  # (B,) the number of the hand that a finger belongs to, -1: no finger
    free: Integers  # (B,) 1 if it is movable


class Contacts(NamedTuple):
    """The contacts (C,) of a step: pairs of geoms (C, 2), places (C, 3), axes (C, 9), rows of constraints (C,) or -1.

    `size` (C,) is how many rows each has: along three axes, then turns about them.
    """

    geom: Shorts
    place: Array
    frame: Array
    row: Shorts
    size: Shorts


def no_contacts() -> Contacts:
    """Two contacts without rows, in the layout of arrays that MuJoCo gives: not contiguous; that fits a single one, too."""
    pairs, rows = np.full((4, 2), -1, np.int32), np.full(4, -1, np.int32)
    places, frames = np.zeros((4, 3)), np.zeros((4, 9))
    return Contacts(pairs[::2], places[::2], frames[::2], rows[::2], rows[::2])


@kernel  # Contacts, Touches, (H,) i8, Tree, Moving, (R,) f8, (R, 4) f8, f8 [s] -> changes reference (R,)
def complete_friction(contacts, touches, presses, tree, moving, reference, impedance, step):
    """Takes the bias of both bodies from the reference accelerations of contacts of hands that press.

    That of turns, too: what resists turning about the normal would else turn what is held, however hard it is pressed.
    `impedance` is `efc_KBIP`: its damping already makes up for half of it in each step, at the positions after the step.
    """
    first, second = np.empty((4, 3)), np.empty((4, 3))
    for k in range(contacts.row.shape[0]):
        row = contacts.row[k]
        if row < 0:
            continue
        one, two = touches.body[contacts.geom[k, 0]], touches.body[contacts.geom[k, 1]]
        if touches.free[one] + touches.free[two] == 0:
            continue
        a, b = touches.hand[one], touches.hand[two]
        count = (a != b) * ((a >= 0 and presses[max(a, 0)]) + (b >= 0 and presses[max(b, 0)]))
        if count == 0:
            continue
        bias(one, contacts.place[k], tree, moving, first)
        bias(two, contacts.place[k], tree, moving, second)
        share = count * (1.0 - 0.5 * step * impedance[row, 1])
        for r in range(3):
            off = 0.0
            for c in range(3):
                off += contacts.frame[k, 3 * r + c] * (second[0, c] - first[0, c])
            reference[row + r] -= share * off
        for r in range(contacts.size[k] - 3):  # turns: of the first one about the normal
            off = 0.0
            for c in range(3):
                off += contacts.frame[k, 3 * r + c] * (second[TURNS, c] - first[TURNS, c])
            reference[row + 3 + r] -= share * off
