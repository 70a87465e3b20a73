"""A plan that is proven while it is carried out: its first motion before robots move, the rest meanwhile."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import TypeVar

from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.plan import Certificate, Clearance, Node, Plan
from kabo.planner.certify.certifying import certified
from kabo.recovery.known_parts import certificate_with_parts
from kabo.recovery.node_ways import files_of
from kabo.scene import Scene

_Found = TypeVar("_Found")
ENOUGH = 0.7  # of a clearance: rather than with less of it, robots wait until the verifier has seen tighter parts


def first_motion(plan: Plan, scene: Scene) -> Plan | None:
    """The plan of the first node alone, to be judged by its motion in its scene.

    Args:
        plan: a plan; what its certificate proves of this node is kept. scene: its scene, loaded from a file.

    Returns:
        the plan, whose node has the name that it had; None if nothing moves in the first node, or nothing afterwards, or if
        the next node begins before it has ended: what both use, a scene alone does not tell.
    """
    root, certificate = plan.nodes[plan.root], plan.certificate
    if not root.motion or any(plan.nodes[name].overlap > 0.0 for name in root.successors):
        return None
    if not any(node.motion for name, node in plan.nodes.items() if name != plan.root):
        return None
    goal = next(name for name, node in plan.nodes.items() if node.kind == "goal")
    first = replace(
        root,
        kind="action", arguments={}, learned=(), next=goal, on=None, branches={}, delivers=(),
    )  # fmt: skip
    own = certificate and replace(
        certificate,
        segments=tuple(each for each in certificate.segments if each.node == plan.root),
        proofs=tuple(each for each in certificate.proofs if each.node == plan.root),
    )
    nodes = {plan.root: first, goal: Node("goal")}
    return replace(plan, problem="first", files=files_of(scene), nodes=nodes, certificate=own, done=None)


def begun_with(plan: Plan, first: Plan) -> Plan:
    """The plan with the motion and the certificate of its first node alone, as `first` has them."""
    nodes = {
        name: node if name == plan.root else replace(node, motion=(), overlap=0.0)
        for name, node in plan.nodes.items()
    }
    return replace(plan, nodes=nodes, certificate=first.certificate)


def goes_on(first: Plan | None, whole: Plan) -> bool:
    """Whether a plan begins as another one, of which the first motion is known, and has the same nodes."""
    if first is None:
        return False
    shape = {name: (node.successors, node.action, node.on) for name, node in first.nodes.items()}
    begin = first.nodes[first.root]
    return (
        whole.root == first.root
        and whole.nodes[whole.root].motion == begin.motion
        and shape == {name: (node.successors, node.action, node.on) for name, node in whole.nodes.items()}
    )


def with_known_parts(first: Plan, surroundings: SceneSurroundings, earlier: Plan) -> Plan:
    """The plan of a first motion with a certificate; its parts are those of an earlier plan, if they suffice.

    They do not if they prove less than `ENOUGH` of the clearance that is proven with parts of its own.

    Args:
        first: the plan, without a certificate. surroundings: the scene in which it begins.
        earlier: a plan that was verified.
    """
    own = certified(first, surroundings)[0]
    known = certificate_with_parts(first, surroundings, earlier)
    if known is None or (own.certificate is not None and _least(known) < ENOUGH * _least(own.certificate)):
        return own
    return replace(first, certificate=known)


def _least(certificate: Certificate) -> float:
    near = certificate.near or 0.0
    return min((_clearance(each, near) for each in certificate.segments), default=near)


def _clearance(stated: Clearance, near: float) -> float:
    return near if stated.clearance is None else stated.clearance


def in_a_thread(work: Callable[[], _Found]) -> "Future[_Found]":
    """What another thread finds."""
    thread = ThreadPoolExecutor(1, "kabo recovery")
    found = thread.submit(work)
    thread.shutdown(wait=False)
    return found
