"""Mutants of what a plan says of its contacts."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kabo.plan import Grant, Plan
from tests.plan_mutants.core import Case, a_stroke, mutation, pick


# ------------------------------------------------------------------------------------------------------------- statements
def with_grant(
    case: Case, rng: np.random.Generator, kind: str, change: Callable[[Grant], Grant | None]
) -> Plan | None:
    """The plan with one of its statements of a kind changed, or without it."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if any(g.kind == kind for g in s.grants)])
    if found is None:
        return None
    name, i, segment = found
    grant = pick(rng, [g for g in segment.grants if g.kind == kind])
    made = change(grant)
    grants = tuple(g if g != grant else made for g in segment.grants)
    return case.with_segments(name, {i: replace(segment, grants=tuple(g for g in grants if g is not None))})


@mutation
def a_contact_that_nothing_grants(case, rng):
    """The statement is missing."""
    return with_grant(case, rng, str(rng.choice(["grasp", "support"])), lambda grant: None)


@mutation
def a_support_of_no_such_family(case, rng):
    """The family does not exist."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, by=f"family_{rng.integers(99)}"))


@mutation
def a_grasp_of_no_such_family(case, rng):
    """The family does not exist."""
    return with_grant(case, rng, "grasp", lambda grant: replace(grant, by=f"family_{rng.integers(99)}"))


@mutation
def a_grasp_of_no_family(case, rng):
    """There is a family that says how the object is held."""
    return with_grant(case, rng, "grasp", lambda grant: replace(grant, by=None))


@mutation
def a_support_by_no_family(case, rng):
    """There is a family that says how the object is lifted."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, by=None))


@mutation
def a_support_called_a_mate(case, rng):
    """No mate puts an object and its support together."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, kind="mate"))


@mutation
def a_support_called_a_grasp(case, rng):
    """A support is no finger."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, kind="grasp", bodies=grant.bodies[::-1]))


@mutation
def a_grasp_by_another_link(case, rng):
    """A link of the arm that is no finger may touch what is held."""
    robots = case.scene.robots

    def change(grant):
        robot = grant.bodies[0].partition(".")[0]
        links = [name for name in robots[robot].links if name not in ("left_finger", "right_finger")]
        return replace(grant, bodies=(f"{robot}.{pick(rng, links)}", grant.bodies[1]))

    return with_grant(case, rng, "grasp", change)


@mutation
def a_grasp_of_what_is_not_held(case, rng):
    """A hand that closes on one object is said to grasp another one, too."""
    found = a_stroke(case, rng, "close", "open")
    if found is None or len(case.scene.movable) < 2:
        return None
    name, i, segment = found
    held = {g.bodies[1] for g in segment.grants}
    other = pick(rng, [body for body in case.scene.movable if body not in held])
    more = [(g.bodies[0], other) for g in segment.grants if g.kind == "grasp"]
    if not more:
        return None
    grants = tuple(Grant("grasp", pair, segment.grants[0].by) for pair in more)
    made = replace(segment, allowed_contacts=(*segment.allowed_contacts, *more), grants=(*segment.grants, *grants))
    return case.with_segments(name, {i: made})


@mutation
def contact_of_an_arm_permitted(case, rng):
    """A link of the arm may touch a body that stands."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if len(s.joints) > 2])
    name, i, segment = found
    links = [f"{segment.robot}.{link}" for link in case.scene.robots[segment.robot].links]
    pairs = [(a, b) for a in links for b in case.scene.bodies if not case.scene.never_collide(a, b)]
    pair = pick(rng, [p for p in pairs if p not in segment.allowed_contacts])
    return case.with_segments(name, {i: replace(segment, allowed_contacts=(*segment.allowed_contacts, pair))})
