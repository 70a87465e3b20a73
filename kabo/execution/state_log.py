"""States in the log of a run, some a second: where robots and bodies are, and how far from where the plan has them."""

from collections.abc import Mapping
from math import inf

import numpy as np

from kabo.arrays import Array
from kabo.execution.log import Log
from kabo.execution.protocols import RobotState
from kabo.execution.watching import Planned, Watch
from kabo.scene.transforms import quaternion

EARLY = 1e-6  # [s] by which a record may come before it is due
APART = 1e-4  # [rad or m]: what is nearer to where the plan has it is not told twice


class StateLog:
    """Adds a record `state` to a log when it is due.

    Args:
        log: the log.
        rate: records a second on the robots' clock [Hz]; 0: none.
    """

    def __init__(self, log: Log, rate: float) -> None:
        self.log, self.rate = log, rate
        self._due = -inf
        self._seen: dict[str, tuple[Array, Planned]] = {}  # since the last record

    def is_due(self, state: RobotState) -> bool:
        """Whether it is time for a record."""
        return self.rate > 0.0 and state.time >= self._due - EARLY

    def saw(self, poses: Mapping[str, Array], planned: Planned) -> None:
        """Notes poses (4, 4) of bodies that are seen, and where the plan has them then: they are in the next record."""
        self._seen.update((name, (pose, planned)) for name, pose in poses.items())

    def add(
        self,
        node: str,
        state: RobotState,
        planned: Planned,
        watch: Watch,
        proven: float,
    ) -> None:
        """Adds a record.

        Args:
            node: the first node of the motion to whose clock `motion_time` belongs.
            state: what is measured of robots. planned: where the plan has them.
            watch: knows the greatest deviations since the record before.
            proven: how far bodies may be from their places [m].
        """
        self._due = state.time + 1.0 / self.rate
        found, seen = watch.take_recent(), self._seen
        self._seen = {}
        self.log.add(
            state.time,
            "state",
            node=node,
            motion_time=state.motion_time,
            robots={name: tuple(map(float, values)) for name, values in state.positions.items()},
            bodies={name: _pose(pose) for name, (pose, _) in seen.items()},
            planned=_elsewhere(planned, state, seen),
            tracking=found.tracking,
            permitted=found.permitted,
            displaced=found.bodies,
            proven=proven,
        )


def _elsewhere(
    planned: Planned, state: RobotState, seen: Mapping[str, tuple[Array, Planned]]
) -> dict[str, object]:
    """Where the plan has the robots and bodies that are measured, or were seen, to be elsewhere."""
    robots = {
        name: tuple(map(float, values))
        for name, values in planned.robots.items()
        if np.abs(np.subtract(values, state.positions[name])).max(initial=0.0) > APART
    }
    bodies = {
        name: _pose(then.bodies[name])
        for name, (pose, then) in seen.items()
        if np.abs(pose - then.bodies[name]).max() > APART
    }
    return {"robots": robots, "bodies": bodies}


def _pose(pose: Array) -> dict[str, list[float]]:
    return {"position": pose[:3, 3].tolist(), "quaternion": list(quaternion(pose))}
