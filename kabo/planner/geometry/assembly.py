"""Builds the plan from an evaluated skeleton: nodes with motions, equal nodes shared [docs/reference/plans.md#sharing]."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation, whole_state
from kabo.knowledge.actions import GroundAction, RunTimeArgument
from kabo.language.problem import Problem
from kabo.language.recorded_paths import recorded_files
from kabo.plan import Learned, Node, Plan, PlanBuilder, Segment, State, ValueOf
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.search.skeleton import SkeletonNode


def assemble(
    problem: Problem,
    variants: tuple[Variant, ...],
    server: ProcedureServer | None,
    files: Mapping[str, str],
    options: Mapping[str, str | float | int | None],
    begun: State | None = None,
) -> Plan:
    """The plan for the variants of an evaluation in which every call succeeded; the first becomes the root.

    `begun` is the state of a run in which it begins, if it does not begin where the problem does.
    """
    builder = PlanBuilder()
    handles = handles_of(variants, server, builder)
    start = (
        None
        if server is None
        else whole_state(server.scene, {**server.scene.start.robots, **server.scene.start.objects})
    )
    root = handles[variants[0]]
    plan = builder.build(root, problem=problem.name, files=files, options=options, start=start)
    nodes = {name: _with_relative_models(node, problem.path.parent) for name, node in plan.nodes.items()}
    return replace(plan, nodes=nodes, done=None if begun is None else begun.done)


def _with_relative_models(node: Node, folder: Path) -> Node:
    """The node with the models of its learned parameters named as the plan's files are: relative to a folder."""
    if not node.learned:
        return node
    paths = (Path(os.path.relpath(each.model, folder)).as_posix() for each in node.learned)
    renamed = tuple(replace(each, model=path) for each, path in zip(node.learned, paths, strict=True))
    return replace(node, learned=renamed)


def handles_of(
    variants: tuple[Variant, ...], server: ProcedureServer | None, builder: PlanBuilder | None = None
) -> dict[Variant, str]:
    """The handle of each variant's node in a plan builder; equal variants share one node."""
    used = builder or PlanBuilder()
    handles: dict[Variant, str] = {}
    for variant in reversed(variants):
        following = {outcome: handles[after] for outcome, after in variant.following.items()}
        handles[variant] = _add(used, variant, following, server)
    return handles


def files_read(problem: Problem, server: ProcedureServer) -> Mapping[str, str]:
    """The hashes of all files that were read, by their names in a plan."""
    return {**problem.files, **recorded_files(server.scene.files.items(), problem.path.parent)}


def _add(
    builder: PlanBuilder,
    variant: Variant,
    following: Mapping[str | None, str],
    server: ProcedureServer | None,
) -> str:
    node, action = variant.node, variant.node.action
    branches = {outcome: handle for outcome, handle in following.items() if outcome is not None}
    if action is None:
        return builder.add(Node("branch", on=node.on, branches=branches)) if branches else builder.goal()
    answer = variant.answer
    motion: tuple[Segment, ...] = ()
    moved: tuple[object, ...] = ()
    learned: tuple[Learned, ...] = ()
    after = None
    if isinstance(answer, Success) and server is not None and action.call is not None:
        motion, learned = answer.motion, answer.learned
        single = server.single(action.call, variant.situation)
        moved = tuple((name, variant.situation.values(name)) for name in single)
        changes = {n: v for n, v in answer.changes.items() if variant.situation.values(n) != (v,)}
        after = whole_state(server.scene, changes) if changes else None
    common: dict[str, Any] = {
        "action": action.name,
        "arguments": _arguments(action),
        "motion": motion,
        "after": after,
        "learned": learned,
    }
    common |= {"overlap": variant.overlap if motion else 0.0}
    if node.on is not None:
        return builder.add(Node("sense", on=node.on, branches=branches, **common), moved)
    kind = "sense" if node.delivers else "action"
    made = Node(kind, next=following[None], delivers=node.delivers, **common)  # type: ignore[arg-type]
    return builder.add(made, moved)


def _arguments(action: GroundAction) -> dict[str, str | ValueOf]:
    return {
        name: ValueOf(value.term) if isinstance(value, RunTimeArgument) else value
        for name, value in action.arguments.items()
    }


def symbolic_variants(root: SkeletonNode, order: list[SkeletonNode]) -> tuple[Variant, ...]:
    """The skeleton's nodes as variants without geometry, in the order of `order`, which starts with the root."""
    nothing = Situation({}, {})
    made = {node: Variant(node, nothing, frozenset()) for node in order}
    for node, variant in made.items():
        following = dict(node.outcomes) if node.outcomes else {} if node.next is None else {None: node.next}
        variant.following.update({outcome: made[after] for outcome, after in following.items()})
    return tuple(made.values())
