"""What is cut off says nothing: no refusal, no proof, no error, whenever time, samples or memory end.

The budget is made to end at a drawn look at the stop flag, in whatever the run does then: loading, decomposing,
sampling, searching, certifying. The judge is the same run without a limit, and procedures that are asked afresh.
"""

import gc
import os
import signal
import tempfile
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.children import made_in_child
from kabo.errors import CutOff, KaboError
from kabo.explain.explain import explain
from kabo.geometry import enclosing_parts
from kabo.language import Problem
from kabo.meshes import Mesh
from kabo.plan import plan_to_json
from kabo.planner.result import Result
from kabo.planner.solve import solve
from kabo.tasks.procedures import GeometricProcedures
from kabo.verify import verify_plan
from tests.conftest import PROPERTY_SCALE
from tests.planner.gantry import gantry_problem

RUNS = count()
LID = {"lid": ((0.06, 0.06, 0.02), (0.2, 0.0, 0.06))}
FAR = {"cube": (0.9, 0.0, 0.02)}
PROBLEMS: dict[str, dict[str, Any]] = {
    "solved": {},
    "solved for two": {
        "things": {"cube": (0.2, 0.0, 0.02), "other": (0.2, 0.2, 0.02)},
        "goal": "forall(thing o) K(at(o, shelf))",
    },
    "refused": {"walls": LID},
    "out of reach": {"things": FAR, "goal": "K(held(cube))"},
    "proved": {"robots": "robots: []"},
}
WHOLE = PROPERTY_SCALE >= 1.0
OFTEN = settings(max_examples=600 if WHOLE else 30)  # of 30 choices: problem, order and quality
SELDOM = settings(max_examples=400 if WHOLE else 20)  # of 5 problems or fewer
LIMITS = {"max_samples": 600, "max_expansions": 2_000}


class Looks:
    """Says stop at the look of that number, and from then on; counts them."""

    def __init__(self, last: float = float("inf")) -> None:
        self.last, self.count = last, 0

    def __call__(self) -> bool:
        self.count += 1
        return self.count > self.last

    def look(self) -> None:
        if self():
            raise CutOff


@cache
def problem(name: str) -> Problem:
    folder = Path(tempfile.mkdtemp(prefix="kabo-gantry-"))
    return gantry_problem(folder, **PROBLEMS[name])


def solved(name: str, looks: Looks, **options: Any) -> tuple[Result, list[GeometricProcedures]]:
    if next(RUNS) % 25 == 0:
        gc.collect()  # runs leave cycles behind, with all that they remembered
    asked: list[GeometricProcedures] = []
    result = solve(problem(name), **{**LIMITS, **options}, cancelled=looks, on_procedures=asked.append)
    return result, asked


@cache
def whole(name: str, order: str, quality: str) -> tuple[Result, int, Any]:
    looks = Looks()
    result, asked = solved(name, looks, geometry_order=order, quality=quality)
    return result, looks.count, asked[0]._answers


def written(result: Result) -> bytes | None:
    return None if result.plan is None else plan_to_json(result.plan)


@pytest.mark.slow
@OFTEN
@given(
    name=st.sampled_from(sorted(PROBLEMS)),
    order=st.sampled_from(["lazy", "eager", "adaptive"]),
    quality=st.sampled_from(["fast", "good"]),
    share=st.floats(0.0, 1.05),
)
def test_a_run_that_is_cut_off_refuses_and_proves_nothing(name, order, quality, share):
    reference, looks, answers = whole(name, order, quality)
    stop = Looks(int(share * looks))
    result, asked = solved(name, stop, geometry_order=order, quality=quality)
    if stop.count <= stop.last:
        event("not cut off")
        assert (result.status, written(result)) == (reference.status, written(reference))
    elif result.status == "solved":
        event("cut off after a plan was found")
        assert reference.status == "solved"
        assert result.cut_off or written(result) == written(reference)
    elif result.status == "no_plan":  # looks that come after the proof only look for more to tell
        event("cut off after the proof")
        assert reference.status == "no_plan"
    else:
        event("cut off before a plan was found" if asked else "cut off while loading")
        assert result.reason is not None and result.reason.proved is None
        if reference.status != "exhausted":
            assert result.reason.budget == "time"
    for procedures in asked:
        for key, answer in procedures._answers.items():
            assert key not in answers or answers[key] == answer, f"{key[0][0]}: {answer}"


