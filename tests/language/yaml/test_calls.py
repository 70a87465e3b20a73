"""External procedures in domain files: declared with types, asked in formulas and effects, wrong use told with a remedy."""

from pathlib import Path

import pytest

import kabo
from kabo.language import formulas as f
from kabo.language.spelling import spell

DOMAIN = """
domain: d
types: [place]
predicates:
  clean: [place]
functions:
  where: {{value: place}}
  fuel: {{value: number}}
procedures:
  distance: {{arguments: [place, place], value: number}}
  nearest: {{arguments: [place], value: place}}
  colour: {{value: [red, blue]}}
  safe: {{arguments: [place, number]}}
  ready:
actions:
  go:
    parameters: {{to: place}}
    {action}
"""
PROBLEM = """
problem: p
objects:
  place: [a, b]
goal:
  - K(where = b)
"""


def load(folder: Path, action: str) -> kabo.Problem:
    (folder / "domain.yaml").write_text(DOMAIN.format(action=action))
    (folder / "problem.yaml").write_text(PROBLEM)
    return kabo.load_problem(folder / "problem.yaml")


@pytest.mark.parametrize(
    "formula",
    [
        "K(fuel >= 2 * distance(where, to))",
        "K(where = nearest(to))",
        "K(colour = red)",
        "K(nearest(to) != where)",
        "not safe(to, fuel - 1)",
        "ready()",
        "K(clean(nearest(nearest(to))))",
    ],
)
def test_a_formula_with_a_procedure_is_read_and_spelled_as_it_was_written(tmp_path, formula):
    problem = load(tmp_path, f"preconditions:\n      - {formula}")
    (read,) = problem.domain.actions["go"].preconditions
    assert spell(read) == formula


def test_procedures_are_terms_and_tests_of_their_own(tmp_path):
    problem = load(tmp_path, "preconditions:\n      - K(where = nearest(to))\n      - ready()")
    value, test = problem.domain.actions["go"].preconditions
    assert isinstance(value, f.Know) and isinstance(value.claim, f.Comparison)
    assert isinstance(value.claim.right, f.External)
    assert isinstance(test, f.Test) and isinstance(test.call, f.External)


@pytest.mark.parametrize(
    ("action", "said"),
    [
        ("preconditions:\n      - K(safe(to, 1))", "stands by itself|without K"),
        ("preconditions:\n      - K(where = ready)", '"ready" is a test'),
        ("preconditions:\n      - nearest(to)", '"nearest" has a value: it is no test'),
        ("preconditions:\n      - Kv(nearest(to))", "known whenever it is asked"),
        ("preconditions:\n      - K(fuel = distance(to))", "distance takes 2 arguments, not 1"),
        ("preconditions:\n      - K(where = colour)", "these can never be equal"),
        ("preconditions:\n      - safe(1, to)", "must be a place"),
        ("preconditions:\n      - saef(to, 1)", 'did you mean "safe"'),
        ("effects:\n      - add(Kf, where = colour)", "these can never be equal"),
        ("effects:\n      - add(Kf, colour = red)", "must have the function on its left"),
        ("geometry: nearest(to)", "takes what succeeds or fails"),
        ("geometry: safe(to, x = 1)", "stand by position"),
        ("geometry: safe(to)", "safe takes 2 arguments, not 1"),
    ],
)
def test_wrong_use_of_a_procedure_is_told_with_its_place(tmp_path, action, said):
    with pytest.raises(kabo.InputError, match=said) as caught:
        load(tmp_path, action)
    (finding,) = caught.value.diagnostics
    assert finding.line > 16


def test_names_of_procedures_of_geometry_are_taken(tmp_path):
    text = DOMAIN.format(action="cost: 1").replace("  ready:", "  pick:")
    (tmp_path / "domain.yaml").write_text(text)
    (tmp_path / "problem.yaml").write_text(PROBLEM)
    with pytest.raises(kabo.InputError, match='"pick" is the name of a procedure of geometry'):
        kabo.load_problem(tmp_path / "problem.yaml")
