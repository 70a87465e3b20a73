"""The site: Sphinx with furo and myst, over the Markdown pages as they are (docs/decisions/038-documentation.md).

    python -m scripts.site

The source folder is the repository, so that links from a page to a domain, a script or a picture are the same here and
on a code host. The contents of the sidebar are the links of the index pages: no page says anything for Sphinx alone.
"""

import re
from pathlib import Path

from sphinx.application import Sphinx

REPOSITORY = Path(__file__).resolve().parent.parent
#: Pages whose links are the contents of the site, in this order.
INDEX_PAGES = ("docs/index", "docs/decisions/README")

project = "kabo"
author = "the authors of kabo"
extensions = ["myst_parser", "sphinx_copybutton"]
root_doc = "docs/index"
include_patterns = [
    "*.md",
    "docs/**",
    "domains/*/README.md",
    "examples/README.md",
    "examples/*/README.md",
    "benchmarks/README.md",
]
exclude_patterns = [".*", "**/.*", "build", "dist", "kabo", "meshes", "scripts", "tests"]
suppress_warnings = ["toc.not_included"]  # tests/documentation/test_index.py says which pages must be reached
myst_heading_anchors = 4
html_theme = "furo"
html_title = "kabo"
html_static_path = ["theme"]
html_css_files = ["tables.css"]
html_extra_path = ["front"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_last_updated_fmt = None
html_show_search_summary = False  # it fetches pages, which a browser refuses from disk
copybutton_selector = "div.highlight-sh pre, div.highlight-python pre, div.highlight-yaml pre"


def contents(text: str, folder: Path) -> str:
    """The links of an index page as hidden tables of contents, one for each of its sections."""
    made = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        caption = section.splitlines()[0]
        links = re.findall(r"^[-|] *\[[^\]]*\]\(([^)#:]+\.md)\)", section, flags=re.MULTILINE)
        pages = [(folder / link).resolve().relative_to(REPOSITORY).with_suffix("").as_posix() for link in links]
        if pages:
            lines = "\n".join(f"/{page}" for page in pages)
            made.append(f"```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{lines}\n```\n")
    return "\n".join(made)


def add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Adds the tables of contents to the text of an index page, before it is parsed."""
    if page in INDEX_PAGES:
        source[0] += "\n" + contents(source[0], (REPOSITORY / page).parent)


def add_page(app: Sphinx, page: str, source: list[str]) -> None:
    """Leads from the page of a domain or example to the viewer's page of its plan, below the heading."""
    name = page.removesuffix("/README").replace("/", "-") + ".html"
    if app.config.viewer_pages and (Path(app.config.viewer_pages) / name).exists():
        heading, _, rest = source[0].partition("\n")
        up = "../" * page.count("/")
        source[0] = f'{heading}\n\n<p><a href="{up}pages/{name}">Play the plan in your browser</a></p>\n{rest}'


def add_levels(app: Sphinx, page: str, template: str, context: dict[str, object], doctree: object) -> None:
    """Says of the captions in the sidebar which level of heading they are, for those who hear them."""
    for key in ("furo_navigation_tree", "toctree"):
        if isinstance(tree := context.get(key), str):
            context[key] = tree.replace('role="heading"', 'role="heading" aria-level="2"')


def setup(app: Sphinx) -> dict[str, bool]:
    """Connects what this file adds to Sphinx."""
    app.add_config_value("viewer_pages", "", "html", str)
    app.connect("source-read", add_contents)
    app.connect("source-read", add_page)
    app.connect("html-page-context", add_levels, priority=900)  # after the theme has made the sidebar
    return {"parallel_read_safe": True, "parallel_write_safe": True}
