"""Accelerations and Jacobians of points that are fixed to bodies, from the spatial quantities that MuJoCo has in each step.

A spatial vector is (turning, moving), seen from the centre of mass of the tree that a body belongs to [Featherstone 2008,
chapter 2]. `bias` is what `mj_jacDot` times the velocities is, and `jacobian` what `mj_jac` is, without a call for each.
"""

from typing import NamedTuple

from kabo.arrays import Array, Integers
from kabo.compilation import kernel


class Tree(NamedTuple):
    """What does not change, of bodies (B,) and degrees of freedom (V,)."""

    root: Integers  # (B,) the first body of the tree that a body belongs to
    last: Integers  # (B,) the last degree of freedom that moves a body, -1: none
    parent: Integers  # (V,) the one before on the way to the world, -1: none
    carrier: Integers  # (V,) the body that it moves
    turns: Integers  # (V,) 1 if it is one of a quaternion


class Moving(NamedTuple):
    """Views on what changes in each step."""

    velocity: Array  # (V,)
    body: Array  # (B, 6) spatial velocities
    axis: Array  # (V, 6) spatial axes
    change: Array  # (V, 6) of the axes in time
    centre: Array  # (B, 3) of mass, of the tree that begins with a body [m]
    origin: Array  # (B, 3) of bodies [m]
    rotation: Array  # (B, 9) of bodies, row by row


@kernel  # (3,), (3,) -> writes out (3,)
def add_cross(a, b, out):
    """Adds a x b to `out`."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


TURNS = 3  # the row of the scratch of `bias` in which angular accelerations are


@kernel  # i8, (3,) f8 [m], Tree, Moving, scratch (4, 3) f8 -> writes into scratch[0] [m/s²] and [TURNS] [rad/s²]
def bias(body, point, tree, moving, scratch):
    """The acceleration of a point of a body, and the angular one of the body, if no joint accelerates."""
    found, offset, speed, total = scratch[0], scratch[1], scratch[2], scratch[TURNS]
    found[:], total[:] = 0.0, 0.0
    i = tree.last[body]
    if i < 0:
        return
    offset[:] = point - moving.centre[tree.root[body]]
    own = moving.body[body]
    speed[:] = own[3:]
    add_cross(own[:3], offset, speed)
    while i >= 0:
        v, axis = moving.velocity[i], moving.axis[i]
        if tree.turns[i]:
            carrier = moving.body[tree.carrier[i]]
            for r in range(3):
                s, t = (r + 1) % 3, (r + 2) % 3
                total[r] += v * (carrier[s] * axis[t] - carrier[t] * axis[s])
                found[r] += v * (carrier[s] * axis[3 + t] - carrier[t] * axis[3 + s])
                found[r] += v * (carrier[3 + s] * axis[t] - carrier[3 + t] * axis[s])
        else:
            for r in range(3):
                total[r] += v * moving.change[i, r]
                found[r] += v * moving.change[i, 3 + r]
        i = tree.parent[i]
    add_cross(total, offset, found)
    # The turning part of the body's own velocity is the sum of its axes, each times its velocity.
    add_cross(own[:3], speed, found)


@kernel  # i8, (3,) f8 [m], f8 [kg], (V,) f8, (3,) f8 [m/s²], Tree, Moving, scratch (6, 3) f8 -> adds to torques (V,)
def add_point_mass(body, place, mass, wanted, gravity, tree, moving, scratch, torques):
    """Adds the torques that move a point mass at a place in a body's frame, for wanted accelerations of the joints."""
    point, turn = scratch[5], moving.rotation[body]
    for r in range(3):
        along = turn[3 * r] * place[0] + turn[3 * r + 1] * place[1] + turn[3 * r + 2] * place[2]
        point[r] = moving.origin[body, r] + along
    bias(body, point, tree, moving, scratch)
    needed, offset, column = scratch[0], scratch[1], scratch[4]
    for whole in range(2):  # first the acceleration, then the torques
        i = tree.last[body]
        while i >= 0:
            axis = moving.axis[i]
            column[:] = axis[3:]
            add_cross(axis[:3], offset, column)
            if whole == 0:
                needed += column * wanted[i]
            else:
                torques[i] += mass * (needed[0] * column[0] + needed[1] * column[1] + needed[2] * column[2])
            i = tree.parent[i]
        if whole == 0:
            needed -= gravity
