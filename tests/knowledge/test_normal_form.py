"""States that say the same have one form; states that may have different futures have two."""

import pytest

from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import BitTable
from kabo.knowledge.normal_form import NormalForm

VOCABULARY = BitTable()
P, Q, R = (VOCABULARY.atom(name, ()).claim(True) for name in "pqr")


def entry(exactly, *members):
    return Entry(exactly, members, VOCABULARY.bit(), tuple(VOCABULARY.bit() for _ in members))


SOME_PQ, SOME_PQR, SOME_NOT = entry(False, P, Q), entry(False, P, Q, R), entry(False, P.denied, Q.denied)
ONE_PQ, ONE_NOT, ONE_PQR = entry(True, P, Q), entry(True, P.denied, Q.denied), entry(True, P, Q, R)
FORM = NormalForm([SOME_PQ, SOME_PQR, SOME_NOT, ONE_PQ, ONE_NOT, ONE_PQR], VOCABULARY.width)


def state(*entries, out=0):
    found = out
    for each in entries:
        found |= each.active
    return found


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (state(SOME_PQ, SOME_PQR), state(SOME_PQ)),
        (state(ONE_PQ, SOME_PQ), state(ONE_PQ)),
        (state(ONE_PQ), state(ONE_NOT)),
        (state(SOME_PQ, SOME_NOT), state(ONE_PQ)),
        (state(SOME_PQ, SOME_NOT, SOME_PQR), state(ONE_NOT)),
        (state(SOME_PQR, out=SOME_PQR.outs[2]), state(SOME_PQ)),
        (state(ONE_PQR, SOME_PQR), state(ONE_PQR)),
    ],
)
def test_what_says_the_same_has_one_form(one, other):
    known = P.makes & ~P.holds
    assert one != other and FORM.of(one) == FORM.of(other)
    assert FORM.of(one | known) == FORM.of(other | known) != FORM.of(one)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (state(SOME_PQ), state(SOME_PQR)),
        (state(ONE_PQ), state(SOME_PQ)),
        (state(ONE_PQR), state(SOME_PQR)),
        (state(ONE_PQR, SOME_NOT), state(ONE_PQR)),  # when r changes, only one of them goes
        (state(SOME_PQ), 0),
    ],
)
def test_what_may_come_to_differ_has_two(one, other):
    assert FORM.of(one) != FORM.of(other)


def test_a_form_never_looks_like_a_state():
    assert FORM.of(state(SOME_PQ)) >= 1 << VOCABULARY.width
