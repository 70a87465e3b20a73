"""How plans name the files that they were made from [docs/reference/plans.md#the-plan-file].

A path from the problem's folder says where a file lies that moves along with the problem. Where an installed package
lies depends on the machine, not on the problem: its files are named `package://NAME/…`, so that a plan has the same
bytes and is verified in any folder and on any machine.
"""

import os
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from pathlib import Path

from kabo.language.robot_files.packages import SCHEME


def recorded_files(files: Iterable[tuple[Path | str, str]], folder: Path) -> dict[str, str]:
    """The hashes of files by their names in a plan.

    A name is the path from a folder, with forward slashes, or `package://NAME/…` if the file is of an installed package.

    Args:
        files: each with its hash.
        folder: that of the problem, or of the scene if there is no problem.
    """
    start = folder.resolve()
    shares = [share for share in (each.resolve() for each in _shares()) if not start.is_relative_to(share)]
    return {_named(Path(path).resolve(), start, shares): digest for path, digest in files}


def file_of(name: str, folder: Path) -> Path:
    """Where a file is now that a plan names; the opposite of `recorded_files`."""
    if not name.startswith(SCHEME):
        return folder / name
    package, _, rest = name.removeprefix(SCHEME).partition("/")
    return (installed_folder(package) or folder / package) / rest


def _named(path: Path, start: Path, shares: Sequence[Path]) -> str:
    for share in shares:
        if path.is_relative_to(share):
            return SCHEME + path.relative_to(share).as_posix()
    return Path(os.path.relpath(path, start)).as_posix()


def installed_folder(name: str) -> Path | None:
    """The folder `share/NAME` beside the installed Python packages; None if there is none."""
    if not name or name in (".", "..") or "/" in name or "\0" in name:
        return None
    return next((share / name for share in _shares() if (share / name).is_dir()), None)


def _shares() -> tuple[Path, ...]:
    """The folders `share` of installed Python packages."""
    roots = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix", Path(sys.prefix)
    return tuple(root / "share" for root in roots)
