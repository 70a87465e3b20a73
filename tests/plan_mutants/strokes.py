"""Mutants of supports and strokes: contact where nothing stands, strokes that are none of their family."""

from dataclasses import replace

import numpy as np

from kabo.plan import Plan
from tests.plan_mutants.core import (
    Case,
    a_stroke,
    detour,
    moved_row,
    mutation,
    near_first,
    pick,
    rebuilt,
    sideways,
    through,
    tool_pose,
)


# ------------------------------------------------------------------------------------------------------------- supports
@mutation
def pushed_into_its_support_and_dragged(case, rng):
    """What is lifted is pushed down first and moved aside there: it was in contact, so it goes into its support."""
    down = np.array([0.0, 0.0, -rng.uniform(0.3e-3, 1.9e-3)])
    return detour(case, rng, ("lift",), [down, sideways(rng, 0.05, 0.2)])


@mutation
def lowered_too_deep_and_raised(case, rng):
    """What is put down goes below where it ends to stand."""
    return detour(case, rng, ("lower",), [np.array([0.0, 0.0, -rng.uniform(0.2e-3, 1.9e-3)])])


@mutation
def dragged_over_its_support(case, rng):
    """What is lifted slides before it rises: contact where it does not stand."""
    return detour(case, rng, ("lift",), [sideways(rng, 0.02, 0.1)])


@mutation
def dragged_to_its_place(case, rng):
    """What is put down slides to where it ends."""
    return detour(case, rng, ("lower",), [sideways(rng, 0.02, 0.1)])


@mutation
def pushed_down_before_it_rises(case, rng):
    """Straight down and up again."""
    return detour(case, rng, ("lift",), [np.array([0.0, 0.0, -rng.uniform(0.2e-3, 1.9e-3)])])


@mutation
def another_body_as_support(case, rng):
    """The plan says that the object stands on something else, where it does not touch."""
    found = a_stroke(case, rng, "lift", "lower")
    if found is None:
        return None
    name, i, segment = found
    chosen = [g for g in segment.grants if g.kind == "support"]
    if not chosen:
        return None
    grant = pick(rng, chosen)
    standing = [b for b in case.scene.bodies if b not in grant.bodies and b not in case.scene.movable]
    other = pick(rng, standing) or "nothing"
    made = replace(grant, bodies=(grant.bodies[0], other))
    contacts = tuple(p for p in segment.allowed_contacts if set(p) != set(grant.bodies)) + (made.bodies,)
    grants = tuple(made if g == grant else g for g in segment.grants)
    return case.with_segments(name, {i: replace(segment, allowed_contacts=contacts, grants=grants)})


@mutation
def support_permitted_on_the_way(case, rng):
    """Contact with the support is permitted all along the way there, where the object does not stand."""
    found = a_stroke(case, rng, "lower")
    if found is None or found[1] == 0:
        return None
    name, i, segment = found
    grants = [g for g in segment.grants if g.kind == "support"]
    before = case.plan.nodes[name].motion[i - 1]
    more = replace(
        before,
        allowed_contacts=(*before.allowed_contacts, *(g.bodies for g in grants)),
        grants=(*before.grants, *grants),
    )
    return case.with_segments(name, {i - 1: more})


# -------------------------------------------------------------------------------------------------------------- strokes
def bent(case: Case, rng: np.random.Generator, *kinds: str) -> Plan | None:
    """A stroke that goes aside in its straight part, and back to its line."""
    found = a_stroke(case, rng, *kinds)
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    start, end = tool_pose(case, segment, rows[0])[:3, 3], tool_pose(case, segment, rows[1])[:3, 3]
    way = (end - start) / np.linalg.norm(end - start)
    aside = np.cross(way, rng.normal(size=3))
    aside *= rng.uniform(0.006, 0.02) / np.linalg.norm(aside)
    row = moved_row(case, segment, rows[0], rng.uniform(0.004, 0.006) * way + aside)
    if row is None:
        return None
    return rebuilt(case, name, i, kind, [rows[0], row, *rows[1:]])


@mutation
def a_bent_approach(case, rng):
    """The hand comes from aside: 45 degrees or more off its family's direction."""
    return bent(case, rng, "approach")


@mutation
def a_bent_lift(case, rng):
    """What is lifted goes aside first."""
    return bent(case, rng, "lift")


@mutation
def a_bent_lowering(case, rng):
    """What is put down comes from aside."""
    return bent(case, rng, "lower")


@mutation
def a_bent_retreat(case, rng):
    """The hand leaves aside."""
    return bent(case, rng, "retreat")


def cut_short(case: Case, rng: np.random.Generator, kind: str) -> Plan | None:
    """A stroke that begins after nine tenths of its way: shorter than half of its family's least length."""
    found = a_stroke(case, rng, kind)
    if found is None or found[1] == 0:
        return None
    name, i, segment = found
    before = case.plan.nodes[name].motion[i - 1]
    if before.joints != segment.joints:
        return None
    share, rows = rng.uniform(0.9, 0.97), segment.waypoints
    row = tuple(np.array(rows[-2]) + share * (np.array(rows[-1]) - rows[-2]))
    return through(case, name, {i - 1: [*before.waypoints, *rows[1:-1], row], i: [row, rows[-1]]})


@mutation
def an_approach_cut_short(case, rng):
    """The hand comes anyhow, and only the last millimetres are called an approach."""
    return cut_short(case, rng, "approach")


@mutation
def a_lowering_cut_short(case, rng):
    """What is put down comes anyhow, and only the last millimetres are called so."""
    return cut_short(case, rng, "lower")


@mutation
def a_stroke_that_comes_back(case, rng):
    """Nearly to the end, back to where it touches or nearly so, and away again."""
    found = a_stroke(case, rng, "lift", "lower", "approach", "retreat")
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    back = tuple(np.array(rows[0]) + rng.uniform(0.0, 0.1) * (np.array(rows[1]) - rows[0]))
    return rebuilt(case, name, i, kind, [rows[0], *rows[1:], back, *rows[1:]])


@mutation
def a_stroke_that_turns(case, rng):
    """The last joint turns by 3 degrees or more, near to what is touched, and back."""
    found = a_stroke(case, rng, "lift", "lower", "approach", "retreat")
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    row = np.array(rows[0]) + 0.02 * (np.array(rows[1]) - rows[0])
    row[-1] += rng.choice([-1, 1]) * rng.uniform(0.05, 0.5)
    return rebuilt(case, name, i, kind, [rows[0], tuple(row), *rows[1:]])


@mutation
def a_hand_that_stays(case, rng):
    """The retreat is left out."""
    found = a_stroke(case, rng, "retreat")
    if found is None:
        return None
    name, i, segment = found
    node = case.plan.nodes[name]
    if i != len(node.motion) - 1 or node.after is None:
        return None
    joints = {**node.after.robots[segment.robot], **dict(zip(segment.joints, segment.waypoints[0], strict=True))}
    after = replace(node.after, robots={**node.after.robots, segment.robot: joints})
    return case.with_node(name, motion=node.motion[:-1], after=after)


@mutation
def a_hand_that_squeezes(case, rng):
    """The hand closes farther than its family says, and opens to that again."""
    found = a_stroke(case, rng, "close")
    if found is None:
        return None
    name, i, segment = found
    (open_,), (grip,) = segment.waypoints[0], segment.waypoints[-1]
    beyond = grip + np.sign(grip - open_) * rng.uniform(0.002, 0.0069)
    if beyond < 0.0:
        return None
    return through(case, name, {i: [(open_,), (beyond,), (grip,)]})
