"""The contingent search on the thesis' domains and on problems made to be awkward."""

from pathlib import Path

import pytest

from kabo import tuning
from kabo.cli import main
from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.language import load_problem
from kabo.language.problem import Function
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.contingent import _Contingent, find_skeleton
from kabo.planner.search.nodes import Act, SearchSpace
from kabo.planner.search.skeleton import Exhausted, FoundSkeleton, SearchLimits, Unreachable
from kabo.planner.search.weak_plans import Counter
from tests.planner.scripted_geometry import Scripted
from tests.support import oracles_knowledge as oracles
from tests.support.small_problems import (
    COLOUR,
    FUEL,
    action,
    add,
    app,
    atom,
    cmp,
    delete,
    know,
    lit,
    no,
    problem,
    var,
)

DOMAINS = Path(__file__).parents[3] / "domains"


def solved(given, **options):
    found = find_skeleton(ground(given), **options)
    assert isinstance(found, FoundSkeleton), found
    return found


def plan_of(given, **options):
    return list(solved(given, **options).skeleton.nodes())


def names(nodes):
    return [str(node.action) for node in nodes if node.action is not None]


def in_all_worlds(given, root, only=None):
    start = oracles.initial_state(given)
    return [oracles.execute(given, root, world) for world in oracles.worlds(given, start, only)]


# ------------------------------------------------------------------------------------------------------- domains
@pytest.mark.parametrize("n", [1, 2, 6, 10])
def test_force_sensing_takes_5_n_plus_1_nodes_for_all_2_to_the_n_outcomes(n):
    found = solved(load_problem(DOMAINS / "force_sensing" / f"n{n}.yaml"))
    assert len(list(found.skeleton.nodes())) == 5 * n + 1


def test_force_sensing_reaches_the_goal_in_every_world():
    given = load_problem(DOMAINS / "force_sensing" / "n4.yaml")
    assert in_all_worlds(given, solved(given).skeleton.root, {"spillable"}) == [16] * 16


def test_bartender_senses_each_bottle_and_shares_every_continuation():
    given = load_problem(DOMAINS / "bartender" / "four_bottles.yaml")
    nodes = plan_of(given)
    assert len(nodes) <= 13
    assert sum(node.on is not None for node in nodes) == 4
    lengths = in_all_worlds(given, nodes[0], {"empty_bottle"})
    assert len(lengths) == 16 and len(set(lengths)) == 5 and min(lengths) == 4 and max(lengths) == 12


@pytest.mark.parametrize("search", ["breadth-first", "iterative-deepening"])
def test_stacked_takes_the_optimal_2_n_minus_1_actions(search):
    for n in (3, 4, 5):
        nodes = plan_of(load_problem(DOMAINS / "stacked" / f"n{n}.yaml"), search=search)
        assert len(nodes) - 1 == 2 * n - 1


def test_stacked_with_six_blocks_is_searched_breadth_first_without_meeting_a_state_twice():
    found = solved(load_problem(DOMAINS / "stacked" / "n6.yaml"), search="breadth-first")
    assert len(list(found.skeleton.nodes())) - 1 == 11
    assert found.statistics.expanded < 11_000


# -------------------------------------------------------------------------------------------------- the skeleton
TOOLS = [
    action("look", sense=[atom("q")]),
    action("lift", pre=[know(lit("q"))], effects=[add(lit("p", "x"))]),
    action("push", pre=[know(no("q"))], effects=[add(lit("p", "x"))]),
    action("end", pre=[know(lit("p", "x"))], effects=[add(lit("r"))]),
]


def test_equal_continuations_are_one_object():
    nodes = plan_of(problem(actions=TOOLS, goal=[know(lit("r"))]))
    assert names(nodes) == ["look()", "push()", "lift()", "end()"]
    look, push, lift, end, goal = nodes
    assert look.on == "q" and [outcome for outcome, _ in look.outcomes] == ["false", "true"]
    assert look.outcomes[0][1] is push and push.next is end is lift.next
    assert end.next is goal and goal.is_goal


