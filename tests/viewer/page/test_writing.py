"""The page: one file, the same bytes each time, that names nothing outside of itself."""

import base64
import gzip
import re

import numpy as np

from kabo.viewer import Arrays, ViewDocument, page_of


def document(title: str = "a scene") -> ViewDocument:
    arrays = Arrays()
    arrays.add(np.arange(5, dtype=np.uint16))
    return ViewDocument(title, "scene", arrays=arrays)


def part(page: str, name: str) -> bytes:
    found = re.search(rf'data-name="{re.escape(name)}">([^<]*)<', page)
    assert found is not None
    return gzip.decompress(base64.b64decode(found[1]))


def test_the_same_document_gives_the_same_bytes():
    assert page_of(document()) == page_of(document())


def test_all_that_a_page_needs_is_in_it():
    page = page_of(document()).decode()
    assert "REVISION" in part(page, "module:three").decode()
    assert 'from "kabo/stage.js"' in part(page, "module:kabo/main.js").decode()
    assert part(page, "arrays") == document().arrays.block
    assert not re.findall(r"<(?:link|img|script src|iframe)", page)
    assert "connect-src" not in page
    assert "default-src 'none'" in page


def test_a_title_is_text_and_no_markup():
    page = page_of(document("<script>alert(1)</script>{{parts}}")).decode()
    assert page.count('data-name="document"') == 1
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)" in page
