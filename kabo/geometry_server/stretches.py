"""Parts of motions: paths to a configuration, proven free and shortened, and straight lines of the tool.

Way points are rounded as in plans *before* their path is proven, so that the plan contains exactly the proven
path.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.answers import Refusal, pair_text
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.driving.legs import LEAST_LEG_SAMPLES, LEG_SAMPLES_SHARE, by_legs, travels
from kabo.geometry_server.frames import WORLD, Frame, carried_frame, fits, rows, tool_frame
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.workspace import Workspace
from kabo.kinematics import KeptRows, OffLine, keeps, straight_line, values
from kabo.kinematics.kernels import rows as columns
from kabo.scene import BASE_VALUES, Robot
from kabo.streams import Key, stream_key
from kabo.ways import FreeSpace, NoPath, find_way, shortened

LINE_DEVIATION = 1e-3  # [m] of a straight stretch from its line
LINE_TILT = 5e-3  # [rad] of the tool on a straight stretch
SHORTCUT_ATTEMPTS = 40  # to shorten a path; a plan's motion is refined later
MAX_VAIN_SHORTCUTS = 5  # failed attempts in a row
CONSTRAINT_TOLERANCE = 5e-4  # [m, rad] of a motion constraint: half of what the verifier grants


@dataclass(frozen=True)
class Keep:
    """A constraint that must hold throughout a motion, as rows that refer to the robot's tree."""

    name: str
    robot: Robot
    rows: Array

    def keeps(self, start: Array, goal: Array) -> bool:
        """Whether the constraint is proven to hold on the straight joint-space segment from `start` to `goal`."""
        return keeps(self.robot.tree, self.rows, start, goal, CONSTRAINT_TOLERANCE)

    def holds_along(self, waypoints: Sequence[Array]) -> bool:
        """Whether the constraint is proven to hold along a path."""
        return all(self.keeps(a, b) for a, b in zip(waypoints, waypoints[1:], strict=False))

    def broken(self, q: Array) -> str | None:
        """The actual and the permitted value of a row that is violated at q (n,); None if the constraint holds."""
        if self.keeps(q, q):
            return None
        found = values(self.rows, q, self.robot.tree)
        excess = np.maximum(self.rows[:, columns.LOWER] - found, found - self.rows[:, columns.UPPER])
        return _told(self.rows[int(excess.argmax())], float(found[excess.argmax()]))

    @cached_property
    def kept_rows(self) -> KeptRows:
        """The constraint as the search for ways takes it."""
        tree = self.robot.tree
        active = np.arange(tree.size) < self.robot.planned
        return KeptRows.of(tree, self.rows, active, CONSTRAINT_TOLERANCE)


def _told(row: Array, found: float) -> str:
    """The value of a row and its bounds, with cosines as angles."""
    kind, low, high = int(row[columns.KIND]), float(row[columns.LOWER]), float(row[columns.UPPER])
    if kind == columns.DIRECTION:  # cosines
        low, high, found = (float(np.arccos(np.clip(v, -1.0, 1.0))) for v in (high, low, found))
    unit = "m" if kind < columns.DIRECTION else "rad"
    bounds = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f"found {found:.4g} {unit}, permitted {bounds} {unit}"


def keep_constraint(
    context: ProcedureContext, robot: Robot, situation: Situation, name: str, held: Sequence[str] | None = None
) -> Keep | None:
    """The motion constraint `name` for a held object; None if there is no such constraint, or it does not fit.

    `held` lists the objects to which the constraint may apply; None: any object in the robot's hand, or the tool alone
    if the constraint speaks of no object.
    """
    constraints = context.scene.motion_constraints.get(name)
    if constraints is None:
        return None
    if robot.tool is None:
        return None
    for each in situation.carried(robot.name):
        if held is not None and each not in held:
            continue
        this = carried_frame(robot, context.scene.bodies[each], situation.held(each))
        roles = {"this": this, "tool": tool_frame(robot), "world": WORLD}
        if fits(constraints, roles):
            return Keep(name, robot, rows(constraints, roles))
    roles = {"tool": tool_frame(robot), "world": WORLD}
    if held is None and fits(constraints, roles):
        return Keep(name, robot, rows(constraints, roles))
    return None


def rounded(q: Array) -> Array:
    """A configuration rounded as in plans."""
    return np.round(q, 9) + 0.0


def line(
    robot: Robot,
    q: Array,
    tool: Frame,
    translation: Array,
    deviation: float = LINE_DEVIATION,
    tilt: float = LINE_TILT,
) -> list[Array] | None:
    """Way points of a straight motion of the tool by `translation` (3,) [m] from q without rotation; None if not found.

    A base that drives stands meanwhile.

    The tool deviates from the line by at most `deviation` [m], and rotates by at most `tilt` [rad]. Collisions are not
    checked.
    """
    found = straight_line(
        robot.tree,
        q,
        tool.joint,
        tool.joint_T_frame,
        translation,
        active=robot.arm,
        deviation=deviation,
        tilt=tilt,
    )
    return None if isinstance(found, OffLine) else [rounded(w) for w in found]


