"""INSPECTION: barcodes are read by looking, each outcome has its branch, and what hides a box is moved first."""

from collections.abc import Iterator
from functools import cache

import pytest

import kabo
from kabo.plan import Node, Plan
from tests.domains.scenes import DOMAINS, problem_of

OPEN, COVERED = (DOMAINS / "inspection" / name for name in ("three_boxes.yaml", "three_boxes_covered.yaml"))


@cache
def plan_of(path: object) -> Plan:
    solved = kabo.solve(problem_of(path))  # type: ignore[arg-type]
    assert solved.plan is not None
    return solved.plan


def actions(plan: Plan) -> Iterator[Node]:
    return (node for node in plan.nodes.values() if node.action is not None)


@pytest.mark.slow
@pytest.mark.parametrize("path", [OPEN, COVERED], ids=lambda path: path.stem)
def test_the_plan_is_verified_and_sorts_every_box_whatever_is_in_it(path: object) -> None:
    plan = plan_of(path)
    report = kabo.verify(problem_of(path), plan)  # type: ignore[arg-type]
    assert report.ok, report.findings
    assert {node.arguments["b"] for node in actions(plan) if node.action == "read_barcode"} == {
        "box_1", "box_2", "box_3",
    }  # fmt: skip
    trays = {(node.arguments["b"], node.arguments["t"]) for node in actions(plan) if node.action == "sort"}
    assert len(trays) == 6


@pytest.mark.slow
def test_the_panel_is_moved_only_where_it_hides_a_box() -> None:
    assert all(node.arguments.get("o") != "panel" for node in actions(plan_of(OPEN)))
    moved = [node for node in actions(plan_of(COVERED)) if node.action == "put_aside"]
    assert moved
