"""MuJoCo, loaded where something is stepped; without it a message says how to install it."""

from typing import Any

import numpy as np

from kabo.errors import Diagnostic, InputError
from kabo.simulation.kernels.bias import Tree


def mujoco() -> Any:
    """The package `mujoco`.

    Raises:
        InputError: it is not installed.
    """
    try:
        import mujoco as library
    except ImportError:
        text, hint = "simulation needs MuJoCo, which is not installed", 'pip install "kabo[simulation]"'
        raise InputError([Diagnostic("mujoco", 1, 1, text, hint)]) from None
    return library


def model_from(xml: str) -> Any:
    """The model of a description in MJCF, of which bodies sleep while nothing moves them, if MuJoCo can (from 3.4 on).

    What rests costs no time then: a third of a run with two arms and four bottles. MuJoCo wakes a body when something that
    is awake touches it, when a force acts on it, or when its place or velocity is written; robots never sleep.
    """
    library = mujoco()
    model = library.MjModel.from_xml_string(xml)
    sleep = getattr(library.mjtEnableBit, "mjENBL_SLEEP", None)
    if sleep is not None:
        model.opt.enableflags |= int(sleep)
    return model


def tree_of(model: Any) -> Tree:
    """The tree of bodies and degrees of freedom of a model."""
    library = mujoco()
    kinds, joint = library.mjtJoint, model.dof_jntid
    kind, first = model.jnt_type[joint], model.jnt_dofadr[joint]
    numbers = np.arange(model.nv)
    turns = (kind == kinds.mjJNT_BALL) | ((kind == kinds.mjJNT_FREE) & (numbers >= first + 3))
    last = np.full(model.nbody, -1)
    for body in range(1, model.nbody):
        own = model.body_dofnum[body]
        last[body] = model.body_dofadr[body] + own - 1 if own else last[model.body_parentid[body]]
    parts = (model.body_rootid, last, model.dof_parentid, model.dof_bodyid, turns)
    return Tree(*(np.ascontiguousarray(part, np.int64) for part in parts))
