"""Paths in files: relative to the file that names them, or `package://NAME/…` [docs/reference/files.md#rules].

`packages: {NAME: installed}` refers to the folder `share/NAME` of an installed Python package, such as
example-robot-data, which the extra `robots` installs.
"""

from collections.abc import Mapping
from pathlib import Path

from kabo.language.recorded_paths import installed_folder
from kabo.language.source import OUTSIDE, beside, lies_within, missing_file_reason
from kabo.language.yaml.documents import YamlNode
from kabo.language.yaml.values import Reader

INSTALLED = "installed"
XACRO = ".xacro"  # such files are programs: they are expanded for users, not for whoever asks a server
_SCHEME = "package://"


def read_packages(reader: Reader, node: YamlNode | None) -> dict[str, Path]:
    """The folders of `packages: {NAME: folder}`; for the value `installed`, the folder of the installed package NAME."""
    packages: dict[str, Path] = {}
    for name, _, value in reader.entries(node, "the packages"):
        text = reader.text(value, "a folder")
        if text is None:
            continue
        if text == INSTALLED:
            found = installed_folder(name)
            if found is None:
                hint = "the robots of example-robot-data come with pip install 'kabo[robots]'"
                reader.findings.add(value.place, f'package "{name}" is not installed', hint)
            elif lies_within(found, reader.within):
                packages[name] = found
            else:
                reader.findings.add(value.place, f'package "{name}": {OUTSIDE}')
            continue
        folder = Path(beside(str(value.source.path.parent), text))
        if "\0" in text or not lies_within(folder, reader.within) or not folder.is_dir():
            reader.findings.add(value.place, f'package "{name}": there is no folder "{text}"')
        packages[name] = folder
    return packages


def read_file_path(reader: Reader, node: YamlNode | None, what: str, packages: Mapping[str, Path]) -> Path | None:
    """The path of a file; if the file does not exist, this is reported and the path is returned nevertheless."""
    text = reader.text(node, what)
    if text is None or node is None:
        return None
    if text.startswith(_SCHEME):
        package, _, rest = text[len(_SCHEME) :].partition("/")
        if package not in packages:
            folder = INSTALLED if installed_folder(package) is not None else "folder"
            hint = reader.findings.near(package, packages) or f"declare it: packages: {{{package}: {folder}}}"
            reader.findings.add(node.place, f'unknown package "{package}"', hint)
            return None
        path = Path(beside(str(packages[package]), rest))
    else:
        path = Path(beside(str(node.source.path.parent), text))
    reason = missing_file_reason(path) if lies_within(path, reader.within) else OUTSIDE
    if reason is None and reader.within is not None and path.suffix.lower() == XACRO:
        reader.findings.add(
            node.place, f'{what} "{text}": a server expands no xacro files', "send what xacro makes of it"
        )
        return path
    if reason is not None:
        hint = reader.findings.near_file(path, reader.within) or f"looked for {path}"
        reader.findings.add(node.place, f'{what} "{text}": {reason}', hint)
    return path