def test_a_value_is_branched_on_once_for_each_value_still_possible():
    ways = [action(f"way_{v}", pre=[know(cmp(app("colour"), "=", v))], effects=[add(lit("r"))]) for v in "uvw"]
    given = problem(
        actions=[action("look", sense=[app("colour")]), *ways],
        goal=[know(lit("r"))],
        functions=[COLOUR],
        initial=[add(cmp(app("colour"), "!=", "v"))],
    )
    nodes = plan_of(given)
    assert [outcome for outcome, _ in nodes[0].outcomes] == ["u", "w"]
    assert names(nodes) == ["look()", "way_u()", "way_w()"]
    assert len(in_all_worlds(given, nodes[0])) == 2 * 16


def test_what_is_sensed_but_not_needed_is_delivered_without_a_branch():
    given = problem(actions=[action("look", sense=[atom("q")])], goal=[f.KnowWhether(atom("q"))])
    look, goal = plan_of(given)
    assert look.delivers == ("q",) and look.on is None and look.next is goal


def test_a_sensed_number_is_delivered_and_never_branched_on():
    given = problem(
        actions=[action("weigh", sense=[app("fuel")])], goal=[f.KnowValue(app("fuel"))], functions=[FUEL]
    )
    weigh, _ = plan_of(given)
    assert weigh.delivers == ("fuel",) and not weigh.outcomes


def test_a_second_sensed_fact_is_branched_on_by_a_node_without_action():
    ways = [
        action(
            f"way_{i}",
            pre=[know(f.Literal(atom("q"), a)), know(f.Literal(atom("p", "x"), b))],
            effects=[add(lit("r"))],
        )
        for i, (a, b) in enumerate([(True, True), (True, False), (False, True), (False, False)])
    ]
    given = problem(actions=[action("look", sense=[atom("q"), atom("p", "x")]), *ways], goal=[know(lit("r"))])
    nodes = plan_of(given)
    assert [node.on for node in nodes[:3]].count(None) == 0
    assert nodes[0].action is not None and nodes[1].action is None and nodes[2].action is None
    assert len(set(in_all_worlds(given, nodes[0]))) == 1


def test_an_initial_kw_entry_is_branched_on_without_sensing():
    given = problem(actions=TOOLS[1:], goal=[know(lit("r"))], initial=[add(lit("q"), to="Kw")])
    nodes = plan_of(given)
    assert nodes[0].action is None and nodes[0].on == "q"
    assert set(in_all_worlds(given, nodes[0])) == {2}


def test_a_goal_that_holds_already_needs_no_action():
    (goal,) = plan_of(problem(goal=[f.Not(know(lit("q")))]))
    assert goal.is_goal


def test_sensing_waits_until_it_is_needed():
    """Although `look` stands first in the file, `more` does not depend on it and is not repeated."""
    more = action("more", effects=[add(no("p", "y"))])
    last = action("last", pre=[know(no("p", "y")), know(lit("r"))], effects=[add(lit("p", "y"))])
    nodes = plan_of(problem(actions=[*TOOLS, more, last], goal=[know(lit("p", "y"))]), search="depth-first")
    order = names(nodes)
    assert order.count("more()") == 1
    assert in_all_worlds(problem(actions=[*TOOLS, more, last], goal=[know(lit("p", "y"))]), nodes[0])


def test_sensing_what_is_known_is_not_a_step():
    given = problem(actions=[action("look", sense=[atom("q")])], goal=[know(lit("r"))], initial=[add(lit("q"))])
    found = find_skeleton(ground(given))
    assert isinstance(found, Unreachable) and found.statistics.generated == 0


# ----------------------------------------------------------------------------------------------------- no plan
@pytest.mark.parametrize("search", ALGORITHMS)
def test_a_plan_that_works_by_luck_only_is_none(search):
    found = find_skeleton(ground(problem(actions=[TOOLS[0], TOOLS[1]], goal=[know(lit("p", "x"))])), search=search)
    assert isinstance(found, Unreachable) and found.goals == ()


def test_a_goal_out_of_reach_is_named():
    found = find_skeleton(ground(problem(actions=TOOLS[:1], goal=[know(lit("q")), know(lit("r"))])))
    assert isinstance(found, Unreachable) and found.goals == ("K(r)",)


@pytest.mark.parametrize("search", ALGORITHMS)
def test_trying_again_until_luck_comes_is_no_plan(search):
    """look, and if it is not so forget it and look again: a circle, not a plan."""
    forget = action("forget", pre=[know(no("q"))], effects=[delete(no("q"))])
    found = find_skeleton(ground(problem(actions=[TOOLS[0], forget], goal=[know(lit("q"))])), search=search)
    assert isinstance(found, Unreachable)


