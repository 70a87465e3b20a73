from dataclasses import replace

import pytest

from kabo.errors import InputError
from kabo.plan import describe, load_plan, plan_hash


def test_a_plan_says_in_one_line_how_large_it_is(plan):
    assert repr(plan) == "<Plan vault: 6 nodes, 3 outcomes, 4 actions at most>"


def test_a_plan_with_a_cycle_has_a_line_too(plan):
    cyclic = replace(plan, nodes={**plan.nodes, "n1": replace(plan.nodes["n1"], next="n0")})
    assert repr(cyclic) == "<Plan vault: 6 nodes, with a cycle>"
    with pytest.raises(ValueError, match="cycle"):
        _ = cyclic.statistics


def test_print_writes_the_tree_that_kabo_solve_prints(plan, capsys):
    plan.print()
    assert capsys.readouterr().out == describe(plan)


def test_a_plan_that_was_saved_is_loaded_again_from_the_name_of_its_file(plan, tmp_path):
    file = tmp_path / "plan.json"
    assert plan.save(str(file)) == plan_hash(plan)
    assert load_plan(str(file)) == load_plan(file) == plan


def test_a_file_that_is_no_plan_is_refused_with_its_name(tmp_path):
    file = tmp_path / "plan.json"
    file.write_text("{}")
    with pytest.raises(InputError, match=r"plan\.json"):
        load_plan(str(file))
