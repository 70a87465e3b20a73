"""A branch of a plan as a table of setpoints (CSV): the values of all joints over time, the node, what hands take.

The columns are `time` [s], `node`, `action`, `outcome` (assumed after a node that senses or decides), `hand`
(`+bottle_1` is taken, `-bottle_1` is let go of at this time), and `ROBOT.JOINT` for each joint that moves [rad or m].
A node without motion has one row.
"""

import csv
import io
from collections.abc import Sequence
from itertools import count

import numpy as np

from kabo.arrays import Array
from kabo.exporting.texts import DECIMALS, comparable, one_line, rounded
from kabo.exporting.way import SAME_TIME, Choice, Run, TimedNode, refusal, require_motion, runs_of
from kabo.motion.trajectory import MAX_SAMPLES
from kabo.plan.description import call

USUAL_RATE = 100.0  # [Hz]
FIXED_COLUMNS = ("time", "node", "action", "outcome", "hand")

Column = tuple[str, str]  # a robot and its joint


def setpoint_table(timed: Sequence[TimedNode], choice: Choice, rate: float, file: str) -> str:
    """The table; without motion it has the nodes alone.

    Raises:
        InputError: a segment has no trajectory, or the robot that was chosen does not move.
    """
    runs: list[Run] = []
    if any(each.node.motion for each in timed) or choice.robot is not None:
        require_motion(timed, choice.robot, file)
        runs = runs_of(timed, choice, file)
    if timed[-1].end * rate > MAX_SAMPLES:
        raise refusal(file, f"this would be more than {MAX_SAMPLES} rows", "choose a lower --rate")
    columns = list(dict.fromkeys((run.robot, joint) for run in runs for joint in run.trajectory.joints))
    rows = [(time, number) for number in range(len(timed)) for time in _times(timed, number, runs, rate)]
    hands = _hands(timed, choice.robot)
    written = io.StringIO()
    table = csv.writer(written, lineterminator="\n")
    table.writerow([*FIXED_COLUMNS, *(f"{robot}.{joint}" for robot, joint in columns)])
    for row, (time, number), values in zip(count(), rows, _values(runs, columns, rows), strict=False):
        each = timed[number]
        is_last = row + 1 == len(rows) or rows[row + 1][1] != number
        what = one_line(call(each.node) if each.node.action is not None else each.node.kind)
        outcome = each.outcome if is_last and each.outcome is not None else ""
        acts = ""
        while hands and hands[0][0] <= time + SAME_TIME:
            acts = f"{acts} {hands.pop(0)[1]}".strip()
        table.writerow([rounded(time), each.name, what, outcome, acts, *map(rounded, values)])
    return written.getvalue()


def compared_rows(text: str) -> list[str]:
    """The rows of a table, without what spreadsheets change: quotes, ends of lines, zeros at the end of numbers.

    Raises:
        ValueError: it is no table.
    """
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except csv.Error as error:
        raise ValueError(f"it is no table: {error}") from None
    return ["\t".join(map(comparable, row)) for row in rows if row]


def _times(timed: Sequence[TimedNode], number: int, runs: Sequence[Run], rate: float) -> list[float]:
    """The times of a node's rows [s], up to where the next node begins: at the rate, and where motions end."""
    begin = timed[number].begin
    until = timed[number + 1].begin if number + 1 < len(timed) else timed[number].end
    steps = np.arange(np.ceil((until - begin) * rate - SAME_TIME)) / rate + begin
    ends = [run.trajectory.times[-1] for run in runs if begin < run.trajectory.times[-1] <= until]
    return sorted({round(float(time), DECIMALS) for time in (*steps, *ends, until)})


def _values(runs: Sequence[Run], columns: Sequence[Column], rows: Sequence[tuple[float, int]]) -> Array:
    """The values (rows, columns): on trajectories, and where they ended, and before all of them where they begin."""
    wanted = np.array([time for time, _ in rows])
    found = np.zeros((len(wanted), len(columns)))
    seen: set[Column] = set()
    for run in runs:
        values = run.trajectory.at(wanted)
        begun = wanted >= run.trajectory.times[0] - SAME_TIME
        for number, joint in enumerate(run.trajectory.joints):
            column = run.robot, joint
            filled = begun if column in seen else np.ones(len(wanted), bool)
            found[filled, columns.index(column)] = values[filled, number]
            seen.add(column)
    return found


def _hands(timed: Sequence[TimedNode], robot: str | None) -> list[tuple[float, str]]:
    """What hands take and let go of, by time [s]."""
    told = [
        (each.begin + segment.times[-1], word)
        for each in timed
        for segment in each.node.motion
        if robot in (None, segment.robot)
        for word in (*(f"-{body}" for body in segment.detach), *(f"+{body}" for body, _ in segment.attach))
    ]
    return sorted(told, key=lambda act: act[0])
