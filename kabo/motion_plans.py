"""One motion of one robot, planned without a domain: as a trajectory, and as a plan of one node.

The path is proven free of collision in the scene as it stands at the start, and so is the trajectory along it, with its
rounded corners; `verify` judges the plan like any other.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING

import numpy as np

from kabo.arrays import Array
from kabo.errors import KaboError
from kabo.given import require_given, require_number, shown
from kabo.motion import Trajectory
from kabo.motion_ends import Where, ends_of, fault, suggested
from kabo.options import require_clearance, require_seed
from kabo.plan import Node, Plan, Segment, node_to_json
from kabo.task_plans import plan_of_solution

if TYPE_CHECKING:
    from kabo.geometry_server import Keep, Pair, Refusal
    from kabo.scene import Configuration, Robot, Scene
    from kabo.tasks.robots import TaskScene

PATH_SAMPLES, MOST_SAMPLES = 200_000, 10**15  # of a path search: a second or two, and what its kernels count
PROCEDURE = "motion"


class NoMotionError(KaboError):
    """No motion was found within the samples: it does not mean that there is none (exit code 4)."""

    exit_code = 4


@dataclass(frozen=True)
class Motion:
    """A motion of one robot, and all that it depends on: what `plan` needs to make a plan of it.

    Attributes:
        scene: where it is free of collision; nothing but the robot moves.
        robot: the name of the robot.
        start, goal: configurations of all its joints, the gripper's behind the planned ones.
        times: when the trajectory passes each way point [s].
        trajectory: of the planned joints, from time 0.
        keep: the name of the constraint that it keeps, if there is one.
        seed: of the samples.
        clearance: what bodies keep from each other along it [m].
        epsilon: the accuracy of the proofs [m]; None: that of the scene.
    """

    scene: "Scene"
    robot: str
    start: "Configuration"
    goal: "Configuration"
    times: tuple[float, ...]
    trajectory: Trajectory
    keep: str | None
    seed: int
    clearance: float = 0.0
    epsilon: float | None = None

    def plan(self, *, certificate: bool = True) -> Plan:
        """The plan of one node that makes this motion; `kabo.verify(scene, plan)` judges it.

        Raises:
            ArgumentError: the scene was not loaded from a file.
        """
        names = self.scene.robots[self.robot].joint_names
        found = self.trajectory
        segment = Segment(
            self.robot,
            found.joints,
            found.waypoints,
            self.times,
            PROCEDURE,
            constraint=self.keep,
            trajectory=found,
        )
        written = node_to_json(Node("action", "", motion=(segment,)))["motion"]
        told = [
            {key: value for key, value in each.items() if key not in ("procedure", "grants")} for each in written
        ]
        ends = [
            {"robots": {self.robot: {"joints": dict(zip(names, q, strict=True))}}} for q in (self.start, self.goal)
        ]
        motion = {"start": ends[0], "segments": told, "changes": [], "after": ends[1]}
        report = {
            "task": PROCEDURE,
            "clearance": self.clearance,
            "runs": [{"seed": self.seed, "solutions": [{"motion": motion, "cost": 0.0}]}],
        }
        return plan_of_solution(report, 1, self.scene, certificate=certificate, epsilon=self.epsilon)  # type: ignore[arg-type]


def plan_motion(
    scene: "Scene | str | Path",
    robot: str,
    start: Where,
    goal: Where,
    *,
    seed: int = 0,
    keep: str | None = None,
    holding: str | None = None,
    epsilon: float | None = None,
    clearance: float = 0.0,
    samples: int = PATH_SAMPLES,
    stop: Callable[[], bool] = lambda: False,
) -> Trajectory:
    """The motion of a robot from one configuration to another, proven free of collision; the same for the same seed.

    It rests at both ends, keeps the scene's limits of velocity, acceleration and jerk, and passes corners without a stop
    where that is proven. All other bodies and robots stand as at the start of the scene.

    Args:
        scene: the scene, or the path of a scene file or of a problem file with a scene.
        robot: the name of the robot.
        start, goal: the name of a configuration of the scene (`start` is where the robot stands there), or the values of
            the planned joints [rad or m], in their order or by their names; those without a value stay where they start.
        seed: of the samples.
        keep: the name of a motion constraint of the scene that is kept throughout, for what the robot holds, or for its
            tool if the constraint speaks of nothing else.
        holding: a movable body that the robot holds all the time, placed to its tool as it is where the scene begins.
        epsilon: the accuracy of the proofs [m]; None: that of the scene.
        clearance: the distance that bodies keep from each other, unless their contact is permitted [m]; what the scene
            says is uncertain is kept besides.
        samples: after so many of them the search gives up.
        stop: asked now and then whether to give up.

    Raises:
        InputError: the scene does not load, a name is unknown, values do not fit, or an end is outside the limits, in
            collision, or does not keep the constraint; it says which joint or pair, and by how much.
        ArgumentError: an argument is of a wrong kind, or a number that nothing can be planned with; says what is expected.
        NoMotionError: no way was found; it says what was in the way.
        CutOff: `stop` returned True.

    Example:
        >>> scene = kabo.load_scene("examples/two_cans/scene.yaml")
        >>> motion = kabo.plan_motion(scene, "arm", "home", {"panda_joint1": 0.5})
        >>> motion.waypoints[0] == scene.robots["arm"].configurations["home"]
        True
    """
    found = find_motion(
        scene,
        robot,
        start,
        goal,
        seed=seed,
        keep=keep,
        holding=holding,
        epsilon=epsilon,
        clearance=clearance,
        samples=samples,
        stop=stop,
    )
    return found.trajectory


def find_motion(
    scene: "Scene | str | Path",
    robot: str,
    start: Where,
    goal: Where,
    *,
    seed: int = 0,
    keep: str | None = None,
    holding: str | None = None,
    epsilon: float | None = None,
    clearance: float = 0.0,
    samples: int = PATH_SAMPLES,
    stop: Callable[[], bool] = lambda: False,
) -> Motion:
    """As `plan_motion`, with all that a plan needs.

    Raises:
        InputError, ArgumentError, NoMotionError, CutOff: as `plan_motion`.
    """
    # Load kernels, which motion needs.
    from kabo.geometry_server import GeometryServer, Refusal, way_to
    from kabo.scene import Scene, load_scene
    from kabo.tasks.robots import TaskScene

    require_given("scene", scene, Scene, str, Path)
    require_given("robot", robot, str)
    require_given("keep", keep, str, NoneType)
    require_given("holding", holding, str, NoneType)
    seed, kept = require_seed(seed), require_clearance(clearance)
    samples = require_number("samples", samples, 0, MOST_SAMPLES, whole=True)
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    if robot not in scene.robots:
        raise fault("robot", f"the scene has no robot {shown(robot)}", suggested(robot, scene.robots))
    chosen = scene.robots[robot]
    if holding is not None:
        scene = _holding(scene, chosen, holding)
    server = GeometryServer(scene, epsilon, seed, stop=stop, clearance=kept)
    first, last = ends_of(scene, chosen, start, goal)
    state = scene.start.replace({robot: first})
    task_scene = TaskScene.of(server.context(), state)
    constraint = _constraint(task_scene, robot, keep)
    _require_held(task_scene, robot)
    for q, name in ((first, "start"), (last, "goal")):
        _require_free(task_scene, robot, np.array(q), name)
        broken = None if constraint is None else constraint.broken(np.array(q))
        if broken is not None:
            raise fault(name, f"the {name} does not keep {keep}: {broken}", "choose another end, or no constraint")
    key: tuple[str | int | float, ...] = (seed, PROCEDURE, robot, *first, *last)
    found = way_to(task_scene.workspace(robot), np.array(first), np.array(last), key, samples, constraint)
    if isinstance(found, Refusal):
        raise NoMotionError(_no_way(task_scene, robot, found, samples))
    times, trajectory = _timed(task_scene, robot, found, keep)
    return Motion(scene, robot, first, last, times, trajectory, keep, seed, kept, server.budget.epsilon)


def _holding(scene: "Scene", robot: "Robot", name: str) -> "Scene":
    """The scene, with a body in the robot's hand from the beginning.

    Raises:
        InputError: there is no such body, it cannot be moved, or the robot has no tool.
    """
    from kabo.scene import attachment, world_T  # loads kernels, as above

    if robot.tool is None:
        raise fault("holding", f"{robot.name} has no tool and holds nothing", "write `tool` in the scene")
    if name not in scene.movable:
        raise fault(
            "holding", f"the scene has no movable body {shown(name)}", suggested(name, tuple(scene.movable))
        )
    hand = f"{robot.name}.{robot.tool.frame}"
    hand_T_world = np.linalg.inv(world_T(scene, scene.start, hand))
    held = attachment(hand, hand_T_world @ world_T(scene, scene.start, name))
    return replace(scene, start=scene.start.replace({name: held}))


def _constraint(scene: "TaskScene", robot: str, keep: str | None) -> "Keep | None":
    """The constraint of that name, for what the robot holds.

    Raises:
        InputError: there is none of that name, or the robot holds nothing that it fits.
    """
    from kabo.geometry_server import keep_constraint

    if keep is None:
        return None
    known = scene.context.scene.motion_constraints
    if keep not in known:
        raise fault("keep", f"the scene has no motion constraint {shown(keep)}", suggested(keep, known))
    found = keep_constraint(scene.context, scene.robot(robot), scene.situation, keep)
    if found is None:
        raise fault(
            "keep",
            f"{robot} holds nothing that {keep} fits",
            "say what it holds (holding), or leave the constraint out",
        )
    return found


def _require_held(scene: "TaskScene", robot: str) -> None:
    """Checks that the gripper can hold, at rest, what the robot holds.

    Raises:
        InputError: it is too heavy; says for what force.
    """
    from kabo.tasks.robots.motion.held_bodies import too_heavy

    found = too_heavy(scene.context.scene, scene.situation, robot)
    if found is not None:
        raise fault("robot", found.comment, "let the gripper have more force, or write the true mass and friction")


def _require_free(scene: "TaskScene", robot: str, q: Array, name: str) -> None:
    """Checks that a configuration is free of collision.

    Raises:
        InputError: it is not; says which two things meet, and how deep, or how much distance is missing.
    """
    from kabo.tasks.robots.motion.kept_distances import met_distance, told_distance

    pair = scene.workspace(robot).first_hit(q)
    if pair is None:
        return
    if pair[1] in scene.context.scene.regions:
        raise fault(
            name, f"at the {name} {pair[0]} is not on its floor, {pair[1]}", "choose another configuration"
        )
    state = scene.situation.first.replace({robot: tuple(map(float, q))})
    surroundings, wanted = scene.context.surroundings, _kept(scene, pair)
    apart = met_distance(surroundings, state, pair)
    if apart > 0.0:
        remedy = "choose another configuration, " + (
            "a smaller clearance, or let less be uncertain" if wanted > 0.0 else "or a smaller epsilon"
        )
        raise fault(
            name, f"at the {name} {told_distance(pair, apart, wanted, surroundings.budget.epsilon)}", remedy
        )
    depth = f"{-1000 * apart:.1f}"
    how = "touch" if depth in ("0.0", "-0.0") else f"overlap by up to {depth} mm"
    what = f"at the {name} {pair[0]} and {pair[1]} {how}"
    raise fault(name, what, "choose another configuration, or allow the contact: allowed_contacts")


def _kept(scene: "TaskScene", pair: "Pair") -> float:
    """The distance that two bodies or links are to keep: the clearance, and what the scene says is uncertain [m]."""
    from kabo.tasks.robots.motion.kept_distances import kept_between

    return kept_between(scene.context.surroundings, scene.situation, pair)


def _no_way(scene: "TaskScene", robot: str, refusal: "Refusal", samples: int) -> str:
    """Why no way was found, with the pairs that were most in the way, and the distance that they are to keep."""
    from kabo.geometry_server import millimetres

    hits = sorted(refusal.pairs, key=lambda one: -one[1])[:3]
    text = f"no way for {robot} was found in {samples} samples"
    if hits:
        text += "; most in the way: " + ", ".join(
            f"{a} and {b} ({count} times{f', {millimetres(kept)} are to be kept' if kept > 0.0 else ''})"
            for (a, b), count, kept in ((pair, count, _kept(scene, pair)) for pair, count in hits)
        )
    elif refusal.comment:
        text += f": {refusal.comment}"
    return text + ". More samples or another seed may find one"


def _timed(
    scene: "TaskScene", robot: str, path: Sequence[Array], keep: str | None
) -> tuple[tuple[float, ...], Trajectory]:
    """The times of the way points, and the trajectory, proven with its rounded corners."""
    from kabo.tasks.robots import stretch
    from kabo.tasks.robots.motion.parts import MotionPart
    from kabo.tasks.robots.motion.timing import timed_group

    part = MotionPart(stretch(scene, robot, "arm", list(path), keep), scene, PROCEDURE)
    (timed,) = timed_group([part])
    begun = timed.beginning(0.0)
    return begun.times, begun.trajectory
