"""All formats that a plan can be exported to: how each is written, which choices it takes, and how a file is checked."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import zip_longest
from types import NoneType
from typing import Literal

from kabo.errors import did_you_mean
from kabo.exporting.behavior_tree import behavior_tree, decisive_parts
from kabo.exporting.mermaid import mermaid
from kabo.exporting.py_trees_source import decisive_lines, py_trees_source
from kabo.exporting.ros_messages import RosTrajectory, compared_values, ros_messages
from kabo.exporting.setpoints import USUAL_RATE as TABLE_RATE
from kabo.exporting.setpoints import compared_rows, setpoint_table
from kabo.exporting.texts import lines_of
from kabo.exporting.urscript import USUAL_RATE as UR_RATE
from kabo.exporting.urscript import statements, ur_program
from kabo.exporting.way import Choice, refusal, require_followable, timed_branch
from kabo.given import require_flag, require_given, require_number
from kabo.plan import Plan, plan_to_dot

MAX_PART = 100  # characters of what differs in a message


@dataclass(frozen=True)
class Wishes:
    """What is exported, and how.

    Attributes:
        choice: what of the plan, for formats without branches.
        rate: setpoints or points a second [Hz]; None: as is usual in the format.
        way_points: URScript from way point to way point.
        file: the plan's name in errors.
    """

    choice: Choice = field(default_factory=Choice)
    rate: float | None = None
    way_points: bool = False
    file: str = "plan"


@dataclass(frozen=True)
class Format:
    """A format: who reads it, which choices it takes, how it is written, and what of a file decides its meaning."""

    readers: str
    takes: tuple[str, ...]
    write: Callable[[Plan, Wishes], str]
    parts: Callable[[str], list[str]]


ONE_BRANCH = ("branch", "node", "robot", "rate")


def _ros(kind: Literal["trajectory", "moveit"]) -> Callable[[Plan, Wishes], str]:
    def write(plan: Plan, wishes: Wishes) -> str:
        return "---\n".join(message.to_yaml() for message in _messages(plan, kind, wishes))

    return write


def _messages(plan: Plan, kind: Literal["trajectory", "moveit"], wishes: Wishes) -> list[RosTrajectory]:
    timed = timed_branch(plan, wishes.choice, wishes.file)
    return ros_messages(timed, wishes.choice, kind, wishes.rate, wishes.file)


def _table(plan: Plan, wishes: Wishes) -> str:
    timed = timed_branch(plan, wishes.choice, wishes.file)
    return setpoint_table(timed, wishes.choice, wishes.rate or TABLE_RATE, wishes.file)


def _ur(plan: Plan, wishes: Wishes) -> str:
    timed = timed_branch(plan, wishes.choice, wishes.file)
    return ur_program(timed, wishes.choice, wishes.rate or UR_RATE, wishes.way_points, wishes.file)


FORMATS = {
    "bt": Format("BehaviorTree.CPP 4", (), lambda plan, _: behavior_tree(plan), decisive_parts),
    "py_trees": Format("py_trees 2", (), lambda plan, own: py_trees_source(plan, own.file), decisive_lines),
    "trajectory": Format(
        "ROS 2, trajectory_msgs/JointTrajectory", ONE_BRANCH, _ros("trajectory"), compared_values
    ),
    "moveit": Format("ROS 2, moveit_msgs/RobotTrajectory", ONE_BRANCH, _ros("moveit"), compared_values),
    "dot": Format("Graphviz", (), lambda plan, _: plan_to_dot(plan), lines_of),
    "mermaid": Format("Mermaid, in Markdown", (), lambda plan, _: mermaid(plan), lines_of),
    "csv": Format("tables of setpoints", ONE_BRANCH, _table, compared_rows),
    "urscript": Format("arms of Universal Robots", (*ONE_BRANCH, "way_points"), _ur, statements),
}
OPTIONS = {
    "branch": "--branch",
    "node": "--node",
    "robot": "--robot",
    "rate": "--rate",
    "way_points": "--way-points",
}


def export(
    plan: Plan,
    to: str,
    *,
    branch: str | None = None,
    node: str | None = None,
    robot: str | None = None,
    rate: float | None = None,
    way_points: bool = False,
    file: str = "plan",
) -> str:
    """The plan as the text of a file that others execute, play or draw (docs/how-to/export.md).

    Args:
        plan: a plan that was verified.
        to: `bt`, `py_trees`, `trajectory`, `moveit`, `dot`, `mermaid`, `csv` or `urscript`.
        branch: outcomes separated by commas, for `trajectory`, `moveit`, `csv` and `urscript`, which hold one branch.
        node: in place of a branch, the motion of one node.
        robot: of these formats, the only robot whose motion is exported.
        rate: points or setpoints a second [Hz]; None: 100 for `csv`, 500 for `urscript`, and for the messages of ROS the
            ends of the polynomials' pieces, which describe the trajectory exactly.
        way_points: of `urscript`, `movej` from way point to way point, in place of `servoj`.
        file: the plan's name in errors.

    Raises:
        InputError: there is no such format, it does not take such a choice, or the plan cannot be told in it.

    Example:
        >>> plan = kabo.solve(kabo.load_problem("domains/doors/n3.yaml")).plan
        >>> kabo.export(plan, "mermaid").splitlines()[0]
        'flowchart TD'
    """
    wishes = Wishes(Choice(branch, node, robot), rate, way_points, file)
    return _format(plan, to, wishes).write(plan, wishes)


def ros_trajectories(
    plan: Plan,
    to: Literal["trajectory", "moveit"] = "trajectory",
    *,
    branch: str | None = None,
    node: str | None = None,
    robot: str | None = None,
    rate: float | None = None,
    file: str = "plan",
) -> list[RosTrajectory]:
    """The messages of `export(plan, "trajectory")` or `"moveit"`, one for each motion from rest to rest.

    Args:
        plan: a plan that was verified.
        to: `trajectory` or `moveit`.
        branch, node, robot, rate, file: as of `export`.

    Raises:
        InputError: as of `export`.
    """
    wishes = Wishes(Choice(branch, node, robot), rate, False, file)
    _format(plan, to, wishes)
    return _messages(plan, to, wishes)


def check_export(
    plan: Plan,
    to: str,
    text: str,
    *,
    branch: str | None = None,
    node: str | None = None,
    robot: str | None = None,
    rate: float | None = None,
    way_points: bool = False,
    file: str = "plan",
) -> str | None:
    """Where the text of a file says something else than the plan, in a sentence; None: it says the same.

    Layout, comments, and remarks of editors may differ. Some readers of a format accept more than they should, such as
    a switch of BehaviorTree.CPP without a default; here that is a difference.

    Args:
        plan: the plan.
        to: the format.
        text: the text of the file.
        branch, node, robot, rate, way_points, file: as it was exported with.

    Raises:
        InputError: as of `export`.
    """
    wishes = Wishes(Choice(branch, node, robot), rate, way_points, file)
    form = _format(plan, to, wishes)
    require_given("text", text, str)
    expected = form.parts(form.write(plan, wishes))
    try:
        found = form.parts(text)
    except ValueError as error:
        return str(error)
    for number, (due, own) in enumerate(zip_longest(expected, found), 1):
        if due != own:
            return f"part {number} is {_shown(own)}, and the plan says {_shown(due)}"
    return None


def _format(plan: Plan, to: str, wishes: Wishes) -> Format:
    """The format.

    Raises:
        InputError: there is none of this name, or it does not take what was chosen; or the plan cannot be followed.
    """
    require_given("plan", plan, Plan)
    choice = wishes.choice
    words = {"branch": choice.branch, "node": choice.node, "robot": choice.robot}
    for name, given in words.items():
        require_given(name, given, str, NoneType)
    require_given("to", to, str)
    require_given("file", wishes.file, str)
    require_flag("way_points", wishes.way_points)
    if to not in FORMATS:
        hint = did_you_mean(to, FORMATS) or f"formats are {', '.join(FORMATS)}"
        raise refusal("--to", f'there is no format "{to}"', hint)
    found = FORMATS[to]
    chosen = {name for name, given in {**words, "rate": wishes.rate}.items() if given is not None}
    chosen |= {"way_points"} if wishes.way_points else set()
    for name in (each for each in OPTIONS if each in chosen and each not in found.takes):
        takers = ", ".join(each for each, other in FORMATS.items() if name in other.takes)
        raise refusal(OPTIONS[name], f"{to} does not take it: it is of {takers}", "leave it out")
    if choice.branch is not None and choice.node is not None:
        raise refusal("--node", "a branch is chosen, too", "choose a branch or one node")
    if wishes.rate is not None and not 0.0 < require_number("rate", wishes.rate) <= 1e4:
        raise refusal("--rate", f"{wishes.rate} Hz is no rate from 0 to 10000 Hz", "choose another rate")
    require_followable(plan, wishes.file)
    return found


def _shown(part: str | None) -> str:
    if part is None:
        return "missing"
    text = part.strip()
    return f"`{text if len(text) <= MAX_PART else text[: MAX_PART - 1] + '…'}`"
