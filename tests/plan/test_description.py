from dataclasses import replace

from kabo.plan import describe, described_validity, plan_statistics


def test_the_tree_shows_branches_indented_and_calls_with_their_arguments(plan):
    text = describe(plan)
    assert text.splitlines()[0] == "n0  look()  senses dark"
    assert "n1    pick(o=cup)  [0.5 s]  [learned along=0.01, force=8, valid at 0.97]" in text
    assert "n2    read(s=vault)  delivers combination(vault), open(vault)" in text
    assert "dial(c=value of combination(vault), n=2)" in text
    assert text.index("false:") < text.index("true:")


def test_a_validity_is_never_shown_as_certain():
    told = {value: described_validity(value) for value in (1.0, 0.9996, 0.9994, 0.97, 0.5, 1e-9)}
    assert list(told.values()) == ["over 0.999", "over 0.999", "0.999", "0.97", "0.5", "1e-09"]


def test_a_shared_node_stands_once_and_is_referred_to(plan):
    node = plan.nodes["n0"]
    shared = replace(plan, nodes={**plan.nodes, "n0": replace(node, branches={"false": "n1", "true": "n2"})})
    text = describe(shared)
    assert text.count("read(s=vault)") == 1 and "-> n2" in text


def test_a_missing_node_is_shown_as_missing(plan):
    broken = replace(plan, nodes={name: node for name, node in plan.nodes.items() if name != "n1"})
    assert "-> n1, which is missing" in describe(broken)


def test_the_figures_of_a_plan(plan):
    figures = plan_statistics(plan)
    assert (figures.plan_actions, figures.plan_nodes, figures.plan_leaves, figures.waypoints) == (4, 6, 3, 2)
