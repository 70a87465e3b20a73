import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from kabo.plan import Node, Plan, plan_to_dot

NASTY = 'a "quoted" \\ name\\'


def drawn(dot: str) -> str:
    """What Graphviz reads, in its plain form."""
    if shutil.which("dot") is None:
        pytest.skip("Graphviz is not installed")
    return subprocess.run(["dot", "-Tplain"], input=dot, capture_output=True, text=True, check=True).stdout


def test_every_node_and_every_outcome_is_drawn_once(plan):
    dot = plan.to_dot()
    assert dot == plan_to_dot(plan)
    assert len(re.findall(r"^  \"n\d+\" \[", dot, re.MULTILINE)) == len(plan.nodes)
    edges = re.findall(r'^  "(n\d+)" -> "(n\d+)"', dot, re.MULTILINE)
    assert sorted(edges) == sorted((name, to) for name, node in plan.nodes.items() for to in node.successors)
    assert '[label="true"]' in dot and "dial(c=value of combination(vault), n=2)" in dot


def test_graphviz_reads_what_is_written(plan):
    plain = drawn(plan.to_dot())
    assert plain.count("\nnode ") == len(plan.nodes)
    assert plain.count("\nedge ") == sum(len(node.successors) for node in plan.nodes.values())


def test_quotes_and_backslashes_in_names_stay_names():
    nodes = {"n0": Node("action", NASTY, {"o": NASTY}, next="n1"), "n1": Node("goal")}
    plain = drawn(Plan(NASTY, {}, {}, "n0", nodes).to_dot())
    assert plain.count("\nnode ") == 2 and "quoted" in plain


def test_long_names_are_cut(plan):
    long = replace(plan.nodes["n0"], action="a" * 500)
    assert "a" * 61 not in replace(plan, nodes={**plan.nodes, "n0": long}).to_dot()


def test_a_plan_with_a_cycle_is_drawn_too(plan):
    cyclic = replace(plan, nodes={**plan.nodes, "n1": replace(plan.nodes["n1"], next="n0")})
    assert cyclic.to_dot().count("[shape=") == len(plan.nodes)
