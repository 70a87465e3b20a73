"""The ledger: refusals hold where what they rest on is the same, and only they tell search nodes apart."""

from kabo import tuning
from kabo.geometry_server import Refusal, Success
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.refusals import RefusalTable
from tests.planner.scripted import ScriptedServer, at, moved

PICK = GroundCall("pick", ("r", "a"))
PLACE = GroundCall("place", ("r", "a"))
OTHER = GroundCall("pick", ("r", "b"))


def ledger() -> RefusalTable:
    server = ScriptedServer(lambda *_: moved(), {"r": (0.0,)}, {"a": at(0.0), "b": at(1.0)})
    return RefusalTable(server)  # type: ignore[arg-type]


def refused(*reads: str, proof: bool = False) -> Refusal:
    return Refusal("collision", "in the way", frozenset(reads), proof=proof)


def test_until_something_is_refused_traces_do_not_tell_nodes_apart() -> None:
    book = ledger()
    after = book.after(PICK, 0, book.start)
    assert after != book.start
    assert book.key(after) == book.key(book.start)
    assert book.options(PLACE, after) == [(0, book.after(PLACE, 0, after))]


def test_a_refusal_holds_only_where_what_it_read_is_the_same() -> None:
    book = ledger()
    book.record_refusal(PICK, 0, refused("a"), [book.start])
    assert not book.options(PICK, book.start)
    elsewhere = book.after(PLACE, 0, book.start)
    assert book.options(PICK, elsewhere), "the object has been moved"
    other_moved = book.after(OTHER, 0, book.start)
    assert not book.options(PICK, other_moved), "what it read is as before"
    assert book.key(elsewhere) != book.key(book.start)


def test_a_refusal_that_read_nothing_holds_everywhere() -> None:
    book = ledger()
    book.record_refusal(PICK, 0, refused(), [book.start])
    assert not book.options(PICK, book.after(PLACE, 0, book.start))
    assert book.key(book.after(PLACE, 0, book.start)) == book.key(book.start)


def test_another_attempt_is_offered_only_where_the_first_led_to_a_refusal() -> None:
    book = ledger()
    assert [attempt for attempt, _ in book.options(PICK, book.start)] == [0]
    book.record_refusal(PLACE, 0, refused("a"), [book.after(PICK, 0, book.start)])
    assert [attempt for attempt, _ in book.options(PICK, book.start)] == [0, 1]


def test_attempts_end_where_the_samples_ended() -> None:
    book = ledger()
    book.record_refusal(PLACE, 0, refused("a"), [book.after(PICK, 0, book.start)])
    book.record_refusal(PICK, 1, refused("a"), [book.start])
    assert [attempt for attempt, _ in book.options(PICK, book.start)] == [0]


def test_attempts_are_bounded_and_the_bound_grows_with_the_effort() -> None:
    book = ledger()
    for attempt in range(20):
        book.record_refusal(PLACE, 0, refused("a"), [book.after(PICK, attempt, book.start)])
    assert len(book.options(PICK, book.start)) == tuning.ATTEMPTS_PER_EFFORT
    assert book.try_harder()
    assert not book.refusals


def test_trying_harder_keeps_proofs_and_forgets_the_rest() -> None:
    book = ledger()
    book.record_refusal(PICK, 0, refused("a", proof=True), [book.start])
    book.record_refusal(OTHER, 0, refused("b"), [book.start])
    assert not book.proved()
    book.try_harder()
    assert book.proved()
    assert not book.options(PICK, book.start)
    assert book.options(OTHER, book.start)


def test_equal_keys_have_equal_options_even_before_the_refused_call() -> None:
    """The law of `Geometry.key`: where lineages lead to a refusal, the nodes before it are told apart."""
    book = ledger()
    twice = book.after(PICK, 0, book.after(PLACE, 0, book.start))
    book.record_refusal(PLACE, 0, refused("a"), [twice])
    once = book.after(PLACE, 0, book.start)
    assert len(book.options(PICK, once)) == 2
    assert len(book.options(PICK, book.start)) == 1
    assert book.key(once) != book.key(book.start)


