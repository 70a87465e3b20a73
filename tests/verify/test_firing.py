"""Entries that nothing can set off any more may be forgotten: what is known later is the same without them."""

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.verify.knowledge.replay.draft import ContradictionError, Draft
from kabo.verify.knowledge.replay.firing import Firing
from kabo.verify.knowledge.replay.states import Knowledge
from tests.small_problems import COLOUR, problem

OBJECTS = dict.fromkeys("abcdefgh", "thing")
PROBLEM = problem(objects=OBJECTS, functions=(COLOUR,))
ATOMS = [("p", (name,)) for name in OBJECTS]
TERM = ("colour", ())


def p(name: str, value: bool = True):
    return ("p", (name,)), value, True


def colour(value: str):
    return TERM, value, True


claims = st.one_of(
    st.tuples(st.sampled_from(ATOMS), st.booleans(), st.just(True)),
    st.sampled_from([colour(value) for value in "uvw"]),
)
entries = st.frozensets(claims, min_size=2, max_size=4).filter(lambda e: len({repr(c[:2]) for c in e}) == len(e))


def fired(exclusive, some, touched):
    return Firing().may_matter(frozenset(exclusive), frozenset(some), (touched.__contains__, 0), (bool, 1))


def test_what_is_touched_sets_off_a_chain_of_entries_and_nothing_else():
    near, next_, far = frozenset([p("a"), p("b")]), frozenset([p("b", False), p("c")]), frozenset([p("d"), p("e")])
    assert fired([], [near, next_, far], {("p", ("a",))}) == (frozenset(), frozenset([near, next_]))


def test_an_entry_waits_for_all_of_its_members_but_one():
    three = frozenset([p("a"), p("b"), p("c")])
    assert fired([], [three], {("p", ("a",))}) == (frozenset(), frozenset())
    assert fired([], [three], {("p", ("a",)), ("p", ("b",))}) == (frozenset(), frozenset([three]))
    assert fired([three], [], {("p", ("a",))}) == (frozenset([three]), frozenset())


def test_claims_go_one_way():
    """From "a or b", b follows if a is false; that c is false follows from "not b or not c" only then."""
    first, second, third = (
        frozenset([p("a"), p("b")]),
        frozenset([p("b", False), p("c", False)]),
        frozenset([p("b"), p("d")]),
    )
    found = fired([], [first, second, third], {("p", ("a",))})[1]
    assert {first, second} <= found
    assert third not in found


def learn(entries_of, facts):
    """What is known after the facts one after the other; None if they contradict the entries."""
    exclusive, some = entries_of
    draft = Draft(PROBLEM, Knowledge({}, exclusive=frozenset(exclusive), some=frozenset(some)))
    try:
        for fact in facts:
            draft.learn(fact)
            draft.close()
    except ContradictionError:
        return None
    return draft.known, draft.excluded


@given(st.frozensets(entries, max_size=5), st.frozensets(entries, max_size=5), st.lists(claims, max_size=4))
def test_nothing_else_ever_concludes_anything(exclusive, some, facts):
    touched = {claim[0] for claim in facts}
    kept = fired(exclusive, some, touched)
    event(f"forgotten: {len(exclusive) + len(some) - len(kept[0]) - len(kept[1])}")
    assert learn(kept, facts) == learn((exclusive, some), facts)
