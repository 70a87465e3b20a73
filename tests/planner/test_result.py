import pickle
from pathlib import Path

import kabo
from kabo.planner.result import Reason, Result

PARCEL = Path(__file__).parents[1] / "acceptance" / "parcels" / "one.yaml"


def test_a_result_with_a_plan_says_how_large_the_plan_is_and_keeps_its_problem():
    problem = kabo.load_problem(PARCEL)
    result = kabo.solve(problem)
    assert repr(result).startswith("<Result solved: ") and "outcome" in repr(result)
    assert result.problem is problem
    assert pickle.loads(pickle.dumps(result)) == result


def test_a_result_without_a_plan_says_why():
    result = Result("no_plan", None, reason=Reason("knowledge", None, "the cup is <never> clean", ("no soap",)))
    assert repr(result) == "<Result no_plan: the cup is <never> clean>"
    shown = result._repr_html_()
    assert "the cup is &lt;never&gt; clean" in shown and "<li>no soap</li>" in shown and "iframe" not in shown
