from pathlib import Path
from typing import get_type_hints

import kabo
from kabo.plan import schema
from kabo.planner.result import Result, result_to_json
from kabo.planner.statistics import PYTHON_ONLY, Statistics, completed

PARCEL = Path(__file__).parents[1] / "acceptance" / "parcels" / "one.yaml"


def test_the_type_of_statistics_has_the_keys_of_the_schema_and_those_of_python_alone():
    figures = next(
        each for each in schema("kabo-result-1")["properties"]["statistics"]["oneOf"] if "properties" in each
    )
    assert {*get_type_hints(Statistics)} == {*figures["properties"]} | {*PYTHON_ONLY}


def test_every_figure_of_the_type_is_explained_in_the_reference():
    page = (Path(__file__).parents[2] / "docs" / "reference" / "plans.md").read_text()
    assert not [name for name in get_type_hints(Statistics) if f"`{name}`" not in page]


def test_a_result_has_every_figure_that_its_type_requires():
    result = kabo.solve(kabo.load_problem(PARCEL))
    assert result.statistics.keys() >= Statistics.__required_keys__
    assert (
        result.statistics["expanded"] > 0
        and result.statistics["plan_actions"] == result.plan.statistics.plan_actions
    )


def test_figures_that_nobody_counted_are_zero_and_those_of_a_missing_plan_are_none():
    result = Result("exhausted", None)
    assert result.statistics == completed({})
    assert result.statistics["collision_checks"] == 0 and result.statistics["plan_nodes"] is None
    assert result_to_json(result)["statistics"].keys() == result.statistics.keys() - {*PYTHON_ONLY}