@pytest.mark.parametrize("search", ALGORITHMS)
def test_a_tempting_gamble_is_given_up_for_the_safe_way(search):
    """The short way looks and hopes, and is a dead end if luck fails; the long way needs no luck."""
    gamble = action("gamble", pre=[know(lit("p", "x"))], effects=[delete(lit("p", "x"))], sense=[atom("r")])
    first = action("first", pre=[know(lit("p", "x"))], effects=[add(lit("p", "y"))])
    second = action("second", pre=[know(lit("p", "y")), know(lit("p", "x"))], effects=[add(lit("r"))])
    given = problem(actions=[gamble, first, second], goal=[know(lit("r"))], initial=[add(lit("p", "x"))])
    assert names(plan_of(given, search=search)) == ["first()", "second()"]


def board(places, sure, gambles):
    """Places joined by sure steps and by gambles (lucky goes here, unlucky there); from `a` to `goal`."""
    at, forget = app("at"), delete(lit("q"), no("q"))
    schemas = [
        action(f"{one}_{two}", pre=[know(cmp(at, "=", one))], effects=[add(cmp(at, "=", two))])
        for one, two in sure
    ]
    for origin, lucky, unlucky in gambles:
        between = f"throw_{origin}"
        throw = [add(cmp(at, "=", between))]
        schemas.append(action(between, pre=[know(cmp(at, "=", origin))], effects=throw, sense=[atom("q")]))
        for end, outcome in ((lucky, lit("q")), (unlucky, no("q"))):
            there = [know(cmp(at, "=", between)), know(outcome)]
            schemas.append(action(f"{between}_{end}", pre=there, effects=[add(cmp(at, "=", end)), forget]))
    values = (*places, *(f"throw_{origin}" for origin, _, _ in gambles))
    start, goal = [add(cmp(at, "=", "a"))], [know(cmp(at, "=", "goal"))]
    return problem(actions=schemas, functions=[Function("at", (), values=values)], initial=start, goal=goal)


@pytest.mark.parametrize("search", ALGORITHMS)
def test_what_failed_only_because_of_an_ancestor_is_tried_again_elsewhere(search):
    """Below b, c leads back to b and so fails; but a itself may go to c, and from there on by b."""
    given = board(
        ["a", "b", "c", "d", "e", "goal"],
        sure=[("c", "b"), ("b", "d"), ("d", "e"), ("e", "goal")],
        gambles=[("b", "goal", "c"), ("a", "b", "c")],
    )
    nodes = plan_of(given, search=search)
    assert "c_b()" in names(nodes) and "throw_b()" not in names(nodes)
    assert len(set(in_all_worlds(given, nodes[0], {"q"}))) == 2


def test_a_continuation_that_senses_serves_no_node_where_the_fact_is_known():
    """After `repair` q is known; the continuation of the other outcome, which looks first, finds nothing new."""
    y, z = lit("p", "y"), lit("r")
    schemas = [
        action("peek", sense=[app("colour")]),
        action("easy", pre=[know(cmp(app("colour"), "=", "u"))], effects=[add(y)]),
        action("prepare", pre=[know(cmp(app("colour"), "!=", "u"))], effects=[add(z)]),
        action("repair", pre=[know(z)], effects=[add(lit("q")), add(y)]),
        *TOOLS[:3],
    ]
    given = problem(actions=schemas, goal=[know(lit("p", "x")), know(y)], functions=[COLOUR])
    nodes = plan_of(given)
    assert {"easy()", "repair()", "look()"} <= set(names(nodes))
    in_all_worlds(given, nodes[0], {"q", "colour"})


# ------------------------------------------------------------------------------------------------------- budget
def counting_forever():
    more = action("more", effects=[add(cmp(app("fuel"), "=", f.Arithmetic("+", app("fuel"), f.Number(1.0))))])
    start = [add(cmp(app("fuel"), "=", 0))]
    return problem(actions=[more], functions=[FUEL], initial=start, goal=[know(cmp(app("fuel"), "<", 0))])


