"""States of knowledge made one: what they all know, nothing more; and plans for which that is too little."""

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.verify import verify_plan
from kabo.verify.knowledge.replay import run as replays
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.merging import meet, more_never_hurts
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError, MutableKnowledge
from kabo.verify.knowledge.replay.states import Knowledge
from kabo.verify.structure import check_structure
from tests.support.small_problems import COLOUR, problem
from tests.verify.hand_made import GOAL, do, look, plan_of, problem_of

OBJECTS = dict.fromkeys("abcd", "thing")
PROBLEM = problem(objects=OBJECTS, functions=(COLOUR,))
claims = st.one_of(
    st.tuples(st.sampled_from([("p", (name,)) for name in OBJECTS]), st.booleans(), st.just(True)),
    st.tuples(st.just(("colour", ())), st.sampled_from("uvw"), st.booleans()),
)
members = st.one_of(
    st.tuples(st.sampled_from([("p", (name,)) for name in OBJECTS]), st.booleans(), st.just(True)),
    st.tuples(st.just(("colour", ())), st.sampled_from("uvw"), st.just(True)),
)
entries = st.frozensets(members, min_size=3, max_size=4).filter(lambda e: len({c[:1] for c in e}) == len(e))
facts = st.lists(claims, max_size=2)


def learned(state, found):
    """What is known once these are found out; None if they cannot be."""
    draft = MutableKnowledge(PROBLEM, state)
    try:
        for claim in found:
            draft.learn(claim)
            draft.close()
    except ContradictionError:
        return None
    return draft.finished()


@given(
    exclusive=st.lists(entries, max_size=2),
    some=st.lists(entries, min_size=1, max_size=4),
    ways=st.tuples(facts, facts),
    later=st.lists(claims, min_size=1, max_size=3),
)
def test_what_one_state_for_two_concludes_both_conclude(exclusive, some, ways, later):
    start = Knowledge({}, exclusive=frozenset(exclusive), some=frozenset(some))
    one, other = (learned(start, found) for found in ways)
    if one is None or other is None:
        return
    both = meet(one, other, start, PROBLEM)
    after = learned(both, later)
    for state in (one, other):
        fuller = learned(state, later)
        if fuller is None:
            continue
        event(f"concluded: {min(len(fuller.known) - len(state.known), 4)}")
        assert after is not None
        assert after.known.items() <= fuller.known.items()


DOMAIN = """types: [thing]
predicates: {a: [], b: [], t: [], s: [], done: []}
actions:
  ask_a: {sense: a}
  ask_b: {sense: b}
  ask_t: {sense: t}
  go: {preconditions: [K(s)], effects: ["add(Kf, done)"]}
  give_up: {preconditions: ["K(t) or (K(a) and K(b))"], effects: ["add(Kf, done)"]}
"""
PROBLEM_TEXT = """domain: domain.yaml
initial: ["add(Kor, a, t, s)", "add(Kor, b, t, s)", "add(Kf, not done)"]
goal: [K(done)]
"""


def asking(last):
    """Two ways to know that s holds once t does not: a does not hold, or b does not."""
    rest = look("ask_t", "t", {"false": do("go", GOAL), "true": do(last, GOAL)})
    return look(
        "ask_a", "a", {"false": rest, "true": look("ask_b", "b", {"false": rest, "true": do("give_up", GOAL)})}
    )


def test_states_with_different_reasons_are_looked_at_one_by_one_where_they_must(tmp_path, monkeypatch):
    given_ = problem_of(tmp_path, DOMAIN, PROBLEM_TEXT)
    plan = plan_of(given_, asking("give_up"))
    assert verify_plan(given_, plan).ok
    interpreter = Interpreter(given_)
    run = replays._ReplayRun(plan, check_structure(plan)[0], interpreter, interpreter.initial())
    assert run.at_once() is not None
    monkeypatch.setattr(replays, "SEPARATED_STEPS", ())
    assert run.at_once() is None, "what both know is not enough"
    assert verify_plan(given_, plan).ok


def test_what_is_wrong_in_one_state_is_found(tmp_path):
    given_ = problem_of(tmp_path, DOMAIN, PROBLEM_TEXT)
    report = verify_plan(given_, plan_of(given_, asking("go")))
    assert any('precondition 1 of "go" does not hold' in str(finding) for finding in report.findings)


@pytest.mark.parametrize(
    ("action", "helps"),
    [
        ("{preconditions: [K(s)], effects: ['add(Kf, done)', 'del(Kf, a)', 'add(Kw, b)']}", True),
        ("{preconditions: [not K(s)], effects: ['add(Kf, done)']}", False),
        ("{preconditions: [K(s) xor K(t)], effects: ['add(Kf, done)']}", False),
        ("{effects: ['K(s) => add(Kf, done)']}", False),
        ("{effects: ['when s then done']}", False),
        ("{effects: ['add(Kor, a, b)']}", False),
    ],
)
def test_more_knowledge_may_hurt_where_conditions_or_effects_depend_on_not_knowing(tmp_path, action, helps):
    assert more_never_hurts(problem_of(tmp_path, DOMAIN + f"  other: {action}\n", PROBLEM_TEXT)) is helps
