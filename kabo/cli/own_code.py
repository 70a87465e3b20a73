"""A user's own code on the command line: Python files that register stages or trials. Errors are told at their lines."""

import argparse
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from kabo.errors import Diagnostic, InputError, KaboError


def add_stages_argument(parser: argparse.ArgumentParser) -> None:
    """Adds the argument for Python files with user-defined stages or trials."""
    parser.add_argument(
        "--stages",
        type=Path,
        action="append",
        default=[],
        metavar="FILE.py",
        help="Python files that register stages, or trials, of your own; they are executed",
    )


def execute(paths: Sequence[Path]) -> None:
    """Executes Python files, which register their stages or trials.

    Raises:
        InputError: a file raised an error; the message gives the line of the file.
    """
    for path in paths:
        spec = spec_from_file_location(path.stem, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise InputError([Diagnostic(str(path), 1, 1, "this is no Python file")])
        module = module_from_spec(spec)
        with blamed([path]):
            spec.loader.exec_module(module)


@contextmanager
def blamed(paths: Sequence[Path]) -> Iterator[None]:
    """A context that reports an error raised in one of `paths` as a finding at its line, not as a defect of kabo.

    Raises:
        InputError: an error was raised in one of the files, or passed through it.
    """
    try:
        yield
    except Exception as error:
        # Of kabo's own errors only those for misuse, which are ValueErrors too, can be the fault of the file.
        own = isinstance(error, KaboError) and not isinstance(error, ValueError)
        place = None if own else _place(error, paths)
        if place is None:
            raise
        path, line = place
        raise InputError([Diagnostic(str(path), line, 1, f"{type(error).__name__}: {error}")]) from error


def _place(error: Exception, paths: Sequence[Path]) -> tuple[Path, int] | None:
    """The last line of one of the files that an error passed through; None if there is none."""
    known = {path.resolve(): path for path in paths}
    if isinstance(error, SyntaxError) and error.filename is not None and Path(error.filename).resolve() in known:
        return known[Path(error.filename).resolve()], error.lineno or 1
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        path = known.get(Path(frame.filename).resolve())
        if path is not None:
            return path, frame.lineno or 1
    return None
