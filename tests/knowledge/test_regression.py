"""The law of regression: what a step needs is enough [explanation-based generalisation].

Any state that can be reached and agrees with another on what a step needs there goes through the step to a state
that agrees on what was needed after it. Checked between all pairs of reachable states of random problems with
entries, rules, world effects, conjunctions and run-time variables.
"""

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.knowledge.entries import Entry
from kabo.knowledge.queries import bits_of, union
from kabo.language import load_problem
from tests.conftest import PROPERTY_SCALE
from tests.knowledge.asking import branching_on, state_after
from tests.support.random_knowledge import random_problem
from tests.support.small_problems import COLOUR, action, add, app, atom, cmp, know, lit, no, problem, when

SEEDS = range(max(20, round(400 * PROPERTY_SCALE)))
STATES = 40


@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("problems")
    return [task for seed in SEEDS for task in grounded(folder, seed)]


def grounded(folder, seed):
    """The task of a random problem, unless the problem contradicts itself."""
    domain, text = random_problem(seed)
    (folder / "domain.yaml").write_text(domain)
    (folder / "problem.yaml").write_text(text)
    try:
        return [ground(load_problem(folder / "problem.yaml"))]
    except InputError:
        return []


def reachable(task):
    """Some states that can be reached, nearest first."""
    states = [task.initial]
    for state in states:  # grows while it is walked
        branching = task.open_branching(state)
        after = [] if branching is None else [child for _, child in branching.outcomes(state)]
        after += [one.after(state) for one in task.actions if one.applicable(state)]
        states += [child for child in dict.fromkeys(after) if child is not None and child not in states]
        if len(states) > STATES:
            return states[:STATES]
    return states


def asked_bits(task):
    """The bits of facts; those of entries may be resolved already where more is known."""
    entries = union(one.mask for one in task.closure.propagators if isinstance(one, Entry))
    return [bit for bit in bits_of((1 << task.width) - 1) if not bit & entries]


def test_what_an_action_needs_is_enough(tasks):
    pairs = 0
    for task in tasks:
        states, asked = reachable(task), [0, *asked_bits(task)]
        for state in states[:10]:
            for act in task.actions:
                after = act.after(state) if act.applicable(state) else None
                for bit in asked if after is not None else ():
                    needs = act.needs(state, bit)
                    for other in states:
                        if not (other ^ state) & needs and other != state:
                            pairs += 1
                            assert act.applicable(other), str(act)
                            reached = act.after(other)
                            assert reached is None or not (reached ^ after) & bit, str(act)
    assert pairs > 10 * len(tasks)


def test_what_an_outcome_needs_is_enough(tasks):
    pairs = 0
    for task in tasks:
        states, asked = reachable(task), asked_bits(task)
        for state in states[:10]:
            branching = task.open_branching(state)
            for outcome, after in branching.outcomes(state) if branching is not None else ():
                for bit in asked:
                    needs = branching.entry | branching.needs(state, outcome, bit)
                    for other in states:
                        if not (other ^ state) & needs and other != state:
                            reached = dict(branching.outcomes(other)).get(outcome)
                            if reached is not None:
                                pairs += 1
                                assert not (reached ^ after) & bit, f"{branching.fact}: {outcome}"
    assert pairs > 10 * len(tasks)


def test_what_excludes_outcomes_excludes_them_elsewhere(tasks):
    excluded = 0
    for task in tasks:
        states = reachable(task)
        for state in states:
            branching = task.open_branching(state)
            if branching is None:
                continue
            reasons, names = branching.excluded(state), set(dict(branching.outcomes(state)))
            excluded += len(names) < len(branching.choices)
            for other in states:
                if not (other ^ state) & (reasons | branching.entry):
                    assert set(dict(branching.outcomes(other))) <= names, branching.fact
    assert excluded > len(tasks) // 8


def test_what_an_entry_needs_as_a_whole_is_enough_to_leave_it_the_same(tasks):
    """All bits of an entry together: what it needs includes that it is not settled, and which members are left."""
    pairs = 0
    for task in tasks:
        states = reachable(task)
        entries = [one for one in task.closure.propagators if isinstance(one, Entry) and one.active]
        for state in states[:10] if entries else ():
            for act in task.actions:
                after = act.after(state) if act.applicable(state) else None
                for entry in [one for one in entries if after is not None and after & one.active]:
                    needs = act.needs(state, entry.mask)
                    for other in states:
                        if not (other ^ state) & needs and other != state:
                            reached = act.after(other)
                            pairs += 1
                            assert reached is None or not (reached ^ after) & entry.mask, f"{act}: {entry}"
    assert pairs > len(tasks)


# ------------------------------------------------------------------------------------------ in words, one by one
def test_that_nothing_contradicts_itself_is_a_need_too():
    """At least one of r, p(x) holds, says the action: it cannot be done where both are known to be false."""
    mend = action("mend", effects=[add(lit("p", "x"))])
    say = action("say", effects=[add(lit("r"), lit("p", "x"), to="Kor"), add(lit("q"))])
    task = ground(problem(actions=[mend, say], initial=[add(no("r"), no("p", "x")), add(lit("q"), to="Kw")]))
    _, act = task.actions
    bits = {group.text: group for group in task.groups}
    mended = state_after(task, "mend()")
    assert act.after(task.initial) is None and act.after(mended) is not None
    assert (mended ^ task.initial) & act.needs(mended, bits["q"].true), "that p(x) is not known to be false"


def test_an_excluded_value_is_why_its_outcome_is_impossible():
    exclude = action("exclude", effects=[add(cmp(app("colour"), "!=", "v"))])
    task = ground(problem(actions=[exclude, action("look", sense=[app("colour")])], functions=[COLOUR]))
    excluded, open_ = state_after(task, "exclude()", "look()"), state_after(task, "look()")
    split = branching_on(task, "colour")
    assert split.excluded(excluded) == excluded & ~open_
    assert split.excluded(open_) == 0


def test_an_inference_needs_its_reasons():
    """r follows from q being false, by the entry; so r after the outcome needs the entry, and nothing else."""
    look = action("look", sense=[atom("q")])
    task = ground(problem(actions=[look], initial=[add(lit("q"), lit("r"), lit("p", "x"), to="Kx")]))
    state = state_after(task, "look()")
    known = {group.text: group for group in task.groups}
    branching = branching_on(task, "q")
    assert branching.needs(state, "true", known["r"].false) == 0, "the entry is permanent"
    assert branching.needs(state, "true", known["q"].true) == 0


def test_a_conclusion_of_a_rule_needs_what_the_condition_reads():
    make = action("make", effects=[add(lit("q"))])
    rule = when(know(lit("p", "x")), add(lit("r")))
    see = action("see", sense=[atom("p", "x")])
    task = ground(problem(actions=[make, see], update_rules=[rule]))
    state = state_after(task, "see()", "p(x): true")
    known = {group.text: group for group in task.groups}
    needs = task.actions[0].needs(state, known["r"].true)
    assert needs & (known["r"].true | known["p(x)"].true)


def test_that_nothing_follows_needs_everything_from_which_it_could():
    look = action("look", sense=[atom("q")])
    task = ground(
        problem(actions=[look, action("see", sense=[atom("r")])], initial=[add(no("q"), lit("r"), to="Kor")])
    )
    known = {group.text: group for group in task.groups}
    state = state_after(task, "look()")
    needs = branching_on(task, "q").needs(state, "false", known["r"].true)
    assert needs & known["r"].true
    assert needs & known["r"].false
