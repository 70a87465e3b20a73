"""Mutants of what is taken and let go, of actions and branches."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kabo.plan import Plan, Segment
from tests.plan_mutants.core import Case, mutation, pick


# ---------------------------------------------------------------------------------------------------------- attachments
def with_attaching(
    case: Case, rng: np.random.Generator, change: Callable[[Segment], Segment], what: str
) -> Plan | None:
    """The plan with a segment changed that attaches or detaches."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if getattr(s, what)])
    if found is None:
        return None
    name, i, segment = found
    return case.with_segments(name, {i: change(segment)})


@mutation
def nothing_taken(case, rng):
    """The hand closes, but takes nothing."""
    return with_attaching(case, rng, lambda s: replace(s, attach=()), "attach")


@mutation
def nothing_let_go(case, rng):
    """The hand opens, but lets nothing go. (What is put together with another part hangs on that.)"""
    return None if case.scene.mates else with_attaching(case, rng, lambda s: replace(s, detach=()), "detach")


@mutation
def taken_by_another_link(case, rng):
    """The object hangs on the base."""

    def change(segment):
        links = [
            link
            for link in case.scene.robots[segment.robot].links
            if link in ("base_link", "link_1", "arm_link_1")
        ]
        return replace(segment, attach=((segment.attach[0][0], f"{segment.robot}.{pick(rng, links)}"),))

    return with_attaching(case, rng, change, "attach")


@mutation
def another_object_taken(case, rng):
    """What the call does not name."""

    def change(segment):
        others = [name for name in case.scene.bodies if name != segment.attach[0][0]]
        return replace(segment, attach=((pick(rng, others), segment.attach[0][1]),))

    return with_attaching(case, rng, change, "attach")


@mutation
def taken_before_the_hand_is_there(case, rng):
    """At the end of the way there."""
    found = pick(rng, [(n, i) for n, i, kind in case.strokes if kind == "close"])
    if found is None:
        return None
    name, i = found
    motion = case.plan.nodes[name].motion
    early = replace(motion[i - 1], attach=motion[i].attach)
    return case.with_segments(name, {i - 1: early, i: replace(motion[i], attach=())})


# --------------------------------------------------------------------------------------------------- knowledge, branches
def acting(case: Case) -> list[str]:
    """The nodes that act."""
    return [name for name, node in case.plan.nodes.items() if node.action is not None]


@mutation
def the_goal_too_early(case, rng):
    """After fewer actions than the shortest plan needs: the first one, or none of those that follow."""
    goal = next(name for name, node in case.plan.nodes.items() if node.kind == "goal")
    node = case.plan.nodes[case.plan.root]
    if node.kind != "action" or node.next == goal:
        return None
    return _only_reached(replace(case.plan, nodes={**case.plan.nodes, case.plan.root: replace(node, next=goal)}))


def _only_reached(plan: Plan) -> Plan:
    """The plan without nodes that nothing leads to, and its certificate without their proofs."""
    reached, waiting = set(), [plan.root]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            waiting.extend(plan.nodes[name].successors)
    certificate = plan.certificate
    if certificate is not None:
        certificate = replace(
            certificate,
            proofs=tuple(p for p in certificate.proofs if p.node in reached),
            segments=tuple(s for s in certificate.segments if s.node in reached),
        )
    nodes = {name: node for name, node in plan.nodes.items() if name in reached}
    return replace(plan, nodes=nodes, certificate=certificate)


@mutation
def an_action_left_out(case, rng):
    """The first one: what it does is needed, for shipped plans are found without a needless first action."""
    node = case.plan.nodes[case.plan.root]
    if node.kind != "action":
        return None
    return _only_reached(replace(case.plan, root=node.next))


@mutation
def outcomes_taken_for_each_other(case, rng):
    """The ways after two outcomes are exchanged."""
    found = [n for n, node in case.plan.nodes.items() if len(set(node.branches.values())) > 1]
    name = pick(rng, found)
    if name is None:
        return None
    outcomes = list(case.plan.nodes[name].branches.items())
    keys, ways = [k for k, _ in outcomes], [v for _, v in outcomes]
    return case.with_node(name, branches=dict(zip(keys, ways[1:] + ways[:1], strict=True)))


@mutation
def an_outcome_without_a_way(case, rng):
    """One of two outcomes is not planned for."""
    name = pick(rng, [n for n, node in case.plan.nodes.items() if len(node.branches) > 1])
    if name is None:
        return None
    branches = dict(case.plan.nodes[name].branches)
    branches.pop(pick(rng, sorted(branches)))
    return _only_reached(case.with_node(name, branches=branches))


@mutation
def another_argument(case, rng):
    """An action about something else than its motion moves."""
    name = pick(rng, [n for n in acting(case) if case.plan.nodes[n].motion])
    node = case.plan.nodes[name]
    key = pick(rng, sorted(node.arguments))
    others = sorted({*case.scene.robots, *case.scene.bodies} - {node.arguments[key]})
    return case.with_node(name, arguments={**node.arguments, key: pick(rng, others)})


@mutation
def an_action_that_does_not_exist(case, rng):
    """A name that the domain does not have."""
    name = pick(rng, acting(case))
    return case.with_node(name, action=f"{case.plan.nodes[name].action}_{rng.integers(99)}")


@mutation
def a_cycle(case, rng):
    """An action that leads back to the root."""
    name = pick(rng, [n for n in acting(case) if case.plan.nodes[n].next is not None])
    return case.with_node(name, next=case.plan.root)


@mutation
def no_motion(case, rng):
    """An action without what it moves."""
    found = [n for n, node in case.plan.nodes.items() if any(s.attach or s.detach for s in node.motion)]
    name = pick(rng, found)
    plan = case.with_node(name, motion=(), after=None, overlap=0.0)
    certificate = plan.certificate
    proofs = tuple(p for p in certificate.proofs if p.node != name)
    segments = tuple(s for s in certificate.segments if s.node != name)
    return replace(plan, certificate=replace(certificate, proofs=proofs, segments=segments))


@mutation
def other_files(case, rng):
    """The hash of a file is another one."""
    name = pick(rng, sorted(case.plan.files))
    digest = "sha256:" + "".join(rng.choice(list("0123456789abcdef"), 64))
    return replace(case.plan, files={**case.plan.files, name: digest})


@mutation
def an_overlap_of_one_robot(case, rng):
    """A motion begins before that of the same robot has ended."""
    followers = [
        (name, node.next)
        for name, node in case.plan.nodes.items()
        if node.motion
        and node.next is not None
        and {s.robot for s in node.motion} & {s.robot for s in case.plan.nodes[node.next].motion}
        and sum(node.next in other.successors for other in case.plan.nodes.values()) == 1
    ]
    found = pick(rng, followers)
    return None if found is None else case.with_node(found[1], overlap=round(float(rng.uniform(0.1, 1.0)), 6))
