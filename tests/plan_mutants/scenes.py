"""Mutants of scenes and of mates: the plan is no longer one for what the files say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kabo.language.problem import Problem
from kabo.language.scene_description import BodyDescription, FeatureName, Mate, Stroke
from tests.plan_mutants.core import Case, a_stroke, moved_row, mutation, pick, through, tool_pose
from tests.plan_mutants.statements import with_grant


# ------------------------------------------------------------------------------------------------- what the scene says
def with_bodies(case: Case, change: Callable[[BodyDescription], BodyDescription]) -> Problem:
    """The problem with all bodies changed."""
    assert case.problem.scene is not None
    return case.with_scene(bodies={name: change(body) for name, body in case.problem.scene.bodies.items()})


def with_grasps(case: Case, **changes) -> Problem:
    """The problem with all grasp families changed."""
    return with_bodies(
        case, lambda body: replace(body, grasps={n: replace(g, **changes) for n, g in body.grasps.items()})
    )


UP = FeatureName("world", "up")


@mutation
def the_scene_wants_a_longer_approach(case, rng):
    """At least 30 cm, the plan's are 12 cm and less."""
    least = float(rng.uniform(0.3, 0.6))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), 1, least, least + 0.1))


@mutation
def the_scene_wants_another_approach(case, rng):
    """Against the direction in which the plan's hands come."""
    low = float(rng.uniform(0.02, 0.05))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), -1, low, 0.2))


@mutation
def the_scene_wants_a_longer_lift(case, rng):
    """At least 40 cm, the plan's are 15 cm and less."""
    least = float(rng.uniform(0.4, 0.8))
    return with_grasps(case, lift=Stroke(UP, 1, least, least + 0.1))


@mutation
def the_scene_lifts_downwards(case, rng):
    """Against what the plan does."""
    return with_grasps(case, lift=Stroke(UP, -1, float(rng.uniform(0.02, 0.05)), 0.2))


@mutation
def the_scene_wants_shorter_strokes(case, rng):
    """At most a centimetre; the plan's are three and more."""
    most = float(rng.uniform(0.005, 0.01))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), 1, most / 2, most))


@mutation
def the_scene_wants_another_grip(case, rng):
    """Fingers elsewhere by 5 mm or more."""
    shift = float(rng.uniform(0.005, 0.01))

    def change(body):
        grasps = {
            n: replace(g, fingers={j: v + shift for j, v in (g.fingers or {}).items()})
            for n, g in body.grasps.items()
        }
        return replace(body, grasps=grasps)

    return with_bodies(case, change)


@mutation
def the_scene_wants_another_retreat(case, rng):
    """Straight down, where the plan's hands leave upwards or level."""
    low = float(rng.uniform(0.02, 0.05))
    if not any(kind == "retreat" for _, _, kind in case.strokes) or case.scene.mates:
        return None
    return with_bodies(
        case,
        lambda body: replace(
            body,
            placements={n: replace(p, retreat=Stroke(UP, -1, low, 0.3)) for n, p in body.placements.items()},
        ),
    )


# ---------------------------------------------------------------------------------------------------------------- mates
def with_mates(case: Case, change: Callable[[Mate], Mate]) -> Problem | None:
    """The problem with all mates changed."""
    assert case.problem.scene is not None
    mates = case.problem.scene.mates
    return case.with_scene(mates={name: change(mate) for name, mate in mates.items()}) if mates else None


@mutation
def an_insertion_off_its_axis(case, rng):
    """A way point of the insertion 0.25 to 2 mm aside; its mate's tolerance is 0.1 mm."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    rows = list(segment.waypoints)
    k = int(rng.integers(2, len(rows) - 1))
    ends = [tool_pose(case, segment, rows[j])[:3, 3] for j in (0, -1)]
    aside = np.cross(ends[1] - ends[0], rng.normal(size=3))
    row = moved_row(case, segment, rows[k], aside * rng.uniform(0.25e-3, 2e-3) / np.linalg.norm(aside))
    if row is None:
        return None
    rows[k] = row
    return through(case, name, {i: rows})


@mutation
def an_insertion_that_turns(case, rng):
    """The part turns by 2 degrees or more on its way, and back."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    rows = list(segment.waypoints)
    k = int(rng.integers(2, len(rows) - 1))
    rows[k] = (*rows[k][:-1], rows[k][-1] + rng.choice([-1, 1]) * rng.uniform(0.04, 0.3))
    return through(case, name, {i: rows})


@mutation
def an_insertion_of_few_way_points(case, rng):
    """Straight in joints: it leaves its axis by millimetres."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    return through(case, name, {i: [segment.waypoints[0], segment.waypoints[-1]]})


@mutation
def another_mate(case, rng):
    """The name of another mate of the scene, or of none."""
    names = [*case.scene.mates, f"mate_{rng.integers(99)}"]
    return with_grant(
        case, rng, "mate", lambda grant: replace(grant, by=pick(rng, [n for n in names if n != grant.by]))
    )


@mutation
def the_parts_of_a_mate_turned_round(case, rng):
    """The moving part is called the fixed one."""
    return with_grant(case, rng, "mate", lambda grant: replace(grant, bodies=grant.bodies[::-1]))


@mutation
def a_mate_permitted_on_the_way(case, rng):
    """Contact is permitted before the insertion, too."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    grants = [g for g in segment.grants if g.kind == "mate"]
    before = case.plan.nodes[name].motion[i - 1]
    more = replace(
        before,
        allowed_contacts=(*before.allowed_contacts, *(g.bodies for g in grants)),
        grants=(*before.grants, *grants),
    )
    return case.with_segments(name, {i - 1: more})


@mutation
def the_scene_wants_a_finer_insertion(case, rng):
    """A tolerance that the plan's arms do not keep: less than a micrometre."""
    return with_mates(case, lambda mate: replace(mate, tolerance=float(rng.uniform(1e-7, 1e-6))))


@mutation
def the_scene_inserts_the_other_way(case, rng):
    """From below, or within other bounds."""
    return with_mates(
        case,
        lambda mate: (
            mate
            if mate.insertion is None
            else replace(mate, insertion=replace(mate.insertion, sign=-mate.insertion.sign))
        ),
    )


@mutation
def the_scene_wants_a_longer_insertion(case, rng):
    """At least 30 cm."""
    least = float(rng.uniform(0.3, 0.5))
    return with_mates(
        case,
        lambda mate: (
            mate
            if mate.insertion is None
            else replace(mate, insertion=replace(mate.insertion, minimum=least, maximum=least + 0.1))
        ),
    )


@mutation
def the_scene_mates_elsewhere(case, rng):
    """What the moving part is put on lies a millimetre or more higher."""
    lift = float(rng.uniform(1e-3, 5e-3))

    def higher(name, feature):
        x, y, z = feature.origin
        return replace(feature, origin=(x, y, z + lift)) if name in ("seat", "shoulder", "collar") else feature

    def change(body):
        return replace(body, features={name: higher(name, each) for name, each in body.features.items()})

    return with_bodies(case, change) if case.scene.mates else None
