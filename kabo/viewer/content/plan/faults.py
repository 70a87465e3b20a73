"""Faults of a plan: nodes that lead nowhere are refused; of things that its scene does not have a page warns.

Pictures refuse both. All other faults are shown as they are written; `kabo verify` judges.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.plan import Plan, StateChange, topological_order
from kabo.viewer.content.document import View

if TYPE_CHECKING:
    from kabo.language.problem import Problem
    from kabo.scene import Scene

REMEDY = "`kabo verify` lists all that is wrong"


def require_drawable(plan: Plan, scene: "Scene | None" = None, file: str = "plan") -> None:
    """Checks that the nodes of a plan lead to nodes, without a cycle, and that it moves what is in its scene.

    Raises:
        InputError: names each place of the plan where this does not hold.
    """
    found = [Diagnostic(file, 1, 1, message, REMEDY) for message in _loose_ends(plan)]
    if not found and topological_order(plan) is None:
        found = [Diagnostic(file, 1, 1, "the plan has a cycle", REMEDY)]
    if not found and scene is not None:
        hint = "was the plan made for this problem? --problem names another"
        found = [Diagnostic(file, 1, 1, message, hint) for message in _strangers(plan, scene)]
    if found:
        raise InputError(found)


def plan_warnings(plan: Plan, problem: "Problem", scene: "Scene | None", file: str) -> list[View]:
    """Warnings in the form of findings: the plan was made from other files, or moves what the scene does not have."""
    said = [*_changed_files(plan, problem), *([] if scene is None else _strangers(plan, scene))]
    place = {"file": Path(file).name, "line": 1, "column": 1, "place": None}
    return [{"severity": "warning", "message": message, "hint": REMEDY, **place} for message in said]


def _changed_files(plan: Plan, problem: "Problem") -> Iterator[str]:
    names = sorted(name for name, content in problem.files.items() if plan.files.get(name) != content)
    if names:
        yield f"the plan was made from other contents of {', '.join(names)}: what is shown may not fit together"


def _loose_ends(plan: Plan) -> Iterator[str]:
    if plan.root not in plan.nodes:
        yield f"$.root: there is no node {plan.root}"
    for name, node in plan.nodes.items():
        for successor in dict.fromkeys(node.successors):
            if successor not in plan.nodes:
                yield f"$.nodes.{name}: leads to {successor}, and there is no such node"


def _strangers(plan: Plan, scene: "Scene") -> Iterator[str]:
    parents = {"world", *scene.bodies, *scene.regions}
    parents |= {f"{robot.name}.{link}" for robot in scene.robots.values() for link in robot.links}
    changes = [
        ("$.start", plan.start),
        *((f"$.nodes.{name}.after", node.after) for name, node in plan.nodes.items()),
    ]
    for place, change in changes:
        if change is not None:
            yield from _strangers_of(place, change, scene, parents)


def _strangers_of(place: str, change: StateChange, scene: "Scene", parents: set[str]) -> Iterator[str]:
    for name in change.robots:
        if name not in scene.robots:
            yield _absent(f"{place}.robots", "robot", name, scene.robots)
    for name, pose in change.objects.items():
        if name not in scene.movable:
            yield _absent(f"{place}.objects", "movable object", name, scene.movable)
        elif pose.parent not in parents:
            yield _absent(f"{place}.objects.{name}", "body or link", pose.parent, parents)


def _absent(place: str, what: str, name: str, known: Iterable[str]) -> str:
    near = did_you_mean(name, sorted(known))
    return f'{place}: the scene has no {what} "{name}"' + (f"; {near}" if near else "")
