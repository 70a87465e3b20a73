"""The page in Python: `view` writes and opens it, and notebooks show it in a frame."""

import os
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from types import NoneType

from kabo.displays import frame
from kabo.errors import InputError
from kabo.given import missing_file, require_given, require_output, require_path
from kabo.language.problem import Problem
from kabo.viewer.content.given import ViewOptions, document_of_file
from kabo.viewer.content.objects import Viewable, document_of
from kabo.viewer.page.writing import page_of
from kabo.whole_files import write_atomically


@dataclass(frozen=True)
class Page:
    """A page of the viewer: one HTML file that needs no server and no network; `path` is where it was written."""

    html: bytes
    path: Path | None = None

    def save(self, path: str | Path) -> None:
        """Writes the page, completely or not at all.

        Raises:
            InputError: `path` is no file in a folder that exists.
            OSError: the file cannot be written.
        """
        write_atomically(require_output("path", path), self.html)

    def __repr__(self) -> str:
        return f"<Page {'in memory' if self.path is None else self.path}: {len(self.html) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return frame(self.html.decode("utf-8"))


def view(
    thing: Viewable | str | Path,
    path: str | Path | None = None,
    *,
    problem: Problem | None = None,
    open: bool | None = None,
) -> Page:
    """The page that shows a thing, as `kabo view` writes it; a notebook shows it inline.

    Args:
        thing: a scene, problem, result, plan, task report, explanation or mesh; or the path of a file of such a kind.
        path: where to write the page; None: nowhere, or in a temporary folder if it is opened.
        problem: the problem of a plan, which knows its name only; without it, a plan is shown without its scene.
        open: whether to open the page in a browser; None: unless this is a notebook.

    Raises:
        ArgumentError: an argument is of a wrong kind, or there is nothing to show: no plan in a result, no scene in a
            problem.
        InputError: the files of the thing have errors, or its meshes do not load.
        OSError: a file cannot be written.

    Example:
        >>> result = kabo.solve(kabo.load_problem("domains/grid/n3.yaml"))
        >>> kabo.view(result, "plan.html", open=False)
        <Page plan.html: ... MB>
    """
    require_given("problem", problem, Problem, NoneType)
    path = None if path is None else require_output("path", path)
    if isinstance(thing, str | Path):
        named = None if problem is None else problem.path
        file = require_path("thing", thing)
        if not os.path.exists(file):  # False for too long a name, too
            raise InputError([missing_file(file)])
        document = document_of_file(file, ViewOptions(problem=named))
    else:
        document = document_of(thing, problem)
    html = page_of(document)
    wanted = not _in_notebook() if open is None else open
    if path is None and wanted:
        path = Path(tempfile.mkdtemp(prefix="kabo-")) / "page.html"
    page = Page(html, path)
    if page.path is not None:
        page.save(page.path)
        if wanted:
            webbrowser.open(page.path.resolve().as_uri())
    return page


def notebook_page(thing: Viewable) -> str | None:
    """The page of a thing that a notebook displays, without what takes seconds; None if no page can be made of it."""
    try:
        return page_of(document_of(thing, whole=False)).decode("utf-8")
    except (InputError, ValueError, OSError):
        return None


def _in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    shell = sys.modules.get("IPython")
    running = None if shell is None else shell.get_ipython()
    return running is not None and hasattr(running, "kernel")