def test_the_number_of_expansions_is_a_budget():
    found = find_skeleton(ground(counting_forever()), limits=SearchLimits(expansions=100))
    assert isinstance(found, Exhausted) and found.budget == "expansions" and found.statistics.expanded == 100


def test_the_deadline_cuts_off():
    looks = iter([False] * 3 + [True])
    found = find_skeleton(ground(counting_forever()), limits=SearchLimits(deadline=lambda: next(looks)))
    assert isinstance(found, Exhausted) and found.budget == "time"


def test_progress_is_reported_now_and_then():
    told = []
    find_skeleton(ground(counting_forever()), limits=SearchLimits(expansions=10_000), on_progress=told.append)
    assert [statistics.expanded for statistics in told] == [4096, 8192]


def test_a_plan_of_a_thousand_actions_needs_no_deep_stack():
    number, more = app("fuel"), f.Arithmetic("+", app("fuel"), f.Number(1.0))
    step = action("step", effects=[add(cmp(number, "=", more))])
    given = problem(
        actions=[step],
        functions=[FUEL],
        initial=[add(cmp(number, "=", 0))],
        goal=[know(cmp(number, ">=", 1000))],
    )
    assert len(plan_of(given)) == 1001


# ----------------------------------------------------------------------------------------------------- geometry
def call(name, *arguments):
    return f.ProcedureCall(name, tuple(f.Argument(argument) for argument in arguments))


A = var("a")
PICK = action("pick", parameters=[A], effects=[add(lit("p", A))], geometry=call("pick", A))
MOVE = action("move", geometry=call("move"))
BOTH = [know(lit("p", "x")), know(lit("p", "y"))]


def test_every_procedure_is_taken_as_possible_unless_it_is_refused():
    assert names(plan_of(problem(actions=[PICK], goal=BOTH), geometry=Scripted())) == ["pick(x)", "pick(y)"]
    found = find_skeleton(ground(problem(actions=[PICK], goal=BOTH)), geometry=Scripted({"pick(y)": {0}}))
    assert isinstance(found, Unreachable)


def test_another_attempt_is_a_move_of_the_search():
    nodes = plan_of(problem(actions=[PICK], goal=BOTH), geometry=Scripted({"pick(y)": {0, 1}}, attempts=3))
    assert {str(node.action): node.attempt for node in nodes if node.action} == {"pick(x)": 0, "pick(y)": 2}


def test_an_action_without_knowledge_effect_does_not_blow_up_the_search():
    geometry = Scripted(attempts=5)
    found = solved(problem(actions=[MOVE, PICK], goal=BOTH), geometry=geometry)
    assert names(found.skeleton.nodes()) == ["pick(x)", "pick(y)"]
    assert found.statistics.expanded <= 3


def test_an_action_without_knowledge_effect_is_used_where_geometry_tells_states_apart():
    """`pick(x)` is refused until the robot has moved."""

    class AfterMoving(Scripted):
        def options(self, call, trace):
            moved = ("move()", 0) in trace
            return super().options(call, trace) if moved or call.procedure == "move" else []

    nodes = plan_of(problem(actions=[PICK, MOVE], goal=BOTH), geometry=AfterMoving(tells_apart={"move()"}))
    assert names(nodes) == ["move()", "pick(x)", "pick(y)"]


def test_a_continuation_is_shared_only_where_geometry_is_equal():
    """`end` works after `push`, and after `lift` only at another attempt: so there are two `end` nodes."""

    class Picky(Scripted):
        def options(self, call, trace):
            options = super().options(call, trace)
            lifted = any(entry[0] == "lift()" for entry in trace)
            return options[1:] if call.procedure == "end" and lifted else options[:1]

    tools = [
        TOOLS[0],
        *(action(a.name, pre=a.preconditions, effects=a.effects, geometry=call(a.name)) for a in TOOLS[1:]),
    ]
    given = problem(actions=tools, goal=[know(lit("r"))])
    nodes = plan_of(given, geometry=Picky(attempts=2, tells_apart={"lift()", "push()"}))
    assert sorted(node.attempt for node in nodes if str(node.action) == "end()") == [0, 1]
    assert len(plan_of(given, geometry=Scripted())) == 5


