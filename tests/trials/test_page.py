"""The page of an exploration: self-contained, well-formed, with all numbers, for every number of parameters."""

import re
from html.parser import HTMLParser

import pytest

from kabo.exploration import Exploration, Space
from kabo.trials import exploration_page, summaries_of
from tests.support.discs import explored

VOID = {"meta"}


class Reader(HTMLParser):
    """Checks that every element is closed, and keeps what stands in the page."""

    def __init__(self):
        super().__init__()
        self.open, self.found, self.words = [], [], []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(page):
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


@pytest.mark.parametrize(("names", "figures"), [(("a",), 2), (("a", "b"), 2), (("a", "b", "c"), 6)])
def test_a_page_has_a_figure_of_validity_and_of_each_outcome(names, figures):
    page = exploration_page(explored(40, names), "m.jsonl")
    reader = read(page)
    assert page.startswith("<!DOCTYPE html>") and "nan" not in page
    assert [tag for tag, _ in reader.found].count("figure") == figures
    assert "ball" in reader.words and any("m.jsonl" in each for each in reader.words)


def test_a_page_needs_nothing_else_and_runs_nothing():
    page = exploration_page(explored(20), "m.jsonl")
    reader = read(page)
    assert not {tag for tag, _ in reader.found} & {"script", "link", "iframe"}
    references = [value for _, given in reader.found for key, value in given.items() if key in ("href", "src")]
    assert references and all(each.startswith("data:image/png;base64,") for each in references)
    assert "http" not in page and "url(" not in page


def test_a_page_tells_every_trial_and_every_number_of_the_summary():
    made = explored(50)
    page = exploration_page(made, "m.jsonl")
    (summary,) = summaries_of(made)
    titles = re.findall("<title>(.*?)</title>", page)
    assert len(titles) == 1 + len(made.trials) + summary.valid  # the page's own; valid trials stand in both maps
    for reason, count in summary.reasons.items():
        assert f"{count} {reason}" in page
        assert sum(each.endswith(f": {reason}") for each in titles) == count
    for value in (summary.outcomes["torque"].lowest, summary.outcomes["torque"].highest):
        assert f">{value:.4g}</td>" in page


def test_a_page_serves_light_and_dark_readers():
    page = exploration_page(explored(10), "m.jsonl")
    assert "color-scheme: light dark" in page and "prefers-color-scheme: dark" in page
    assert set(re.findall(r"var\(--(\w+)\)", page)) <= set(re.findall(r"--(\w+):", page))


def test_a_page_of_many_cases_shows_those_with_trials():
    space = Space({"a": (0.0, 1.0), "b": (0.0, 1.0)}, {"k": [f"k{i}" for i in range(30)]})
    made = Exploration(space, ["x"])
    made.tell({"k": "k3"}, {"a": 0.5, "b": 0.5}, True, {"x": 1.0})
    made.tell({"k": "k7"}, {"a": 0.5, "b": 0.5}, False)
    page = exploration_page(made, "m.jsonl")
    read(page)
    assert page.count("<details") == 2 and "28 cases without trials" in page and "1 no reason given" in page


def test_a_page_without_trials_and_with_equal_outcomes_can_be_made():
    empty = Exploration(Space({"a": (0.0, 1.0)}), ["x"])
    assert "1 case without trials" in exploration_page(empty, "m.jsonl")
    for value in (0.0, 1e100, -1e-300):
        made = Exploration(Space({"a": (-1e-9, 1e9), "b": (5.0, 6.0)}), ["x"])
        for k in range(3):
            made.tell({}, {"a": 0.1 * k, "b": 5.5}, True, {"x": value})
        read(exploration_page(made, "m.jsonl"))


def test_names_cannot_break_out_of_the_page():
    bad = "<b>&\"'</title>"
    made = Exploration(Space({bad: (0.0, 1.0)}, {bad: [bad]}, {bad: bad}), [bad], name=bad, units={bad: bad})
    made.tell({bad: bad}, {bad: 0.5}, True, {bad: 1.0})
    made.tell({bad: bad}, {bad: 0.9}, False, reason=bad)
    reader = read(exploration_page(made, bad))
    assert bad in reader.words
    assert "<b>&" not in exploration_page(made, bad)


def test_the_same_model_makes_the_same_page():
    assert exploration_page(explored(15), "m.jsonl") == exploration_page(explored(15), "m.jsonl")
