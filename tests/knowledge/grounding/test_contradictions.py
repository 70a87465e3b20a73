"""Initial knowledge that nothing can agree with is an error, with every place and a remedy, in every format."""

from pathlib import Path

import pytest

from kabo.cli import main
from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import load_problem

DOMAIN = """domain: d
types: [thing]
constants:
  thing: [x, y]
predicates:
  p: []
  q: []
  at: [thing]
functions:
  f: {arguments: [], value: [u, v]}
  n: {arguments: [], value: number}
actions:
  a:
    preconditions:
      - K(p)
    effects:
      - add(Kf, q)
"""


def problem(folder: Path, *initial: str):
    """A problem with these initial updates, the first in line 4."""
    (folder / "domain.yaml").write_text(DOMAIN)
    lines = "".join(f"  - {each}\n" for each in initial)
    (folder / "p.yaml").write_text(f"problem: p\ndomain: domain.yaml\ninitial:\n{lines}goal:\n  - K(q)\n")
    return load_problem(folder / "p.yaml")


def finding(folder: Path, *initial: str):
    with pytest.raises(InputError) as caught:
        ground(problem(folder, *initial))
    (found,) = caught.value.diagnostics
    return found


@pytest.mark.parametrize(
    ("initial", "at", "other"),
    [
        (["add(Kf, p, not p)"], (4, 16), ":4:13"),
        (["add(Kf, p)", "add(Kf, not p)"], (5, 13), ":4:13"),
        (["add(Kf, f = u, f = v)"], (4, 20), ":4:13"),
        (["add(Kf, f != u)", "add(Kf, f = u)"], (5, 13), ":4:13"),
        (["add(Kf, n = 1)", "add(Kf, n = 2)"], (5, 13), ":4:13"),
        (["add(Kf, at(x))", "add(Kf, q)", "add(Kf, not at(x))"], (6, 13), ":4:13"),
    ],
)
def test_two_facts_that_exclude_each_other_are_an_error_with_both_places(tmp_path, initial, at, other):
    found = finding(tmp_path, *initial)
    assert (found.line, found.column) == at
    assert "contradicts" in found.message and found.message.endswith(other)
    assert "remove one of the two" in found.hint


@pytest.mark.parametrize(
    ("initial", "line", "others"),
    [
        (["add(Kx, p, q)", "add(Kf, at(x))", "add(Kf, p, q)"], 6, [":4:5", ":6:13"]),
        (["add(Kf, not p)", "add(Kf, at(y))", "add(Kf, not q)", "add(Kor, p, q)"], 7, [":4:13", ":6:13"]),
        (["add(Kf, f != u, f != v)"], 4, [":4:13"]),
        # Unit propagation alone does not see it:
        (
            ["add(Kor, p, q)", "add(Kor, p, not q)", "add(Kor, not p, q)", "add(Kor, not p, not q)"],
            7,
            [":4:5", ":5:5", ":6:5"],
        ),
        (["add(Kx, p, q)", "add(Kx, p, not q)"], 5, [":4:5"]),
    ],
)
def test_what_cannot_all_be_so_is_an_error_with_all_places(tmp_path, initial, line, others):
    found = finding(tmp_path, *initial)
    assert found.line == line and "nothing can be as it says" in found.message
    assert all(place in found.message for place in others) and found.hint
    assert ":4:5" not in found.message or ":4:5" in others, "only what takes part is told"


def test_a_default_for_all_instances_may_be_replaced(tmp_path):
    ground(problem(tmp_path, "forall(thing z) add(Kf, not at(z))", "add(Kf, at(x))"))


def test_what_was_forgotten_may_be_said_anew(tmp_path):
    ground(problem(tmp_path, "add(Kf, p)", "del(Kf, p)", "add(Kf, not p)"))


def test_saying_the_same_twice_is_no_contradiction(tmp_path):
    ground(problem(tmp_path, "add(Kf, p)", "add(Kf, p, f = u)", "add(Kf, f = u, f != v)"))


PDDL = "(define (domain c) (:predicates (p) (q)) (:action a :parameters () :precondition (p) :effect (q)))\n"


@pytest.mark.parametrize(
    ("start", "places"),
    [
        ("(p) (not (p))", [":2:45", ":2:41"]),
        ("(oneof (p) (q)) (p) (q)", [":2:41", ":2:57", ":2:61"]),
        (
            "(or (p) (q)) (or (p) (not (q))) (or (not (p)) (q)) (or (not (p)) (not (q)))",
            [":2:41", ":2:54", ":2:92"],
        ),
    ],
)
def test_pddl_is_refused_with_all_places(tmp_path, capsys, start, places):
    file = tmp_path / "p.pddl"
    file.write_text(f"{PDDL}(define (problem c1) (:domain c) (:init {start}) (:goal (q)))\n")
    assert main(["solve", str(file), "-o", str(tmp_path / "plan.json")]) == 2
    said = capsys.readouterr().err
    assert all(f"p.pddl{place}" in said for place in places), said


def test_pks_is_refused_with_both_places(tmp_path, capsys):
    file = tmp_path / "p.xml"
    file.write_text(PKS)
    assert main(["solve", str(file), "-o", str(tmp_path / "plan.json")]) == 2
    said = capsys.readouterr().err
    assert "contradicts" in said and said.count("p.xml:") == 2, said


PKS = """<pks>
<domain name="d">
  <symbols><predicates>p/0, q/0</predicates></symbols>
  <actions><action name="a"><preconds>K(p)</preconds><effects>add(Kf, q);</effects></action></actions>
</domain>
<problem name="p">
  <init>
    add(Kf, p);
    add(Kf, !p);
  </init>
  <goal>K(q)</goal>
</problem>
</pks>
"""
