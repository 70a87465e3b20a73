"""What touches in physics now, bodies that sleep included: of those MuJoCo keeps no contacts while they rest."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array, Integers
from kabo.simulation.mujoco_library import mujoco

Pairs = tuple[Integers, Array]
NOTHING: Pairs = np.empty((0, 2), np.int64), np.empty(0)
ASLEEP, AWAKE = 0, 1  # of `body_awake`; a body that never moves has -1


@dataclass(frozen=True)
class Contact:
    """Two things that touch, by name, and how deep [m]."""

    things: tuple[str, str]
    depth: float


class RestingContacts:
    """The contacts that a model's data leave out, since both sides sleep, or one does and the other never moves.

    They are computed when they are asked for, and once for as long as the same bodies sleep at the same places.
    """

    def __init__(self, model: Any) -> None:
        self._model, self._scratch = model, mujoco().MjData(model)
        self._key: tuple[bytes, ...] | None = None
        self._found = NOTHING

    def of(self, data: Any) -> Pairs:
        """The shapes (N, 2) that touch, by number, and the distances (N,) between them [m]."""
        awake = getattr(data, "body_awake", None)  # from MuJoCo 3.4 on
        if awake is None or not (sleeps := awake == ASLEEP).any():
            return NOTHING
        key = sleeps.tobytes(), data.xpos[sleeps].tobytes(), data.xquat[sleeps].tobytes()
        if key != self._key:
            self._key, self._found = key, self._look(data, awake)
        return self._found

    def _look(self, data: Any, awake: Integers) -> Pairs:
        library, model, scratch = mujoco(), self._model, self._scratch
        flags = model.opt.enableflags
        model.opt.enableflags = flags & ~int(library.mjtEnableBit.mjENBL_SLEEP)
        try:
            scratch.qpos[:] = data.qpos
            library.mj_kinematics(model, scratch)
            library.mj_comPos(model, scratch)
            library.mj_collision(model, scratch)
        finally:
            model.opt.enableflags = flags
        found = scratch.contact
        sides = awake[model.geom_bodyid[found.geom]]
        rests = (sides == ASLEEP).any(axis=1) & (sides != AWAKE).all(axis=1)
        return found.geom[rests].astype(np.int64), found.dist[rests].copy()
