"""The documentation builds to a site without a warning, which opens from disk and needs nothing else."""

import re
from pathlib import Path

import pytest

from scripts.site import build

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built with every warning an error."""
    folder = tmp_path_factory.mktemp("site") / "site"
    assert build(folder) == 0
    return folder


def test_the_sidebar_has_every_section_of_the_index_in_its_order(site):
    index = (Path(__file__).parents[2] / "docs" / "index.md").read_text()
    page = (site / "docs" / "index.html").read_text()
    captions = re.findall(r'<p class="caption"[^>]*><span class="caption-text">([^<]*)<', page)
    assert captions[: len(captions)] == re.findall(r"^## (.*)$", index, flags=re.MULTILINE)


def test_pages_load_nothing_from_other_places_and_the_search_is_a_file_beside_them(site):
    for page in site.rglob("*.html"):
        loaded = re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="([^"]+)"', page.read_text())
        assert not [address for address in loaded if re.match(r"(https?:)?//", address)], page
    assert "bounding" in (site / "searchindex.js").read_text()


def test_the_same_pages_give_the_same_site_and_pages_of_the_viewer_are_led_to(site, tmp_path):
    again = tmp_path / "site"
    pages_of_the_viewer = tmp_path / "pages"
    pages_of_the_viewer.mkdir()
    (pages_of_the_viewer / "domains-stacked.html").write_text("<!DOCTYPE html>\n")
    assert build(again, pages_of_the_viewer) == 0
    stacked = Path("domains/stacked/README.html")
    assert '<a href="../../pages/domains-stacked.html">' in (again / stacked).read_text()
    assert (again / "pages" / "domains-stacked.html").exists()
    pages = {path.relative_to(site): path.read_bytes() for path in site.rglob("*.html")}
    assert [path for path, text in pages.items() if (again / path).read_bytes() != text] == [stacked]