def way_to(
    workspace: Workspace,
    start: Array,
    goal: Array,
    key: tuple[str | int | float, ...],
    samples: int,
    keep: Keep | None = None,
) -> list[Array] | Refusal:
    """Way points of a shortened path from start to goal (n,), proven free and to fulfil `keep` throughout; or a refusal.

    Raises:
        CutOff: time or budget is spent.
    """
    robot = workspace.robot
    for q, where in ((start, "where it begins"), (goal, "where it ends")):
        broken = None if keep is None else keep.broken(q)
        if keep is not None and broken is not None:
            text = f"{keep.name} does not hold {where}: {broken}"
            return Refusal("constraint", text, frozenset({robot.name}))
    space, stream = free_space(workspace, keep), stream_key(*key)
    if robot.drive is not None and not np.array_equal(start[:BASE_VALUES], goal[:BASE_VALUES]):
        path = _driven(workspace, start, goal, stream, samples, keep)
        if path is not None:
            return list(path)
    n = robot.planned
    low, high = start.copy(), start.copy()
    low[:n], high[:n] = robot.tree.lower[:n], robot.tree.upper[:n]
    effort = {"attempts": SHORTCUT_ATTEMPTS, "patience": MAX_VAIN_SHORTCUTS}
    found = workspace.counted(lambda: find_way(start, goal, space, low, high, stream, samples=samples, **effort))
    if isinstance(found, NoPath):
        workspace.surroundings.statistics.samples += found.samples
        return _blocked(workspace, found, keep)
    return list(found)


def free_space(workspace: Workspace, keep: Keep | None, *, projects: bool = True) -> FreeSpace:
    """What a way in a workspace must avoid and keep, for configurations of planned and gripper's joints."""
    view = workspace.checker
    return FreeSpace(
        view.configurations_hit,
        view.segment_hit,
        len(workspace.pairs),
        lambda: view.kernel_checks,
        None if keep is None else keep.kept_rows,
        projects,
        workspace.surroundings.look,
    )


def _driven(
    workspace: Workspace, start: Array, goal: Array, stream: Key, samples: int, keep: Keep | None
) -> Array | None:
    """A path (m, n) on which base and arm move one after the other; None if it is not tried, or not found."""
    robot, space = workspace.robot, free_space(workspace, keep)
    n = robot.planned
    folds = travels(robot, start[:n], goal[:n])
    if not folds and workspace.segment_hit(start, goal) < 0 and (keep is None or keep.keeps(start, goal)):
        return None

    def whole(q: Array) -> Array:
        return np.concatenate([q, start[n:]])

    def find(a: Array, b: Array, low: Array, high: Array, drives: bool) -> Array | NoPath:
        most, around = max(LEAST_LEG_SAMPLES, int(LEG_SAMPLES_SHARE * samples)), (whole(low), whole(high))
        own = free_space(workspace, keep, projects=not drives)
        found = workspace.counted(lambda: find_way(whole(a), whole(b), own, *around, stream, samples=most))
        return found if isinstance(found, NoPath) else found[:, :n]

    legs = by_legs(robot, start[:n], goal[:n], find, lambda q: keep is None or keep.broken(whole(q)) is None)
    if not legs:
        return None
    effort = {"attempts": SHORTCUT_ATTEMPTS, "patience": MAX_VAIN_SHORTCUTS}
    paths = [np.array([whole(q) for q in leg]) for leg in (legs if folds else [np.concatenate(legs)])]
    made = workspace.counted(lambda: [shortened(path, space, stream, **effort) for path in paths])
    return _without_repetitions(np.concatenate(made))


def _without_repetitions(path: Array) -> Array:
    """The way points (m, n) without consecutive repetitions, where one leg ends and the next begins."""
    kept = np.concatenate([[True], np.any(path[1:] != path[:-1], axis=1)])
    return np.asarray(path[kept])


def _blocked(workspace: Workspace, path: NoPath, keep: Keep | None) -> Refusal:
    """No way was found: the pairs in the way with counts, or the constraint, where it was met more often than they."""
    pairs = workspace.pairs
    hits = tuple((pairs[i], count) for i, count in sorted(path.hits.items()) if i < len(pairs))
    unkept = path.hits.get(len(pairs), 0)
    text = pair_text(hits[0][0]) if hits else ""
    if keep is not None and unkept > max((count for _, count in hits), default=0):
        text = f"{keep.name} would not be kept on {unkept} pieces of ways"
    return Refusal("no_path", text, frozenset({workspace.robot.name}), hits)
