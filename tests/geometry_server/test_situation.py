"""Situations: what hangs on what, and which robot carries it."""

import pytest

from kabo.geometry_server import Situation
from kabo.scene import Attachment
from kabo.scene.transforms import transform

TURNED = (0.0, 0.0, 0.6, 0.8)


def hanging(*parents: str) -> tuple[Attachment, ...]:
    return tuple(Attachment(parent, (0.1, 0.2, 0.3), TURNED) for parent in parents)


def situation(**objects: tuple[Attachment, ...]) -> Situation:
    return Situation({"left": ((0.0,),), "right": ((0.0,),)}, objects)


CHAIN = situation(a=hanging("left.tool"), b=hanging("a"), c=hanging("b"), d=hanging("world"), e=hanging("d"))


def test_a_robot_carries_what_hangs_on_what_it_holds():
    assert CHAIN.carried("left") == ("a", "b", "c")
    assert CHAIN.carried("right") == ()


def test_a_group_has_one_root_and_all_that_hangs_on_it():
    assert [CHAIN.root(name) for name in "abcde"] == ["a", "a", "a", "d", "d"]
    assert CHAIN.group("b") == ("a", "b", "c")
    assert CHAIN.group("e") == ("d", "e")


def test_where_something_hangs_on_a_hand_is_told_through_all_that_is_between():
    one = transform((0.1, 0.2, 0.3), TURNED)
    held = CHAIN.held("c")
    assert held.parent == "left.tool"
    assert transform(held.position, held.quaternion) == pytest.approx(one @ one @ one)
    assert CHAIN.held("a") is CHAIN.attachment("a")


def test_what_may_hang_on_a_robot_is_carried_even_if_it_may_stand_as_well():
    open_ = situation(a=hanging("world", "right.tool"), b=hanging("a"))
    assert open_.carried("right") == ("a", "b")


def test_things_that_stand_alone_are_no_group():
    alone = situation(a=hanging("world"), b=hanging("left.tool"))
    assert not alone.nested
    assert alone.group("a") == ("a",)
    assert CHAIN.nested


def test_what_carries_a_thing_is_every_object_below_it_and_whoever_holds_these():
    assert CHAIN.carriers(["c"]) == {"a", "b", "c", "left"}
    assert CHAIN.carriers(["e", "right", "table"]) == {"d", "e"}