@pytest.mark.parametrize("quality", ["fast", "good"])
def test_an_interrupt_keeps_a_plan_that_was_found(quality):
    found: list[Result] = []
    result = solve(problem("solved"), quality=quality, cancelled=lambda: bool(found), on_found=found.append)
    assert result.status == "solved" and result.plan is not None and result.plan.certificate is None
    assert written(result) == written(found[0])
    doing = ["certifying"] if quality == "fast" else ["refining", "certifying"]
    assert [sentence.split()[0] for sentence in result.cut_off] == doing
    assert verify_plan(problem("solved"), result.plan).ok


def test_memory_that_ends_is_told_as_memory():
    for order in ("lazy", "eager"):
        result = solve(problem("refused"), memory=1.0, geometry_order=order)
        assert result.status == "exhausted" and result.reason is not None and result.reason.budget == "memory"


@SELDOM
@given(name=st.sampled_from(["solved", "solved for two"]), samples=st.integers(0, 400))
def test_samples_that_end_are_told_as_samples(name, samples):
    reference, _, answers = whole(name, "adaptive", "fast")
    result, asked = solved(name, Looks(), max_samples=samples)
    event(result.status)
    if result.status == "solved":
        assert [node.action for node in result.plan.nodes.values()]
    else:
        assert result.reason is not None and result.reason.budget == "samples" and result.reason.proved is None
        assert not any("there is none" in detail for detail in result.reason.details)
    for key, answer in asked[0]._answers.items():
        assert key not in answers or answers[key] == answer


@pytest.mark.slow
@SELDOM
@given(name=st.sampled_from(sorted(PROBLEMS)), share=st.floats(0.0, 1.0))
def test_explanations_that_are_cut_off_prove_nothing(name, share):
    looks, reference = explained(name)
    found = explain(problem(name), cancelled=Looks(int(share * looks)), changes=1, max_samples=600)
    event(f"{reference}: {found.verdict}")
    assert found.verdict in ("exhausted", reference)


@cache
def explained(name: str) -> tuple[int, str]:
    looks = Looks()
    verdict = explain(problem(name), cancelled=looks, changes=1, max_samples=600).verdict
    return looks.count, verdict


def an_angle() -> tuple[np.ndarray, np.ndarray]:
    """Two legs of 20 cm at a right angle, 5 cm thick: two convex parts."""
    outline = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)]
    corners = [(0.05 * x, 0.05 * y, z) for z in (0.0, 0.05) for x, y in outline]
    top = [(3, 4, 5), (3, 5, 0), (3, 0, 1), (3, 1, 2)]
    sides = [(i, (i + 1) % 6, 6 + (i + 1) % 6) for i in range(6)]
    sides += [(i, 6 + (i + 1) % 6, 6 + i) for i in range(6)]
    return np.array(corners), np.array(
        [(a, c, b) for a, b, c in top] + [(6 + a, 6 + b, 6 + c) for a, b, c in top] + sides
    )


def children_of(process: int) -> set[str]:
    """The numbers of the processes that a process has begun and that are still there."""
    lists = Path(f"/proc/{process}/task").glob("*/children")
    return {number for each in lists for number in each.read_text().split()}


def test_parts_that_are_not_finished_are_not_kept(tmp_path):
    """A decomposition ends at any look, leaves no process and no file, and comes out the same the next time."""
    corners, faces = an_angle()
    children = children_of(os.getpid())  # of other tests
    for last in (0, 1, 2):
        with pytest.raises(CutOff):
            enclosing_parts(Mesh(corners, faces), 0.01, cache=tmp_path, look=Looks(last).look)
        assert not list(tmp_path.iterdir())
        assert children_of(os.getpid()) == children
    made = [enclosing_parts(Mesh(corners, faces), 0.01, cache=tmp_path / name) for name in ("a", "b")]
    assert len(made[0].parts) > 1
    assert all(np.array_equal(one, other) for one, other in zip(made[0].parts, made[1].parts, strict=True))


def test_a_child_that_dies_is_told_and_what_it_raises_is_raised_here():
    with pytest.raises(KaboError, match="SIGKILL"):
        made_in_child(lambda: os.kill(os.getpid(), signal.SIGKILL))
    with pytest.raises(ZeroDivisionError):
        made_in_child(lambda: 1 // 0)
    assert made_in_child(lambda: 3) == 3
