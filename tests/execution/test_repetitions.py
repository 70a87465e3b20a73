"""A run gives up when one thing surprises again and again at the same action, whatever is done in between."""

from kabo.execution.interruptions import Stop
from kabo.execution.repetitions import MOST_ALIKE, Repetitions
from kabo.execution.watching import Surprise
from kabo.plan import Node

GIVE = Node("action", "give", {"r": "left", "o": "rod"}, next="n1")
SAME = Node("action", "give", {"o": "rod", "r": "left"}, next="n7")
TAKE = Node("action", "take", {"r": "left", "o": "rod"}, next="n1")
NO_LIMIT = 1000


def surprised(thing: str = "rod") -> Stop:
    return Stop("it fell", Surprise("displaced", "it fell", thing, 1.0, 0.0))


def test_the_same_thing_at_the_same_action_ends_the_run_whatever_was_done_before() -> None:
    found = Repetitions(NO_LIMIT)
    nodes = [GIVE, SAME] * MOST_ALIKE
    answers = [found.add(surprised(), node, done, on_way=False) for done, node in enumerate(nodes)]
    assert answers[:MOST_ALIKE] == [None] * MOST_ALIKE
    assert "rod has surprised 4 times at give(" in str(answers[MOST_ALIKE])


def test_other_things_and_other_actions_count_apart_and_ways_out_of_a_node_do_not() -> None:
    found = Repetitions(NO_LIMIT)
    for _ in range(MOST_ALIKE):
        for thing, node in (("rod", GIVE), ("cup", GIVE), ("rod", TAKE)):
            assert found.add(surprised(thing), node, 0, on_way=False) is None
            assert found.add(surprised(thing), node, 0, on_way=True) is None


def test_a_surprise_that_is_answered_twice_is_one() -> None:
    """After a way back it is asked again."""
    found, stop = Repetitions(NO_LIMIT), surprised()
    assert [found.add(stop, GIVE, 0, on_way=False) for _ in range(9)] == [None] * 9
    assert not found.is_again()
    found.add(surprised(), GIVE, 0, on_way=False)
    assert found.is_again()


def test_after_the_most_answers_the_run_says_that_it_gives_up() -> None:
    found = Repetitions(2)
    answers = [found.add(surprised(f"body_{k}"), GIVE, k, on_way=False) for k in range(3)]
    assert answers == [None, None, "the run gives up after 2 answers"]
    assert Repetitions(0).add(surprised(), GIVE, 0, on_way=False) == ""
