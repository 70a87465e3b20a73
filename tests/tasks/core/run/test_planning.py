from itertools import count

import pytest

from kabo.tasks.core import (
    Alternatives,
    Failure,
    Fallbacks,
    Limit,
    Merger,
    Result,
    Serial,
    Task,
    Wrapper,
    backward,
    connector,
    forward,
    generator,
    monitor,
)


@generator(values=(0,))
def offer(scene, properties, seed):
    for value in properties["values"]:
        yield Result(value, cost=float(abs(value)))


@generator()
def naturals(scene, properties, seed):
    for value in count():
        yield Result(value)


@forward(among=None)
def keep(scene, properties, seed):
    wanted = properties["among"]
    if wanted is not None and scene not in wanted:
        return Failure("not wanted", f"{scene} is not wanted")
    return Result(scene)


@forward(step=1)
def step(scene, properties, seed):
    return Result(scene + properties["step"])


@backward()
def step_back(scene, properties, seed):
    return Result(scene - 1)


@connector()
def join(start, end, properties, seed):
    return Result(cost=abs(start - end), motion=(start, end))


@monitor(add=(0,))
def beside(scene, properties, seed):
    return [Result(scene + value) for value in properties["add"]]


def scenes(solutions):
    return [solution.end.scene for solution in solutions]


def test_a_path_is_planned_from_the_generator_outwards():
    (solution,) = Task("t", step_back("b"), offer("g", values=[5]), step("f")).plan()
    assert (solution.start.scene, solution.end.scene) == (4, 6)
    assert [part.stage.name for part in solution.parts] == ["b", "g", "f"]


def test_connectors_join_all_pairs_and_the_cheapest_comes_first_where_all_are_known():
    task = Task("t", offer("a", values=[1, 2]), join("c"), offer("b", values=[10, 4]))
    costs = [solution.cost for solution in task.plan()]
    assert sorted(costs) == [1 + 3 + 4, 2 + 2 + 4, 1 + 9 + 10, 2 + 8 + 10]
    assert task.best.cost == 8


def test_planning_is_resumable_and_stops_when_it_has_enough():
    task = Task("t", naturals("g"))
    assert scenes(task.plan(max_solutions=3)) == [0, 1, 2]
    assert scenes(task.plan(max_solutions=5)) == [0, 1, 2, 3, 4]
    assert not task.exhausted
    task.reset()
    assert task.solutions == []
    assert scenes(task.plan(jobs=2)) == [0, 1]


def test_stop_takes_effect_between_jobs():
    calls = iter([False, False, False, True])
    task = Task("t", naturals("g"))
    task.plan(stop=lambda: next(calls))
    assert task.statistics["g"].calls == 2


def test_a_task_that_is_content_after_some_time_keeps_what_is_there():
    assert len(Task("t", naturals("g")).plan(commit_after=0.0)) == 1


def test_an_exhausted_task_says_so_and_explains_the_first_stage_without_successes():
    task = Task("t", offer("g", values=[1, 2, 3]), keep("filter", among=()), step("never"))
    assert task.plan() == [] and task.exhausted
    explanation = task.explain()
    assert explanation.stage is task.find("filter")
    assert explanation.failures == {"not wanted": 3}
    assert explanation.text == "'filter' found nothing; failed: not wanted 3"
    assert explanation.examples[0].comment == "1 is not wanted"
    assert task.statistics["never"].calls == 0


def test_pairs_that_never_fit_are_counted_with_their_reason():
    class Same(join):
        def mismatch(self, start, end, properties):
            return None if start == end else "joint_1 differs"

    task = Task("t", offer("a", values=[1, 2]), Same("c"), offer("b", values=[3]))
    assert task.plan() == []
    assert task.explain().mismatches == {"joint_1 differs": 2}
    assert task.statistics["c"].calls == 0


def test_what_a_failure_on_one_side_makes_useless_is_not_run_on_the_other():
    def task(pruning):
        made = Task(
            "t",
            offer("a"),
            join("c"),
            step_back("b"),
            offer("g", values=[1, 2, 3]),
            keep("k", among=[3]),
            pruning=pruning,
        )
        return made, made.plan()

    with_pruning, found = task(True)
    without, same = task(False)
    assert scenes(found) == scenes(same) == [3]
    assert with_pruning.statistics["c"].calls < without.statistics["c"].calls == 3


def test_alternatives_give_the_solutions_of_every_child():
    task = Task("t", offer("g"), Alternatives("either", step("one"), step("ten", step=10)))
    assert sorted(scenes(task.plan())) == [1, 10]


def test_fallbacks_ask_the_next_child_only_where_the_former_gave_nothing():
    first, second = keep("first", among=[1]), step("second", step=100)
    task = Task("t", offer("g", values=[1, 2]), Fallbacks("f", first, second))
    assert sorted(scenes(task.plan())) == [1, 102]
    assert task.statistics["f/second"].calls == 1


def test_fallbacks_of_generators_go_on_only_if_nothing_at_all_came():
    task = Task("t", Fallbacks("f", offer("none", values=()), offer("one", values=[1]), offer("two", values=[2])))
    assert scenes(task.plan()) == [1]
    assert task.statistics["f/two"].calls == 0


