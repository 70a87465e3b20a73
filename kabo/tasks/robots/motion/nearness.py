"""How near two links of one robot come: the number on which a refusal rests if a robot is in its own way."""

from collections.abc import Iterable

from kabo.geometry_server import Measure, Pair, ScenePredicates, millimetres, pair_text
from kabo.scene import Configuration
from kabo.tasks.robots.scenes import TaskScene

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
