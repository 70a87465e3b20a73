"""Classical problems as PDDL, as the benchmark gives them to planners of others."""

import pytest

import kabo
from benchmarks.knowledge_pddl import NotClassicalError, to_pddl
from tests.domains.families import generated
from tests.domains.scenes import DOMAINS


def test_a_function_becomes_a_predicate_and_its_old_value_a_parameter():
    domain, problem = to_pddl(kabo.load_problem(DOMAINS / "stacked" / "n2.yaml"))
    assert ":parameters (?r - a_robot ?this - a_block ?other - a_object ?o - a_object)" in domain
    assert "(one_below ?this ?o))" in domain
    assert (
        ":effect (and (highest ?o) (not (highest ?other)) (not (one_below ?this ?o)) (one_below ?this ?other))"
        in (domain)
    )
    assert "(one_below o2 stack_1) (one_below o1 stack_2)" in problem
    assert "(:goal (and (one_below o1 stack_1) (one_below o2 o1)))" in problem
    assert problem.count("(different ") == 6 * 5


@pytest.mark.parametrize(
    ("family", "said"),
    [("btcs", "senses"), ("bomb_in_the_toilet", "initial knowledge"), ("asking_bartender", "senses")],
)
def test_what_needs_knowledge_is_refused(tmp_path, family, said):
    with pytest.raises(NotClassicalError, match=said):
        to_pddl(generated(tmp_path, family, n=3))
