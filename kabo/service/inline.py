"""Problems with all their files in one message: the client packs them, a worker unpacks them into its own folder.

A server opens no file merely because a request names it: the files in the message are written into a temporary
folder, and every path is checked to stay inside this folder before a file is opened.
"""

import base64
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from kabo.language import load_problem
from kabo.language.files import files_of
from kabo.service.messages import InlineFile, ProblemFiles, Status, Unreadable

MAX_FILES = 10_000
_PROBLEM = re.compile(r"^problem\s*:|\(\s*define\s*\(\s*problem\b|<problem\b", re.MULTILINE | re.IGNORECASE)


class Forbidden(Exception):
    """A path that leads out of the folder that a request may read."""


def problem_for(path: Path, domain: Path | None = None) -> Callable[[Status], dict[str, Any]]:
    """A function that returns the `problem` of a request for a server with a given status.

    If the problem lies below the root of the server, the result names its path; otherwise it contains all files.

    Raises:
        InputError: the problem is not valid, or one of its files is named by an absolute path and cannot be sent.
    """
    packed = pack_problem(path, domain)
    named = {"path": path} if domain is None else {"path": path, "domain": domain}

    def chosen(status: Status) -> dict[str, Any]:
        root = status.root
        if root is not None and all(each.resolve().is_relative_to(root) for each in named.values()):
            return {key: each.resolve().relative_to(root).as_posix() for key, each in named.items()}
        return packed

    return chosen


def pack_problem(path: Path, domain: Path | None = None) -> dict[str, Any]:
    """The `problem` of a request, with every file that solving reads, by their paths relative to a common folder.

    Raises:
        InputError: the problem is not valid; or a file cannot be sent, because it is named by an absolute path.
    """
    problem = load_problem(path, domain)
    files = sorted({Path(os.path.abspath(file)) for file in files_of(problem)})
    base = Path(os.path.commonpath([file.parent for file in files]))
    packed = {file.relative_to(base).as_posix(): _packed(file) for file in files}
    named = {"path": path} if domain is None else {"path": path, "domain": domain}
    return {key: Path(os.path.abspath(each)).relative_to(base).as_posix() for key, each in named.items()} | {
        "files": packed
    }


def unpack_problem(
    problem: ProblemFiles, folder: Path, between: Callable[[], None] = lambda: None
) -> PurePosixPath:
    """Writes the files of a request into `folder`; returns the path of the problem file relative to `folder`.

    Args:
        between: called before each file; an error that it raises ends the unpacking.

    Raises:
        Forbidden: a name is absolute or leads out of the folder.
        Unreadable: there are too many files, one cannot be written, or it is unclear which one is the problem.
    """
    files = problem.files or {}
    if len(files) > MAX_FILES:
        raise Unreadable(f"`$.problem.files` holds up to {MAX_FILES} files; these are {len(files)}")
    for name, content in files.items():
        between()
        target = folder / safe_name(name)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content.base64 if isinstance(content, InlineFile) else content.encode())
        except OSError as error:  # too long a name, or a file where another needs a folder
            raise Unreadable(f"the file {name!r} of the request cannot be written: {error.strerror}") from None
    return safe_name(_main_file(problem.path, files))


def safe_name(name: str) -> PurePosixPath:
    """Checks a path in a request and returns it as a relative path without `..`.

    Raises:
        Forbidden: the path is absolute or empty, leads out of its folder, or has characters not allowed in file
            names.
    """
    path = PurePosixPath(name)
    if not path.parts or path.is_absolute() or ".." in path.parts or "\\" in name or "\0" in name:
        raise Forbidden(f"the path {name!r} does not stay inside the request's folder")
    return path


def below(root: Path, name: str) -> PurePosixPath:
    """The path of the file `name`, relative to the server's root; symbolic links may not lead out of it.

    Raises:
        Forbidden: the path leads out of the root.
    """
    if not (root / safe_name(name)).resolve().is_relative_to(root.resolve()):
        raise Forbidden(f"the path {name!r} does not lie below the server's root")
    return safe_name(name)


def _main_file(path: str | None, files: Mapping[str, Any]) -> str:
    if path is not None:
        if str(safe_name(path)) not in {str(safe_name(name)) for name in files}:
            raise Unreadable(f"`$.problem.path` {path!r} is not among `$.problem.files`")
        return path
    problems = [name for name, text in files.items() if isinstance(text, str) and _PROBLEM.search(text)]
    if len(problems) != 1:
        raise Unreadable(f"`$.problem.path` is needed: {len(problems)} of the files look like a problem")
    return problems[0]


def _packed(path: Path) -> str | dict[str, str]:
    content = path.read_bytes()
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        text = None
    if text is None or text.encode() != content:
        return {"base64": base64.b64encode(content).decode("ascii")}
    return text
