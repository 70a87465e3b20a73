"""A plan that is proven while it is carried out: its first motion before robots move, the rest meanwhile."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from kabo.execution.motions import motion_of
from kabo.plan import Node, Plan
from kabo.recovery.node_ways import files_of
from kabo.scene import Scene
from kabo.verify import Report


def first_motion(plan: Plan, scene: Scene) -> Plan | None:
    """The plan of the nodes that are carried out before anything is sensed or rests, to be judged by itself in its scene.

    Args:
        plan: a plan with a certificate; what it proves of these nodes is kept. scene: its scene, loaded from a file.

    Returns:
        the plan, whose nodes have the names that they had; None if nothing moves in the first node, or nothing afterwards.
    """
    certificate = plan.certificate
    if certificate is None or not plan.nodes[plan.root].motion:
        return None
    names = motion_of(plan, plan.root, scene).nodes
    if not any(node.motion for name, node in plan.nodes.items() if name not in names):
        return None
    goal = next(name for name, node in plan.nodes.items() if node.kind == "goal")
    nodes = {name: replace(plan.nodes[name], kind="action", arguments={}, learned=()) for name in names}
    nodes[names[-1]] = replace(nodes[names[-1]], next=goal, on=None, branches={}, delivers=())
    own = replace(
        certificate,
        segments=tuple(each for each in certificate.segments if each.node in nodes),
        proofs=tuple(each for each in certificate.proofs if each.node in nodes),
    )
    nodes[goal] = Node("goal")
    return replace(plan, problem="first", files=files_of(scene), nodes=nodes, certificate=own, done=None)


def begun(check: Callable[[], Report]) -> "Future[Report]":
    """The report of a check that another thread makes."""
    thread = ThreadPoolExecutor(1, "kabo verification")
    found = thread.submit(check)
    thread.shutdown(wait=False)
    return found
