"""How near two things come that are in each other's way: the number on which a refusal rests.

Two links of one robot, where it is in its own way; or a hand and what it shall take, where no joint opens the hand.
"""

from collections.abc import Iterable

from kabo import geometry  # its names load when they are used: python-fcl only for `--geometry exact`
from kabo.arrays import Array
from kabo.geometry_server import Measure, Pair, ScenePredicates, millimetres, pair_text
from kabo.scene import Configuration
from kabo.tasks.robots.scenes import TaskScene

BEYOND_RIM = 0.2  # of epsilon, by which the point of a hand that does not open lies beyond its rim, as docs say
TOUCHING = 1e-6  # [m]: what is no farther apart touches; configurations are solved to less
SMALLEST_DEPTH = 5e-5  # [m]: a lesser one is not told as a number; it may be one of edges that cross


def own_nearness(scene: TaskScene, robot: str, pair: Pair, waypoints: Iterable[Configuration]) -> Measure | None:
    """How near two links of a robot come at one of some configurations; None if one of both is not its link.

    It is also said if they are as near where the robot stands already: then no motion can begin.
    """
    links = scene.robot(robot).links
    if not all(name.partition(".")[0] == robot and name.partition(".")[2] in links for name in pair):
        return None
    surroundings, stands = scene.context.surroundings, scene.situation.configuration(robot)
    epsilon, kept = surroundings.budget.epsilon, _kept(scene, robot, pair)

    def upper(q: Configuration) -> tuple[float, bool]:
        bounds = ScenePredicates(surroundings, scene.at(robot, q).situation.first).distance(*pair)
        return bounds.upper, bounds.lower <= surroundings.budget.margin + kept

    nearest = min((upper(q)[0] for q in waypoints), default=upper(stands)[0])
    said = f"{pair[0]} and {pair[1]} "
    if -SMALLEST_DEPTH < nearest <= 0.0:
        said += "touch or overlap"
    elif nearest < 0.0:
        said += f"overlap by {millimetres(-nearest)} or more"
    else:
        said += f"are at most {millimetres(nearest)} apart, "
        said += f"where {millimetres(kept)} are to be kept, " if kept > 0.0 else ""
        said += f"with epsilon = {millimetres(epsilon)}"
    if upper(stands)[1]:
        said += f", too near already where {robot} stands"
    return Measure(pair_text(pair), said, epsilon + kept, nearest)


def _kept(scene: TaskScene, robot: str, pair: Pair) -> float:
    """The distance that two links of a robot keep, those of one hand none [m]."""
    chosen = scene.robot(robot)
    hands = {chosen.hand(chosen.links[name.partition(".")[2]].joint) for name in pair}
    one = len(hands) == 1 and 0 not in hands
    return 0.0 if one else sum(scene.context.surroundings.kept(name) for name in pair)


def hand_touches(scene: TaskScene, robot: str, pair: Pair, q: Array, family: str) -> Measure | None:
    """That a hand without moving joints touches an object where a grasp family takes it; None if it is not so.

    Such a hand does not open: before the object is grasped, only where the tool's point lies keeps them apart.

    Args:
        scene: where the object is not grasped.
        robot: the robot of the hand.
        pair: the link and the object that are too near each other, in any order.
        q: all joints (n,) of the robot at the grasp.
        family: the name of the grasp family.
    """
    gripper = scene.robot(robot).gripper
    if gripper is None or scene.robot(robot).gripper_joints:
        return None
    link = next((name for name in pair if name in gripper.touch_links), None)
    if link is None:
        return None
    (name,) = (each for each in pair if each != link)
    surroundings = scene.context.surroundings
    at = ScenePredicates(surroundings, scene.at(robot, q).situation.first)
    apart = geometry.exact_distance(at.thing(link), at.thing(name))
    if apart > TOUCHING:
        return None
    needed = BEYOND_RIM * surroundings.budget.epsilon + surroundings.kept(link) + surroundings.kept(name)
    said = (
        f"{name} is touched by {link} before grasp {family} may touch it, and the hand does not open: "
        f"the tool's point must be {millimetres(needed)} or more beyond the hand's rim"
    )
    return Measure(f"{name}.{family}", said, needed, apart)
