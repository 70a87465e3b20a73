"""The ends of a motion that a caller gives: the name of a configuration, or values of the planned joints."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from kabo.arrays import Array
from kabo.displays import counted
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.given import as_float, shown

if TYPE_CHECKING:
    from kabo.scene import Configuration, Robot, Scene

Where = str | Sequence[float] | Mapping[str, float]  # a named configuration, or values of the planned joints


def ends_of(scene: "Scene", robot: "Robot", start: Where, goal: Where) -> "tuple[Configuration, Configuration]":
    """Configurations of all joints at both ends; the gripper is as at the start of the scene."""
    ends = []
    now = scene.start.robots[robot.name]
    for where, name in ((start, "start"), (goal, "goal")):
        values = np.round(_values(robot, where, now, name), 9) + 0.0
        low, high = robot.tree.lower, robot.tree.upper
        for i, (joint, value) in enumerate(zip(robot.planned_joints, values, strict=True)):
            if not low[i] <= value <= high[i]:
                what = f"the {name} has {joint} at {value:.6g}, outside its limits {low[i]:.6g} to {high[i]:.6g}"
                raise fault(name, what, "choose a value within the limits")
        now = (*map(float, values), *now[robot.planned :])
        ends.append(now)
    return ends[0], ends[1]


def _values(robot: "Robot", where: Where, now: "Configuration", name: str) -> Array:
    """The values of the planned joints at an end.

    Raises:
        InputError: an unknown name, or numbers that do not fit.
    """
    if isinstance(where, str):
        known = {**robot.configurations}
        if where == "start" and where not in known:
            return np.array(now[: robot.planned])
        if where not in known:
            what = f"{robot.name} has no configuration {shown(where)}"
            raise fault(name, what, suggested(where, (*known, *(() if "start" in known else ("start",)))))
        return np.array(known[where], np.float64)
    values = np.array(now[: robot.planned])
    for joint, value in (where if isinstance(where, Mapping) else _in_order(robot, where, name)).items():
        if joint not in robot.planned_joints:
            what = f"the {name} names {shown(joint)}, which is no planned joint of {robot.name}"
            raise fault(name, what, suggested(str(joint), robot.planned_joints))
        if not isinstance(value, Real) or isinstance(value, bool):
            what = f"the {name} has {shown(value)} for {joint}, which is no number"
            raise fault(name, what, "give radians or metres")
        values[robot.planned_joints.index(joint)] = as_float(value)
    if not np.isfinite(values).all():
        raise fault(name, f"the {name} has a value that is not finite", "give numbers")
    return values


def _in_order(robot: "Robot", where: Sequence[float], name: str) -> Mapping[str, float]:
    """The values of an end, which are given in the order of the planned joints, by the names of these."""
    given = list(np.array(where, dtype=object, ndmin=1))
    if len(given) != robot.planned:
        what = f"the {name} has {counted(len(given), 'value')}, and {robot.name} plans {robot.planned} joints"
        raise fault(name, what, f"give one each for {', '.join(robot.planned_joints)}")
    return dict(zip(robot.planned_joints, given, strict=True))


def suggested(name: str, known: Mapping[str, object] | Sequence[str]) -> str:
    """The remedy for a name that is not known: a similar one, or all there are."""
    there = "there are" if len(known) > 1 else "there is"
    return did_you_mean(name, known) or f"{there} {', '.join(known) or 'none'}"


def fault(argument: str, what: str, remedy: str) -> InputError:
    """A finding about an argument of `plan_motion`, by its name."""
    return InputError([Diagnostic(argument, 1, 1, what, remedy)])