def test_what_a_call_is_found_to_move_besides_has_a_lineage_of_its_own_from_then_on() -> None:
    book = ledger()
    assert book.after(PICK, 0, book.start)[2] == book.start[2]
    book.record_success(PICK, 0, book.start, moved(r=(1.0,), a=at(2.0), b=at(2.5)))
    assert book.after(PICK, 0, book.start)[2] != book.start[2]


def test_a_call_that_is_refused_where_it_was_refused_before_is_refused_at_least_there() -> None:
    """Or the same plan would come again and again."""
    book = ledger()
    elsewhere = book.after(OTHER, 0, book.start)
    book.record_refusal(PICK, 0, refused("a"), [book.start])
    book.record_refusal(PICK, 0, refused("a"), [elsewhere])
    patterns = [row.pattern for row in book.refusals[PICK]]
    assert patterns[1] == frozenset(enumerate(elsewhere))


def test_what_a_fifth_of_the_samples_ran_into_is_suspected_wherever_it_stays() -> None:
    book = ledger()
    blocked = Refusal("collision", "", frozenset({"a", "b"}), ((("r.hand", "b"), 4), (("r.hand", "wall"), 6)))
    book.record_refusal(PLACE, 0, blocked, [book.after(PICK, 0, book.start)])
    assert book.learnt().suspicions == {PLACE: (frozenset({(2, 0)}),)}


def test_what_is_out_of_reach_is_suspected_everywhere_and_a_proof_suspects_nothing() -> None:
    book = ledger()
    book.record_refusal(PLACE, 0, Refusal("out_of_reach", "", frozenset({"a"})), [book.start])
    book.record_refusal(PICK, 0, Refusal("out_of_reach", "", frozenset({"a"}), proof=True), [book.start])
    assert book.learnt().suspicions == {PLACE: (frozenset(),)}


def test_there_is_no_proof_where_what_was_sampled_was_refused() -> None:
    book = ledger()
    book.record_refusal(PLACE, 0, refused("a", proof=True), [book.start])
    assert book.proved()
    book.record_refusal(PLACE, 0, refused("a", proof=True), [book.after(PICK, 0, book.start)])
    assert not book.proved()


def test_equal_values_have_one_lineage_whatever_made_them() -> None:
    book = ledger()
    once = book.record_success(PICK, 0, book.start, moved(r=(1.0,), a=at(3.0)))
    assert book.record_success(PLACE, 0, once, moved(r=(1.0,), a=at(3.0))) == once
    assert book.record_success(PLACE, 0, once, moved(r=(0.0,), a=at(0.0))) == book.start
    assert book.after(PLACE, 0, once) == book.start, "and so the search expects it"


def test_a_lineage_that_has_two_values_depends_on_what_was_in_the_way() -> None:
    """The first answer is another one where something is in the way of the sample that was the first before."""
    book = ledger()
    elsewhere = book.record_success(OTHER, 0, book.start, moved(r=(0.0,), b=at(2.0)))
    first = book.record_success(PICK, 0, book.start, moved(r=(1.0,), a=at(3.0)))
    second = book.record_success(PICK, 0, elsewhere, Success((), {"r": (1.0,), "a": at(4.0)}, frozenset({"b"})))
    assert first[1] != second[1]
    assert book.record_success(PICK, 0, book.start, moved(r=(1.0,), a=at(3.0))) == first
    assert book.after(PICK, 0, book.start) == first
    assert book.after(PICK, 0, elsewhere) == second


def test_after_two_rounds_in_vain_nothing_is_taken_to_be_independent() -> None:
    book = ledger()
    elsewhere = book.after(OTHER, 0, book.start)
    assert book.after(PICK, 0, elsewhere)[1] == book.after(PICK, 0, book.start)[1]
    assert book.try_harder() and book.try_harder()
    assert book.after(PICK, 0, elsewhere)[1] != book.after(PICK, 0, book.start)[1]
