"""The table of options, and every door that is made from it."""

import inspect
from types import NoneType
from typing import get_args, get_type_hints

import msgspec
import pytest

import kabo
from kabo.cli import explain as explain_command
from kabo.explain.geometry import MAX_SAMPLES
from kabo.options import OPTIONS, Options, SolveOptions
from kabo.plan import schema
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.service.messages import OptionsMessage


def test_type_checkers_are_told_of_the_same_options_with_the_same_types():
    decided, said = get_type_hints(Options), get_type_hints(SolveOptions)
    assert said.keys() == decided.keys() == OPTIONS.keys()
    for name, hint in said.items():
        without_none = (
            {kind for kind in get_args(hint) if kind is not NoneType} if NoneType in get_args(hint) else {hint}
        )
        assert decided[name] in without_none or set(get_args(decided[name])) == {*without_none, NoneType}, name


def test_the_first_who_says_an_option_decides_it():
    assert Options.of({"seed": 3, "search": None}, {"seed": 4, "search": "greedy"}, {"timeout": 1.0}) == Options(
        seed=3, search="greedy", timeout=1.0
    )
    assert Options.of({"certificate": False}).certificate is False


def test_an_option_that_is_none_is_refused_by_name(parcels_problem):
    with pytest.raises(TypeError, match=r"solve\(\) got an unexpected keyword argument 'sead'"):
        kabo.solve(parcels_problem, sead=3)


@pytest.fixture
def parcels_problem():
    """A small problem."""
    return kabo.load_problem("tests/acceptance/parcels/one.yaml")


def test_the_header_of_a_plan_says_what_the_plan_depends_on():
    first = ["search", "seed", "epsilon", "geometry", "geometry_order", "max_expansions", "max_samples"]
    assert list(Options(epsilon=0.02).written()) == first
    assert list(Options(epsilon=0.02, quality="good", memory=1.0, timeout=2.0).written()) == [*first, "quality"]
    symbolic = Options(epsilon=0.02, geometry="none", geometry_order="eager", quality="good").written()
    assert list(symbolic) == first
    assert (symbolic["epsilon"], symbolic["geometry_order"], symbolic["geometry"]) == (None, None, "none")


def test_the_schema_of_plans_has_the_options_of_the_header():
    properties = schema("kabo-plan-2")["properties"]["options"]["properties"]
    assert properties.keys() == {name for name, option in OPTIONS.items() if option.in_header != "never"}
    for name, form in properties.items():
        option, nulls = OPTIONS[name], {None, "null"} & {*form.get("enum", ()), *listed(form.get("type", ()))}
        assert bool(nulls) is option.null_in_header, name
        assert name == "search" or {*form.get("enum", option.choices)} - {None} == {*option.choices}


def listed(kinds):
    """The types of a schema: one, or several."""
    return [kinds] if isinstance(kinds, str) else kinds


def test_a_request_may_say_every_option_and_says_none_by_itself():
    assert OptionsMessage.__struct_fields__ == tuple(OPTIONS)
    assert msgspec.json.encode(OptionsMessage()) == b"{}"


def test_help_names_every_option():
    assert {*OPTIONS} <= inspect.signature(kabo.solve).parameters.keys()
    assert all(f"{name}: {option.help}" in kabo.solve.__doc__ for name, option in OPTIONS.items())


def test_every_search_that_can_be_named_is_there():
    assert tuple(sorted(ALGORITHMS)) == tuple(sorted(OPTIONS["search"].choices))


def test_the_command_says_how_many_samples_explain_draws():
    assert explain_command.MAX_SAMPLES == MAX_SAMPLES
