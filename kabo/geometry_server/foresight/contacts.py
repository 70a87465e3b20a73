"""Allowed contacts that are never needed: pairs that can never meet, whatever the robots do.

A pair that never meets is shown by lengths of links, which is a proof, or by sampled configurations, which is none; the
text says which. Pairs that kabo never checks anyway are not looked at: neighbours, and things that never move.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.errors import InputError
from kabo.geometry_server.foresight.measures import millimetres
from kabo.geometry_server.predicates import ScenePredicates
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.kinematics import seeds
from kabo.language.scene_description import SceneDescription
from kabo.scene import PRISMATIC, GeometricState, Robot, Scene, world_T
from kabo.streams import stream_key

CONFIGURATIONS = 256  # that are sampled for a pair
MAX_LINK_PAIRS = 400  # of a robot as a whole; more are believed to be needed

Ball = tuple[Array, float]  # middle (3,) and radius [m]


def idle_contacts(
    description: SceneDescription, surroundings: SceneSurroundings
) -> Iterator[tuple[tuple[str, str], str]]:
    """Every entry of `allowed_contacts` of which no pair can ever meet, with a clause that says how that is known."""
    scene = surroundings.scene
    for first, second in dict.fromkeys(description.allowed_contacts):
        pairs = [(a, b) for a in _things(scene, first) for b in _things(scene, second) if _is_checked(scene, a, b)]
        if not pairs or len(pairs) > MAX_LINK_PAIRS or any(_carried(scene, name) for name in (first, second)):
            continue
        proven = [_apart_always(scene, a, b) for a, b in pairs]
        if min(proven) > 0.0:
            yield (first, second), f"they stay {millimetres(min(proven))} apart, proven by the lengths of links"
        elif not any(_met(surroundings, *pair) for pair, far in zip(pairs, proven, strict=True) if far <= 0.0):
            yield (
                (first, second),
                f"they met in none of {CONFIGURATIONS} sampled configurations, which is no proof",
            )


def _things(scene: Scene, name: str) -> list[str]:
    """A body, a link, or all links of a robot, as far as they have geometry."""
    robot, dot, link = name.partition(".")
    if robot not in scene.robots:
        return [name] if name in scene.bodies else []
    chosen = [link] if dot else list(scene.robots[robot].links)
    return [
        f"{robot}.{each}" for each in chosen if each in scene.robots[robot].links and _shaped(scene, robot, each)
    ]


def _shaped(scene: Scene, robot: str, link: str) -> bool:
    return scene.robots[robot].links[link].mesh is not None


def _carried(scene: Scene, name: str) -> bool:
    """Whether a thing is an object that robots may bring anywhere."""
    return name in scene.bodies and scene.bodies[name].movable


def _is_checked(scene: Scene, first: str, second: str) -> bool:
    """Whether a pair would be checked if it were not permitted."""
    if first == second:
        return False
    one, other = first.partition("."), second.partition(".")
    if one[1] and other[1] and one[0] == other[0]:
        return not scene.robots[one[0]].neighbours(one[2], other[2])
    return not (_stands(scene, first) and _stands(scene, second))


def _stands(scene: Scene, name: str) -> bool:
    robot, dot, link = name.partition(".")
    return scene.robots[robot].stands(link) if dot else not scene.bodies[name].movable


# ------------------------------------------------------------------------------------------------------- proofs
def _apart_always(scene: Scene, first: str, second: str) -> float:
    """A distance that two things keep in every configuration, by lengths of links [m]; 0 or less shows nothing."""
    if first.partition(".")[0] == second.partition(".")[0]:
        return 0.0
    (a, r), (b, s) = _reached(scene, first), _reached(scene, second)
    return float(np.linalg.norm(a - b)) - r - s


def _reached(scene: Scene, name: str) -> Ball:
    """A ball that contains a thing in every configuration: about its own middle, or about its robot's first joint."""
    robot, dot, link = name.partition(".")
    if not dot or scene.robots[robot].stands(link):
        return _ball(scene, scene.start, name)
    chosen, part = scene.robots[robot], scene.robots[robot].links[link]
    assert part.mesh is not None
    total = float(np.linalg.norm(part.joint_T_link[:3, 3])) + float(
        np.linalg.norm(part.mesh.vertices, axis=1).max()
    )
    joint = part.joint
    while chosen.tree.parent[joint] > 0 or chosen.tree.kind[joint] == PRISMATIC:
        total += _stroke(chosen, joint) + float(np.linalg.norm(chosen.tree.placement[joint, 9:]))
        joint = int(chosen.tree.parent[joint])
        if joint == 0:
            return np.zeros(3), total
    return np.asarray(chosen.tree.placement[joint, 9:]), total


def _stroke(robot: Robot, joint: int) -> float:
    """How far a prismatic joint may move what it carries [m]."""
    tree = robot.tree
    if tree.kind[joint] != PRISMATIC:
        return 0.0
    source = tree.source[joint]
    ends = (float(tree.ratio[joint] * end + tree.shift[joint]) for end in (tree.lower[source], tree.upper[source]))
    return max(map(abs, ends))


def _ball(scene: Scene, state: GeometricState, name: str) -> Ball:
    """The ball about the box of a thing, where it is in a state."""
    robot, dot, link = name.partition(".")
    mesh = scene.robots[robot].links[link].mesh if dot else scene.bodies[name].mesh
    assert mesh is not None
    return _moved(_own_ball(mesh.vertices), world_T(scene, state, name))


def _own_ball(vertices: Array) -> Ball:
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return middle, float(np.linalg.norm(vertices - middle, axis=1).max())


def _moved(ball: Ball, pose: Array) -> Ball:
    return np.asarray(pose[:3, :3] @ ball[0] + pose[:3, 3]), ball[1]


# ------------------------------------------------------------------------------------------------------ samples
def _met(surroundings: SceneSurroundings, first: str, second: str) -> bool:
    """Whether two things are not proven apart in some sampled configuration; True if their parts cannot be made."""
    scene = surroundings.scene
    for state in _states(scene, [name.partition(".")[0] for name in (first, second) if "." in name]):
        (a, r), (b, s) = _ball(scene, state, first), _ball(scene, state, second)
        if float(np.linalg.norm(a - b)) > r + s + surroundings.budget.epsilon:
            continue
        try:
            if ScenePredicates(surroundings, state).collide(first, second):
                return True
        except InputError:
            return True
    return False


def _states(scene: Scene, robots: Sequence[str]) -> Iterator[GeometricState]:
    """States with some robots at sampled configurations, evenly spread over their joints' limits."""
    names = list(dict.fromkeys(robots))
    trees = {name: scene.robots[name].tree for name in names}
    drawn = {
        name: seeds(tree.lower, tree.upper, stream_key("contact", name), 0, CONFIGURATIONS)
        for name, tree in trees.items()
    }
    for number in range(CONFIGURATIONS):
        yield scene.start.replace({name: tuple(map(float, drawn[name][number])) for name in names})