def test_geometric_tests_in_formulas_are_asked_at_the_trace():
    free = f.Test(call("is_free", f.Constant("x")))
    clear = action("clear", effects=[add(lit("q"))], geometry=call("clear"))
    grasp = action("grasp", pre=[free], effects=[add(lit("r"))], geometry=call("grasp"))
    geometry = Scripted(tests={"is_free(x)": lambda trace: ("clear()", 0) in trace}, tells_apart={"clear()"})
    given = problem(actions=[clear, grasp], goal=[know(lit("r"))])
    assert names(plan_of(given, geometry=geometry)) == ["clear()", "grasp()"]
    assert names(plan_of(given)) == ["grasp()"]


def doomed(given, *steps):
    """Whether the search gives a node up at once, after these actions."""
    space = SearchSpace(ground(given), None)
    node = space.start
    for name in steps:
        act = next(action for action in space.task.actions if str(action) == name)
        node = space.after(node, Act(act, 0, None))
    return _Contingent(space, ALGORITHMS["best"], Counter(SearchLimits()), tuning.MAX_FAILED_CHOICES).is_doomed(
        node
    )


def washing(*, soap: bool, rules=()):
    """Dirty or not can be sensed; what is dirty is washed if there is soap, which may be poured away."""
    wash = action("wash", pre=[know(lit("q"))], effects=[add(no("p", "x"))])
    pour = action("pour_away", effects=[add(no("q"))])
    look = action("look", sense=[atom("p", "x")])
    start = [add(lit("q", positive=soap))]
    return problem(actions=[wash, pour, look], initial=start, goal=[know(no("p", "x"))], update_rules=rules)


def test_a_node_is_doomed_if_what_is_unknown_may_turn_out_beyond_help():
    assert doomed(washing(soap=False))
    assert not doomed(washing(soap=True))
    assert doomed(washing(soap=True), "pour_away()")


def test_nothing_is_called_doomed_where_outcomes_may_exclude_each_other():
    """With inference a single outcome may be no possible world."""
    rule = f.Conditional(know(no("q")), (add(no("r")),))
    assert not doomed(washing(soap=False, rules=[rule]))


def test_only_the_best_search_judges_what_is_doomed():
    space = SearchSpace(ground(washing(soap=False)), None)
    assert not _Contingent(
        space, ALGORITHMS["greedy"], Counter(SearchLimits()), tuning.MAX_FAILED_CHOICES
    ).is_doomed(space.start)


# ------------------------------------------------------------------------------------------------ a second opinion
@pytest.fixture
def coloured_balls(tmp_path):
    """One ball in a grid of four by four: two ways of breaking ties, two sizes of plans."""
    assert (
        main(["generate", "coloured_balls", "--n", "4", "--set", "balls=1", "-o", str(tmp_path / "n4.yaml")]) == 0
    )
    return load_problem(tmp_path / "n4.yaml")


def test_a_small_problem_is_solved_twice_and_the_smaller_plan_taken(coloured_balls, monkeypatch):
    task = ground(coloured_balls)
    twice = find_skeleton(task)
    monkeypatch.setattr(tuning, "SECOND_SEARCH_EXPANSIONS", 0)
    once = find_skeleton(task)
    sizes = [len(list(found.skeleton.nodes())) for found in (twice, once)]
    assert sizes[0] < sizes[1]
    assert twice.statistics.expanded > once.statistics.expanded, "both searches are counted"


def test_a_second_opinion_stays_within_the_budget(coloured_balls, monkeypatch):
    task = ground(coloured_balls)
    monkeypatch.setattr(tuning, "SECOND_SEARCH_EXPANSIONS", 0)
    once = find_skeleton(task)
    monkeypatch.undo()
    for more in (0, 1, 20):
        found = find_skeleton(task, limits=SearchLimits(expansions=once.statistics.expanded + more))
        assert isinstance(found, FoundSkeleton)
        assert found.statistics.expanded == once.statistics.expanded + more
        assert len(list(found.skeleton.nodes())) == len(list(once.skeleton.nodes()))


def test_geometry_is_given_one_proposal(coloured_balls, monkeypatch):
    task = ground(coloured_balls)
    with_geometry = find_skeleton(task, geometry=Scripted())
    monkeypatch.setattr(tuning, "SECOND_SEARCH_EXPANSIONS", 0)
    assert with_geometry.statistics == find_skeleton(task, geometry=Scripted()).statistics
