"""A branch of a plan as a program for the arms of Universal Robots, in URScript.

The arm is led along the trajectory by `servoj` at the controller's rate, or from way point to way point by `movej`, with
a stop at each. Nothing moves before the arm is where the plan begins. What is not the arm's is a function at the top of
the program, to be filled in: the hand, waiting for other robots, and sensing, which asks a person by default.
"""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from kabo.exporting.texts import lines_of, one_line, rounded
from kabo.exporting.way import SAME_TIME, Choice, Run, TimedNode, refusal, require_motion, runs_of
from kabo.plan.description import call

USUAL_RATE = 500.0  # [Hz], of the e-series; the CB3 series has 125 Hz
JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
LOOKAHEAD, GAIN = 0.05, 500  # of servoj [s]; 0.03 to 0.2, and 100 to 2000
LEAST_SPEED = 1e-3  # [rad/s, rad/s²], asked of movej where a way hardly moves

_HEAD = """\
def kabo_plan():
  # What is not the arm's: fill in these functions.
  def kabo_hand(closes, bodies):
    set_standard_digital_out(0, closes)
    sleep(0.5)
  end
  def kabo_sense(asked, assumed):
    popup(str_cat("Stop the program unless this is ", str_cat(assumed, str_cat(": ", asked))), "kabo", blocking=True)
  end
  def kabo_wait(for_what):
    popup(str_cat("Go on when this is done: ", for_what), "kabo", blocking=True)
  end
  def kabo_begin_at(q):
    local now = get_actual_joint_positions()
    local i = 0
    while i < 6:
      if norm(now[i] - q[i]) > 0.01:
        popup("The arm is not where the plan begins.", "kabo", error=True, blocking=True)
        halt
      end
      i = i + 1
    end
  end
"""


def ur_program(timed: Sequence[TimedNode], choice: Choice, rate: float, way_points: bool, file: str) -> str:
    """The program of one arm.

    Args:
        timed: the nodes of the branch.
        choice: says which robot, if several move.
        rate: of servoj [Hz].
        way_points: movej from way point to way point, in place of servoj.
        file: the plan's name in errors.

    Raises:
        InputError: there is no motion, the arm is none of Universal Robots, or another robot moves at the same time.
    """
    require_motion(timed, choice.robot, file)
    moving = sorted({segment.robot for each in timed for segment in each.node.motion})
    if choice.robot is None and len(moving) > 1:
        raise refusal(file, f"{' and '.join(moving)} move, and a program drives one arm", f"--robot {moving[0]}")
    robot = choice.robot or moving[0]
    arm = _arm(timed, robot, file)
    lines = _HEAD.splitlines()
    begun = False
    for each in timed:
        lines.append(f'  textmsg("{each.name} {_text(call(each.node))}")')
        for part in _parts(each, timed, robot, file):
            if isinstance(part, str):
                lines.append(f'  kabo_wait("{_text(f"{part} does {each.name}")}")')
            elif part.trajectory.joints != arm:
                lines.append(f'  kabo_hand({"True" if part.attach else "False"}, "{_text(_bodies(part))}")')
            else:
                if not begun:
                    lines.append(f"  kabo_begin_at({_list(part.trajectory.at(part.trajectory.times[0]))})")
                    begun = True
                lines += _by_way_points(part) if way_points else _by_setpoints(part, rate)
        if each.outcome is not None:
            lines.append(f'  kabo_sense("{_text(str(each.node.on))}", "{_text(each.outcome)}")')
    return "\n".join([*lines, "end", "kabo_plan()"]) + "\n"


def _arm(timed: Sequence[TimedNode], robot: str, file: str) -> tuple[str, ...]:
    """The joints of the arm, which are the six of Universal Robots, whatever stands before their names."""
    found = {segment.joints for each in timed for segment in each.node.motion if segment.robot == robot}
    for joints in sorted(found):
        if len(joints) == len(JOINTS) and all(own.endswith(end) for own, end in zip(joints, JOINTS, strict=True)):
            return joints
    names = ", ".join(max((len(joints), joints) for joints in found)[1])
    hint = f"an arm of Universal Robots has {', '.join(JOINTS)}; trajectory and csv are for any robot"
    raise refusal(file, f"URScript does not drive {robot} with the joints {names}", hint)


def _parts(each: TimedNode, timed: Sequence[TimedNode], robot: str, file: str) -> list[Run | str]:
    """What a node's motion consists of, in the order in which it begins: motions of the arm, or another robot's name.

    Raises:
        InputError: another robot moves while the arm does.
    """
    own = [
        _span(other, segment.times) for other in timed for segment in other.node.motion if segment.robot == robot
    ]
    parts: list[tuple[float, Run | str]] = []
    if any(segment.robot == robot for segment in each.node.motion):
        parts += [(run.trajectory.times[0], run) for run in runs_of([each], Choice(robot=robot), file)]
    for segment in each.node.motion:
        if segment.robot == robot:
            continue
        begin, end = _span(each, segment.times)
        if any(begin < last - SAME_TIME and first < end - SAME_TIME for first, last in own):
            message = f"in {each.name} {robot} and {segment.robot} move at once, and a program drives one arm"
            raise refusal(file, message, "export to trajectory or csv, and send both on one clock")
        parts.append((begin, segment.robot))
    parts.sort(key=lambda part: part[0])
    return [part for (_, part), (_, before) in zip(parts, [(0.0, None), *parts], strict=False) if part != before]


def _span(each: TimedNode, times: Sequence[float]) -> tuple[float, float]:
    return each.begin + times[0], each.begin + times[-1]


def _by_setpoints(run: Run, rate: float) -> Iterator[str]:
    motion = run.trajectory
    count = int(np.ceil(motion.duration * rate - SAME_TIME))
    times = motion.times[0] + np.arange(1, count + 1) / rate
    for row in motion.at(times):
        yield f"  servoj({_list(row)}, t={rounded(1.0 / rate)}, lookahead_time={LOOKAHEAD}, gain={GAIN})"
    yield "  stopj(2.0)"


def _by_way_points(run: Run) -> Iterator[str]:
    """Straight in joint space from one way point to the next, no joint faster than it is in the plan.

    `movej` gives its speed and acceleration to the joint that has farthest to go, and less to the others.
    """
    motion = run.trajectory
    fastest, strongest = (
        np.maximum(np.abs(np.array(motion.bounds(order))).max(axis=0), LEAST_SPEED) for order in (1, 2)
    )
    points = np.array(motion.waypoints)
    for before, after in zip(points, points[1:], strict=False):
        way = np.abs(after - before)
        if not way.max() > 0.0:
            continue
        share = np.maximum(way / way.max(), 1e-12)
        speed, acceleration = (fastest / share).min(), (strongest / share).min()
        yield f"  movej({_list(after)}, a={rounded(acceleration)}, v={rounded(speed)})"


def _bodies(run: Run) -> str:
    return ", ".join([body for body, _ in run.attach] or list(run.detach))


def _list(values: Iterable[float]) -> str:
    return "[" + ", ".join(map(rounded, values)) + "]"


def _text(words: str) -> str:
    """Words inside a string of URScript, which has no escapes; it is ASCII for the older controllers."""
    return one_line(words).replace('"', "'").encode("ascii", "replace").decode()


def statements(text: str) -> list[str]:
    """The lines of a program without comments and blanks at their ends."""
    return lines_of("\n".join(map(_without_comment, text.split("\n"))))


def _without_comment(line: str) -> str:
    in_string = False
    for place, character in enumerate(line):
        if character == '"':
            in_string = not in_string
        elif character == "#" and not in_string:
            return line[:place]
    return line