def test_fallbacks_of_connectors_decide_for_every_pair():
    @connector()
    def near(start, end, properties, seed):
        return Result() if abs(start - end) < 2 else Failure("too far")

    task = Task("t", offer("a", values=[1, 5]), Fallbacks("f", near("near"), join("far")), offer("b", values=[1]))
    assert len(task.plan()) == 2
    assert task.statistics["f/far"].calls == 1


def test_fallbacks_look_into_containers_before_they_move_on():
    way = Serial("way", step("one"), keep("k", among=[2]))
    task = Task("t", offer("g", values=[1, 5]), Fallbacks("f", way, step("ten", step=10)))
    assert sorted(scenes(task.plan())) == [2, 15]


def test_monitors_fire_once_for_each_success():
    task = Task(
        "t", offer("a", values=[1, 2]), keep("open", among=[2]), join("c"), beside("pose", "open", add=[1, 5])
    )
    assert sorted(scenes(task.plan())) == [3, 7]
    assert task.statistics["pose"].calls == 1


def test_a_wrapper_changes_filters_and_multiplies_solutions():
    class Twice(Wrapper):
        def transform(self, solution, properties, seed):
            if solution.end.scene == 1:
                yield Failure("one is no good")
                return
            for sign in (1, -1):
                yield Result(sign * solution.end.scene, cost=solution.cost + 1, properties={"sign": sign})

    task = Task("t", Twice("w", offer("g", values=[1, 2])))
    found = task.plan()
    assert scenes(found) == [2, -2]
    assert [s["w"].properties for s in found] == [{"sign": 1}, {"sign": -1}]
    assert found[0]["w/g"].cost == 2.0
    assert task.statistics["w"].failures == {"one is no good": 1}


def test_a_limit_lets_so_many_solutions_through_and_asks_no_more():
    task = Task("t", Limit("l", naturals("g"), max_solutions=3), step("s"))
    assert scenes(task.plan()) == [1, 2, 3]
    assert task.exhausted
    assert task.statistics["l/g"].calls <= 4


def test_a_merger_puts_one_solution_of_every_child_together():
    class Sum(Merger):
        def merge(self, scene, solutions, properties, seed):
            return Result(sum(s.end.scene - scene for s in solutions) + scene)

    task = Task("t", offer("g"), Sum("m", step("one"), step("ten", step=10)))
    assert scenes(task.plan()) == [11]


def test_a_cost_term_replaces_the_sum_and_leaves_the_costs_of_the_children():
    inner = Serial("inner", offer("g", values=[7]), cost=lambda solution: (1.0, "flat"))
    (solution,) = Task("t", inner).plan()
    assert (solution.cost, solution["inner"].comment, solution["inner/g"].cost) == (1.0, "flat", 7.0)


def test_an_infinite_cost_is_a_failure_with_its_comment():
    task = Task("t", offer("g", values=[7], cost=lambda solution: (float("inf"), "far too dear")))
    assert task.plan() == []
    assert task.found(task.children[0])[1][0].comment == "far too dear"


def test_motions_are_the_leaves_of_a_solution_in_order_of_time():
    (solution,) = Task("t", offer("a"), join("c"), offer("b", values=[2])).plan()
    assert [leaf.motion for leaf in solution.leaves if leaf.motion] == [(0, 2)]


def test_asking_a_solution_for_a_part_that_it_has_not_names_those_that_it_has():
    (solution,) = Task("t", offer("a")).plan()
    with pytest.raises(KeyError, match="it has 'a'"):
        solution["b"]


def test_many_equal_sections_do_not_explode():
    stages = []
    for i in range(40):
        stages += [offer(f"g{i}", values=[1, 2, 3]), join(f"c{i}")]
    task = Task("t", *stages, keep("last", among=()))
    task.remove(task.children[-1])
    task.add(Serial("end", offer("e"), keep("never", among=())))
    assert task.plan() == []
    assert sum(each.calls for each in task.statistics.values()) < 2000


def test_of_many_whole_paths_the_cheapest_is_lifted_first_and_no_more_than_asked_for():
    stages = []
    for i in range(12):
        stages += [offer(f"g{i}", values=[1, 2, 3]), join(f"c{i}")]
    task = Task("t", *stages[:-1])
    task.plan(max_solutions=1)
    found = task.plan(max_solutions=50)
    assert len(found) == 50
    assert task.best.cost == 12.0


def test_a_stage_function_that_gives_something_else_is_a_type_error():
    @generator()
    def wrong(scene, properties, seed):
        return 5

    with pytest.raises(TypeError, match="results and failures, not 5"):
        Task("t", wrong("w")).plan()


def test_seeds_depend_on_the_task_the_stage_and_the_job():
    seen = []

    @forward()
    def note(scene, properties, seed):
        seen.append(seed)
        return Result(scene)

    for task_seed in (0, 0, 1):
        Task("t", offer("g", values=[1, 2]), note("n"), seed=task_seed).plan()
    assert seen[:2] == seen[2:4] != seen[4:]
    assert len(set(seen)) == 4
