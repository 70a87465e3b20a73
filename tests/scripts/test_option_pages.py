"""The pages of docs/ that say what a solve can be told say what the table of options says."""

import pytest

from scripts.option_pages import PAGES, renewed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_is_what_the_script_writes(page):
    assert renewed(page) == page.read_text(), f"python -m scripts.option_pages writes {page.name}"
