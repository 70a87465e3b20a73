"""The families without a scene: every generated problem loads, and is as large as its README says."""

import re

import pytest

from benchmarks.knowledge_sizes import Sizes, sizes
from kabo.errors import InputError
from tests.domains.families import FAMILIES, generated, rule
from tests.domains.scenes import DOMAINS

ROW = re.compile(r"\| ([\w -]+) \| `--n (\d+)((?: --set \w+=\w+)*)` \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|")


def _value(text: str) -> int | bool:
    return text == "true" if text in ("true", "false") else int(text)


def _rows():
    for family in FAMILIES:
        for name, n, more, *counts in ROW.findall((DOMAINS / family / "README.md").read_text()):
            settings = {key: _value(value) for key, value in re.findall(r"--set (\w+)=(\w+)", more)}
            yield pytest.param(family, {"n": int(n), **settings}, Sizes(*map(int, counts)), id=name)


ROWS = list(_rows())


def test_every_family_has_a_table():
    assert {row.values[0] for row in ROWS} == set(FAMILIES)
    assert len(FAMILIES) == 16


@pytest.mark.parametrize(("family", "settings", "counts"), ROWS)
def test_an_instance_is_as_large_as_the_readme_says(tmp_path, family, settings, counts):
    assert sizes(generated(tmp_path, family, **settings)) == counts


@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_too_small_is_refused_in_words(family):
    with pytest.raises(InputError, match="or more|1 to"):
        rule(family)(0)


@pytest.mark.parametrize(
    ("family", "settings"),
    [
        ("bomb_in_the_toilet", {"n": 2, "toilets": 3}),
        ("btcs", {"n": 4, "toilets": 0}),
        ("coloured_balls", {"n": 4, "balls": 0}),
        ("grid", {"n": 3, "shapes": 4}),
        ("logistics", {"n": 3, "wide": 4}),
        ("elogistics", {"n": 3, "offices": 0}),
        ("rovers", {"n": 4, "rovers": 0}),
        ("safes", {"n": 3, "safes": 0}),
        ("unix", {"n": 10}),
    ],
)
def test_settings_that_make_no_sense_are_refused(family, settings):
    with pytest.raises(InputError, match="not"):
        rule(family)(**settings)


def test_sizes_count_what_is_uncertain_and_what_can_be_sensed(tmp_path):
    (tmp_path / "domain.yaml").write_text(
        """\
domain: small
types: [box]
predicates: {red: [box], seen: [box], next: [box, box]}
functions: {lid: {arguments: [box], value: [on, off]}}
actions:
  look: {parameters: {b: box, c: box}, preconditions: ["K(next(b, c))", "K(not seen(b))"], sense: red(b)}
  shake: {parameters: {b: box}, sense: lid(b)}
  mark: {parameters: {b: box}, effects: ["when lid(b) = on then seen(b)"]}
"""
    )
    (tmp_path / "p.yaml").write_text(
        """\
problem: p
objects: {box: [a, b, c]}
initial:
  - add(Kf, next(a, b), next(b, c), red(a), lid(c) = on)
  - add(Kx, red(b), red(c))
goal: Kw(red(b))
"""
    )
    import kabo

    # red(b), red(c) and two values for each of lid(a), lid(b); look at a and b, shake any of three
    assert sizes(kabo.load_problem(tmp_path / "p.yaml")) == Sizes(3, 6, 5, 8)
