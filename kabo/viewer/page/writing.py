"""Writes the page: one HTML file that holds the document, its arrays, and all modules, compressed."""

import base64
import gzip
import json
import re
import sys
from collections.abc import Iterator
from html import escape
from importlib.resources import files

from kabo.viewer.content.document import ViewDocument

if sys.version_info >= (3, 11):
    from importlib.resources.abc import Traversable
else:
    from importlib.abc import Traversable

POLICY = "default-src 'none'; script-src 'unsafe-inline' blob:; style-src 'unsafe-inline'; img-src data: blob:"
LIVE_POLICY = "; connect-src 'self'"  # only a page that follows a server or a run asks for anything
SHEETS = ("style.css", "plan.css", "run.css")
THREE = "three"  # the name by which the modules import three.js


def page_of(document: ViewDocument) -> bytes:
    """The page of a view document: the same document gives the same bytes."""
    shown = _read("template.html")
    follows = document.live is not None or (document.run is not None and document.run["live"] is not None)
    policy = POLICY + (LIVE_POLICY if follows else "")
    content = {
        "policy": policy,
        "title": escape(document.title),
        "style": "\n".join(_read(sheet) for sheet in SHEETS),
        "loader": _read("loader.js"),
        "parts": "\n".join(_parts(document)),
    }
    shown = re.sub(r"\{\{(\w+)\}\}", lambda found: content[found[1]], shown)
    return shown.encode("utf-8", "replace")  # halves of characters, which JSON can hold


def _parts(document: ViewDocument) -> Iterator[str]:
    """The elements of the page that hold the modules by the names of their imports, the document and its arrays."""
    yield _part(f"module:{THREE}", _read("static/three.js", "kabo.viewer").encode("utf-8"))
    for name, content in sorted(_modules(files("kabo.viewer.page").joinpath("modules"))):
        yield _part(f"module:kabo/{name}", content)
    text = json.dumps(document.to_json(), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    yield _part("document", text.encode("utf-8", "replace"))
    yield _part("arrays", document.arrays.block)


def _modules(folder: Traversable) -> Iterator[tuple[str, bytes]]:
    """The names and contents of all modules in a folder and those inside it: they import each other by name alone."""
    for each in folder.iterdir():
        if each.is_dir():
            yield from _modules(each)
        elif each.name.endswith(".js"):
            yield each.name, each.read_bytes()


def _part(name: str, content: bytes) -> str:
    packed = base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")
    return f'<script type="text/plain" data-name="{name}">{packed}</script>'


def _read(name: str, package: str = "kabo.viewer.page") -> str:
    return files(package).joinpath(name).read_text(encoding="utf-8")
