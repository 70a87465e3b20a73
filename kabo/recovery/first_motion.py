"""A plan that is proven while it is carried out: its first motion before robots move, the rest meanwhile."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from kabo.plan import Node, Plan
from kabo.recovery.node_ways import files_of
from kabo.scene import Scene
from kabo.verify import Report


def first_motion(plan: Plan, scene: Scene) -> Plan | None:
    """The plan of the first node alone, to be judged by its motion in its scene.

    Args:
        plan: a plan with a certificate; what it proves of this node is kept. scene: its scene, loaded from a file.

    Returns:
        the plan, whose node has the name that it had; None if nothing moves in the first node, or nothing afterwards, or if
        the next node begins before it has ended: what both use, a scene alone does not tell.
    """
    certificate = plan.certificate
    root = plan.nodes[plan.root]
    if certificate is None or not root.motion or any(plan.nodes[name].overlap > 0.0 for name in root.successors):
        return None
    if not any(node.motion for name, node in plan.nodes.items() if name != plan.root):
        return None
    goal = next(name for name, node in plan.nodes.items() if node.kind == "goal")
    first = replace(
        root,
        kind="action", arguments={}, learned=(), next=goal, on=None, branches={}, delivers=(),
    )  # fmt: skip
    own = replace(
        certificate,
        segments=tuple(each for each in certificate.segments if each.node == plan.root),
        proofs=tuple(each for each in certificate.proofs if each.node == plan.root),
    )
    nodes = {plan.root: first, goal: Node("goal")}
    return replace(plan, problem="first", files=files_of(scene), nodes=nodes, certificate=own, done=None)


def begun(check: Callable[[], Report]) -> "Future[Report]":
    """The report of a check that another thread makes."""
    thread = ThreadPoolExecutor(1, "kabo verification")
    found = thread.submit(check)
    thread.shutdown(wait=False)
    return found
