"""S-expressions: shape, places, and what is refused."""

import pytest

from kabo.language.findings import Findings
from kabo.language.pddl.forms import MAX_DEPTH, Form, read_forms
from kabo.language.source import SourceFile
from tests.support.counted_calls import calls_made


def forms(text: str):
    """The document of a text and its findings."""
    findings = Findings()
    return read_forms(SourceFile(None, "file.pddl", text), findings), findings.diagnostics


def plain(node):
    """A form as nested lists of words."""
    return [plain(item) for item in node.items] if isinstance(node, Form) else node.text


def test_words_are_in_lower_case_and_comments_are_left_out():
    document, found = forms("; (not this\n(Define (a B-1) ?X 1.5e3) ; nor this (")
    assert not found
    assert [plain(form) for form in document.forms] == [["define", ["a", "b-1"], "?x", "1.5e3"]]


def test_places_count_lines_and_columns_from_one():
    document, _ = forms("(a\r\n  (b cc))")
    word = document.forms[0].items[1].items[1]
    place = document.place(word)
    assert (place.line, place.column, place.length) == (2, 6, 2)
    assert document.text(document.forms[0]) == "(a (b cc))"


@pytest.mark.parametrize(
    ("text", "message", "line", "column"),
    [
        ("", 'the file is empty, expected "(define …"', 1, 1),
        (";;;", 'the file is empty, expected "(define …"', 1, 1),
        ("define", 'unexpected "define", expected "(define …"', 1, 1),
        ("(a\n (b)", "this parenthesis is never closed", 1, 1),
        ("(a\n (b (c)", "this parenthesis is never closed", 2, 2),
        ("(a))", 'unexpected ")": no parenthesis is open here', 1, 4),
        (
            "(" * (MAX_DEPTH + 1),
            f"the file is refused here: nested deeper than {MAX_DEPTH} levels",
            1,
            MAX_DEPTH + 1,
        ),
    ],
)
def test_a_text_of_another_shape_is_refused_with_its_place(text, message, line, column):
    document, found = forms(text)
    assert document is None
    assert [(each.message, each.line, each.column) for each in found] == [(message, line, column)]


@pytest.mark.parametrize(
    "text", ["(" * 3_000_000, ")" * 3_000_000, "(a)" * 300_000, "\0" * 1_000_000, "(a " * 10_000]
)
def test_large_and_deep_texts_are_answered_in_calls_that_grow_no_faster_than_the_text(text):
    assert calls_made(lambda: forms(text), of_c=True) < 6 * len(text)
