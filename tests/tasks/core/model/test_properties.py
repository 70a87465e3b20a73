from typing import Any, NamedTuple

import pytest

from kabo.tasks.core import (
    INTERFACE,
    PARENT,
    InitialisationError,
    Interface,
    Parent,
    Propagator,
    Property,
    Result,
    Serial,
    Task,
    UndeclaredProperty,
    UndefinedProperty,
    Wrapper,
    backward,
    connector,
    forward,
    generator,
    wrapper,
)


class Step(Propagator):
    PROPERTIES = {"length": Property(float), "times": Property(int, 1)}

    def forward(self, scene, properties, seed):
        return Result(
            scene + properties["length"] * properties["times"], properties={"went": properties["length"]}
        )


class LongStep(Step):
    PROPERTIES = {"times": Property(int, 10)}


@generator(at=0.0)
def begin(scene, properties, seed):
    return Result(properties["at"])


def test_a_property_without_a_value_has_its_default_and_subclasses_may_change_it():
    assert Step("s", length=2.0).properties.value("times") == 1
    assert LongStep("s", length=2.0).properties.value("times") == 10


def test_setting_an_undeclared_property_says_what_was_meant():
    with pytest.raises(UndeclaredProperty, match="'lenght', did you mean 'length'"):
        Step("s", lenght=1.0)


def test_a_value_of_another_type_is_refused_and_whole_numbers_are_numbers():
    with pytest.raises(TypeError, match="'length' of stage 's' is float, not 'far'"):
        Step("s", length="far")
    assert Step("s", length=2).properties.value("length") == 2
    with pytest.raises(TypeError, match="is int, not True"):
        Step("s", length=1.0, times=True)


def test_a_declared_property_without_a_value_is_undefined_and_an_unknown_one_undeclared():
    step = Step("s")
    with pytest.raises(UndefinedProperty, match="'length' of stage 's' is declared but undefined"):
        step.properties.value("length")
    with pytest.raises(UndeclaredProperty, match="declares no 'width'"):
        step.properties.value("width")


def test_parents_are_searched_upwards_and_the_error_names_the_whole_way():
    step = Step("s", length=PARENT)
    Task("t", Serial("outer", Serial("inner", step)), length=3.0)
    assert step.properties.value("length") == 3.0
    lost = Step("s", length=Parent("stride"))
    Task("t", Serial("outer", lost))
    with pytest.raises(
        UndeclaredProperty, match=r"no ancestor declares 'stride', wanted by 'length'.*searched: t > outer"
    ):
        lost.properties.value("length")


def test_an_undefined_property_of_a_parent_says_who_inherits_it():
    step = Step("s", length=PARENT)
    task = Task("t", step)
    task.properties.declare("length", float)
    with pytest.raises(
        UndefinedProperty, match="stage 't' is declared but undefined, inherited by 'length' of 's'"
    ):
        step.properties.value("length")


def test_the_nearest_ancestor_wins_and_what_is_set_by_hand_wins_over_both():
    step, other = Step("s", length=PARENT), Step("o", length=7.0)
    Task("t", Serial("inner", step, other, length=1.0), length=2.0)
    assert step.properties.value("length") == 1.0
    assert other.properties.value("length") == 7.0


def test_references_work_inside_lists_and_mappings_and_through_functions():
    inner = Serial("inner", pairs=[[Parent("hand"), "cup"]], keep={"object": PARENT})
    inner.properties.set("half", Parent("length", through=lambda value: value / 2))
    Task("t", inner, hand="left", object="cup", length=3.0)
    assert inner.properties.value("pairs") == [["left", "cup"]]
    assert inner.properties.value("keep") == {"object": "cup"}
    assert inner.properties.value("half") == 1.5


def test_interface_properties_travel_with_the_states_and_are_read_for_every_job():
    again = Step("again", length=Interface("went"))
    task = Task("t", begin("b", at=1.0), Step("first", length=4.0), again)
    (solution,) = task.plan()
    assert solution.end.scene == 9.0
    assert solution["first"].properties == {"went": 4.0}


def test_an_interface_property_that_is_not_there_fails_the_job_and_not_the_task():
    task = Task("t", begin("b"), Step("first", length=INTERFACE))
    assert task.plan() == []
    assert task.statistics["first"].failures == {"property": 1}
    assert "the interface state has no 'length'" in task.explain().examples[0].comment


def test_functions_become_stages_with_the_properties_that_they_declare():
    @forward(step=1.0, name_of=str)
    def nudge(scene, properties, seed):
        """Moves on."""
        yield Result(scene + properties["step"])

    assert nudge.__doc__ == "Moves on."
    with pytest.raises(TypeError):
        nudge("n", step="far")
    (solution,) = Task("t", begin("b"), nudge("n", step=2.5, name_of="x")).plan()
    assert solution.end.scene == 2.5


class Place(NamedTuple):
    x: float
    y: float


def test_named_tuples_stay_what_they_are_with_and_without_references_inside():
    task = Task("t", inner := Serial("s", at=Place(1.0, 2.0), there=Place(Parent("left"), 3.0)), left=7.0)
    assert task.find("s").properties.value("at") == Place(1.0, 2.0)
    assert inner.properties.value("there") == Place(7.0, 3.0)
    assert isinstance(inner.properties.value("there"), Place)


def test_one_of_several_types_may_be_anything():
    assert Property((str, Any)).accepts(3) and Property((str, Any)).accepts(True)


def test_what_a_wrapper_declares_must_be_given_though_it_takes_any_property():
    @wrapper(limit=float)
    def below(solution, properties, seed):
        return Result(cost=properties["limit"])

    with pytest.raises(InitialisationError, match="'limit' of stage 'w' is declared but undefined"):
        Task("t", below("w", begin("b"), note="anything")).plan()
    assert Task("t", below("w", begin("b"), limit=2.0)).plan()[0].cost == 2.0


def test_states_before_a_wrapper_have_the_properties_of_the_child_and_not_those_of_its_end():
    @backward()
    def earlier(scene, properties, seed):
        return Result(scene - 1, properties={"went": 3.0})

    @backward(went=Interface())
    def earlier_still(scene, properties, seed):
        return Result(scene - properties["went"])

    task = Task("t", earlier_still("e"), Wrapper("w", Serial("s", earlier("b"), begin("g", at=10.0))))
    assert [s.start.scene for s in task.plan()] == [6.0]


def test_wrappers_of_connectors_read_the_properties_of_both_states():
    @generator(tag="", value="")
    def tagged(scene, properties, seed):
        return Result(0, properties={properties["tag"]: properties["value"]})

    @connector()
    def join(start, end, properties, seed):
        return Result()

    @wrapper(left=Interface(), right=Interface())
    def both(solution, properties, seed):
        return Result(comment=properties["left"] + properties["right"])

    ends = tagged("a", tag="left", value="l"), tagged("b", tag="right", value="r")
    (solution,) = Task("t", ends[0], both("w", join("j")), ends[1]).plan()
    assert solution["w"].comment == "lr"


def test_the_property_of_the_interface_that_a_value_comes_from_is_known_by_its_name():
    own, named = Step("s", length=INTERFACE), Step("s", length=Interface("far"))
    through, given = Step("s", length=Interface("far", through=lambda value: value)), Step("s", length=1.0)
    inherited = Step("s", length=Parent("stride"))
    Task("t", Serial("outer", inherited, stride=Interface("far")))
    found = [step.properties.interface_name("length") for step in (own, named, through, given, inherited)]
    assert found == ["length", "far", None, None, "far"]
