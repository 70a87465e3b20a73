"""A plan in the view document: its nodes and where they are drawn, motions, knowledge, margins and proofs."""

from typing import TYPE_CHECKING, Any

from kabo.plan import Learned, Node, Plan, plan_statistics, topological_order
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import View
from kabo.viewer.content.plan.boxes import Card, PlanPicture, argument_text, in_order_of_parameters, plan_picture
from kabo.viewer.content.plan.faults import require_drawable
from kabo.viewer.content.plan.knowledge import knowledge_view
from kabo.viewer.content.plan.motion import handovers_of, motion_view, state_view
from kabo.viewer.content.plan.proofs import clearances_of, proofs_of

if TYPE_CHECKING:
    from kabo.language.problem import Problem
    from kabo.scene import Scene

WRONG = (ValueError, KeyError, IndexError, RecursionError)  # what computing with a wrong plan raises


def plan_view(
    plan: Plan,
    problem: "Problem | None",
    scene: "Scene | None",
    arrays: Arrays,
    *,
    margins: bool = True,
    sweeps: bool = False,
    file: str = "plan",
) -> View | None:
    """The part `plan` of a view document; without its problem, there is no knowledge in it.

    Motions are played as they are written, right or wrong: whether a plan holds is said by `kabo verify`. What cannot
    be found out of a wrong plan, its knowledge or its margins, is null; margins are also left out if they are not
    wanted, since they take most of the time. With `sweeps` there is what moving things sweep, segment by segment.

    Raises:
        InputError: the plan, of `file`, has nodes that lead nowhere, or a cycle; or the problem uses something that
            kabo does not support.
    """
    require_drawable(plan, None, file)
    if problem is not None:
        plan = in_order_of_parameters(plan, problem)
    picture = plan_picture(plan)
    found = _geometry(plan, scene, arrays, margins, sweeps)
    clearances = clearances_of(plan)
    return {
        "problem": plan.problem,
        "root": plan.root,
        "branches": plan_statistics(plan).plan_leaves,
        "epsilon": _epsilon(plan, scene),
        "near": None if plan.certificate is None else plan.certificate.near,
        "gaps": list(plan.certificate_gaps),
        "options": dict(plan.options),
        "start": state_view(plan.start),
        "nodes": [
            _node(name, plan.nodes[name], picture.cards[name], picture)
            | {"motion": found["motions"].get(name), "margin": found["margins"].get(name)}
            | {"sweeps": found["sweeps"].get(name), "clearances": clearances.get(name, [])}
            for name in picture.cards
        ],
        "edges": [
            {
                "from": route.source,
                "to": route.target,
                "port": route.port,
                "points": [list(p) for p in route.points],
            }
            for route in picture.layout.routes
        ],
        "size": [picture.layout.width, picture.layout.height],
        "pairs": found["pairs"],
        "unmeasured": found["unmeasured"],
        "knowledge": None if problem is None else knowledge_view(plan, problem),
        "proofs": proofs_of(plan),
    }


def _node(name: str, node: Node, card: Card, picture: PlanPicture) -> dict[str, Any]:
    place = picture.layout.places[name]
    return {
        "id": name,
        "kind": node.kind,
        "action": node.action,
        "arguments": [[key, argument_text(value)] for key, value in node.arguments.items()],
        "on": node.on,
        "delivers": list(node.delivers),
        "next": None if node.branches else node.next,
        "outcomes": [{"outcome": outcome, "to": target} for outcome, target in node.branches.items()],
        "learned": [_learned(each) for each in node.learned],
        "box": {
            "x": place.x,
            "y": place.y,
            "width": place.width,
            "height": place.height,
            "lines": list(card.lines),
            "chips": [{"text": chip.outcome, "x": chip.x, "width": chip.width} for chip in card.chips],
        },
    }


def _learned(learned: Learned) -> dict[str, Any]:
    return {
        "model": learned.model,
        "case": dict(learned.case),
        "parameters": dict(learned.parameters),
        "validity": learned.validity,
        "expected": dict(learned.expected),
    }


def _epsilon(plan: Plan, scene: "Scene | None") -> float | None:
    asked = plan.options.get("epsilon")
    if isinstance(asked, int | float):
        return float(asked)
    return None if scene is None else scene.epsilon


def _geometry(plan: Plan, scene: "Scene | None", arrays: Arrays, margins: bool, sweeps: bool) -> dict[str, Any]:
    """By node the `motions`, `margins` and `sweeps`; the `pairs` of margins; `unmeasured`: things without convex parts."""
    order = topological_order(plan) or []
    moving = [name for name in order if plan.nodes[name].motion or plan.nodes[name].after is not None]
    found: dict[str, Any] = {"motions": {}, "margins": {}, "sweeps": {}, "pairs": [], "unmeasured": []}
    if scene is None or plan.start is None:
        found["motions"] = {name: motion_view(plan.nodes[name], []) for name in moving}
        return found
    from kabo.geometry_server import read_prepared  # loads kernels, as all below does
    from kabo.planner.certify.component_values import ComponentValues
    from kabo.viewer.content.plan.margins import MarginCurves
    from kabo.viewer.content.plan.moving_things import server_of
    from kabo.viewer.content.plan.sweeps import sweeps_of

    try:
        values, surroundings = ComponentValues(plan, scene, order), server_of(plan, scene).surroundings
    except WRONG:
        return found | {"motions": {name: motion_view(plan.nodes[name], []) for name in moving}}
    if margins or sweeps:
        found["unmeasured"] = list(read_prepared(surroundings.enclosures))
    curves = MarginCurves(plan, surroundings, values)
    for name in moving:
        try:
            found["motions"][name] = motion_view(plan.nodes[name], handovers_of(name, plan, values, scene))
            if margins and not found["unmeasured"]:
                found["margins"][name] = curves.of(name)
            if sweeps and not found["unmeasured"]:
                found["sweeps"][name] = sweeps_of(name, plan, values, surroundings, arrays)
        except WRONG:  # names or shapes that the scene does not have, things that hang on each other
            found["motions"].setdefault(name, motion_view(plan.nodes[name], []))
    return found | {"pairs": curves.pairs}
