"""Random problems that once had no plan: what was sensed may wait, and be branched on in any order."""

import pytest

import kabo

SECOND_FACT_FIRST = """
domain: small
types: [thing]
constants:
  thing: [x, y]
predicates:
  p: [thing]
  r: []
functions:
  f: {arguments: [], value: [u, v, w]}
actions:
  exclude:
    preconditions:
      - K(f != v)
    sense: p(y)
    effects:
      - add(Kf, f != u)
  look:
    preconditions:
      - K(r)
      - (K(f = w) xor K(not p(y)))
    effects:
      - add(Kw, r and p(x))
"""
SECOND_FACT_FIRST_PROBLEM = """
problem: small
initial:
  - add(Kf, r)
  - add(Kf, f != v)
goal:
  - (K(p(x)) or K(not p(x)))
  - always(not K(p(y)))
"""

ACTING_BEFORE_LOOKING = """
domain: small
types: [thing]
predicates:
  q: []
actions:
  clear:
    effects:
      - when q then q
      - add(Kf, not q)
"""
ACTING_BEFORE_LOOKING_PROBLEM = """
problem: small
initial:
  - add(Kw, q)
goal:
  - K(not q)
"""


@pytest.mark.parametrize(
    "search", ["best", "greedy", "astar", "breadth-first", "depth-first", "iterative-deepening"]
)
@pytest.mark.parametrize(
    ("domain", "text"),
    [
        (SECOND_FACT_FIRST, SECOND_FACT_FIRST_PROBLEM),
        (ACTING_BEFORE_LOOKING, ACTING_BEFORE_LOOKING_PROBLEM),
    ],
)
def test_a_plan_that_does_not_branch_at_once_on_the_first_open_fact_is_found(tmp_path, domain, text, search):
    """Seed 533: only the fact sensed last may be asked. Seed 2551: the action is possible only while one is not sure."""
    (tmp_path / "domain.yaml").write_text(domain)
    (tmp_path / "problem.yaml").write_text(text)
    problem = kabo.load_problem(tmp_path / "problem.yaml")
    result = kabo.solve(problem, search=search)
    assert result.status == "solved"
    assert kabo.verify(problem, result.plan).ok
