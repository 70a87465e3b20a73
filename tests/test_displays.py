"""What notebooks show: figures that are escaped and bounded, and a page in a frame."""

import html
import re

from kabo.displays import MAX_CELL_CHARACTERS, MAX_LISTED, MAX_PAGE_CHARACTERS, bullets, counted, display, frame

NASTY = "<script>alert('x')</script> & \"more\""


def test_names_and_values_are_text_and_never_markup():
    shown = display(NASTY, {NASTY: NASTY}) + bullets([NASTY], NASTY)
    assert "<script" not in shown and shown.count(html.escape(NASTY)) == 5


def test_a_figure_without_a_value_has_no_row():
    assert "lacks" not in display("a", {"lacks": "", "has": "this"})


def test_what_is_long_is_cut():
    shown = display("a", {"": "ß" * 10_000}) + bullets("y" for _ in range(1_000))
    assert len(re.findall("ß", shown)) <= MAX_CELL_CHARACTERS
    assert shown.count("<li>") == MAX_LISTED + 1 and "and 980 more" in shown


def test_a_page_stands_in_a_frame_as_it_was_written():
    page = f'<!doctype html><p title="a\'b">{NASTY}</p>'
    framed = frame(page)
    (source,) = re.findall(r'srcdoc="([^"]*)"', framed)
    assert html.unescape(source) == page


def test_a_page_that_is_too_large_for_a_notebook_is_not_put_into_it():
    shown = frame("x" * (MAX_PAGE_CHARACTERS + 1))
    assert "iframe" not in shown and "kabo.view" in shown and len(shown) < 300


def test_one_thing_and_several():
    assert [counted(1, "body", "bodies"), counted(2, "body", "bodies"), counted(0, "node")] == [
        "1 body",
        "2 bodies",
        "0 nodes",
    ]
