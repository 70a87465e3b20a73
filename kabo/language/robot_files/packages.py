"""The folder of a ROS package that a file names as `package://NAME/…`.

It is looked for where a scene says (`packages:`), beside the file that names it (a folder above it with this name, or
one with a `package.xml` of this name), then in ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
"""

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

SCHEME = "package://"
_MAX_PARENTS = 8  # folders above a file that are looked into
_PACKAGE_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_MAX_MANIFEST_BYTES = 100_000


def package_folder(name: str, packages: Mapping[str, Path], beside: Path) -> Path | None:
    """The folder of the package `name`; None if it is nowhere.

    Args:
        name: the package's name.
        packages: folders that a scene declares; they win.
        beside: the file that names the package.
    """
    if name in packages:
        return packages[name]
    if not name or name in (".", "..") or "\0" in name:
        return None
    return next((folder for folder in _candidates(name, beside) if _is_folder(folder)), None)


def known_packages(packages: Mapping[str, Path], beside: Path) -> list[str]:
    """The names of packages that a scene declares, and of folders around a file: what may have been meant."""
    around = [parent.name for parent in list(beside.absolute().parents)[:_MAX_PARENTS]]
    return sorted({*packages, *(name for name in around if name)})


def searched_places() -> str:
    """Where packages are looked for, for messages."""
    return "`packages:` of the scene, the folders above the file, ROS_PACKAGE_PATH, AMENT_PREFIX_PATH"


def _candidates(name: str, beside: Path) -> Iterator[Path]:
    parents = list(beside.absolute().parents)[:_MAX_PARENTS]
    for parent in parents:
        if parent.name == name or _manifest_name(parent) == name:
            yield parent
    for parent in parents[:-1]:
        yield parent / name
    for folder in _listed("ROS_PACKAGE_PATH"):
        if folder.name == name:
            yield folder
        yield folder / name
    for folder in _listed("AMENT_PREFIX_PATH"):
        yield folder / "share" / name


def _listed(variable: str) -> list[Path]:
    return [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each]


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):  # too long a name
        return False


def _manifest_name(folder: Path) -> str | None:
    """The name in the folder's `package.xml`; None without one."""
    path = folder / "package.xml"
    try:
        if not path.is_file() or path.stat().st_size > _MAX_MANIFEST_BYTES:
            return None
        found = _PACKAGE_NAME.search(path.read_bytes())
    except OSError:
        return None
    return None if found is None else found.group(1).decode("utf-8", "replace")
