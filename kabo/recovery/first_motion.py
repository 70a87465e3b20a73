"""A plan that is proven while it is carried out: its first motion before robots move, the rest meanwhile."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from kabo.geometry_server import GeometryServer
from kabo.plan import Certificate, Clearance, Node, Plan
from kabo.recovery.known_parts import certificate_with_parts
from kabo.recovery.node_ways import files_of
from kabo.scene import Scene, beginning_at
from kabo.verify import Report

ENOUGH = 0.7  # of a clearance: rather than with less of it, robots wait until the verifier has seen tighter parts


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


def with_parts_of(earlier: Plan, first: Plan, scene: Scene) -> Plan:
    """The plan of a first motion, proven with the parts of the plan that is carried out so far, if these suffice.

    They do not if they prove less than `ENOUGH` of the clearance that the first motion's own certificate states.
    """
    assert first.start is not None and first.certificate is not None
    there, clearance = beginning_at(scene, first.start), float(first.options.get("clearance") or 0.0)
    server = GeometryServer(there, first.certificate.epsilon, clearance=clearance)
    made = certificate_with_parts(first, server.surroundings, earlier)
    if made is None or _least(made) < ENOUGH * _least(first.certificate):
        return first
    return replace(first, certificate=made)


def _least(certificate: Certificate) -> float:
    near = certificate.near or 0.0
    return min((_clearance(each, near) for each in certificate.segments), default=near)


def _clearance(stated: Clearance, near: float) -> float:
    return near if stated.clearance is None else stated.clearance


def stating(plan: Plan, first: Plan) -> Plan:
    """A plan that claims no more clearance of its first node than is proven of it in the plan of its first motion."""
    assert plan.certificate is not None and first.certificate is not None
    near = plan.certificate.near or 0.0
    proven = {each.segment: each for each in first.certificate.segments}
    segments = tuple(
        min(each, proven[each.segment], key=lambda one: _clearance(one, near)) if each.node == plan.root else each
        for each in plan.certificate.segments
    )
    return replace(plan, certificate=replace(plan.certificate, segments=segments))


def begun(check: Callable[[], Report]) -> "Future[Report]":
    """The report of a check that another thread makes."""
    thread = ThreadPoolExecutor(1, "kabo verification")
    found = thread.submit(check)
    thread.shutdown(wait=False)
    return found
