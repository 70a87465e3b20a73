"""What a command line may hold, as data for the scripts of all shells: commands, options, choices, kinds of files."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kabo.cli.argument_types import output_file
from kabo.cli.usage import commands_of

YAML, PROBLEM = ("yaml", "yml"), ("yaml", "yml", "pddl", "xml", "pks")
MESH = ("stl", "obj", "ply", "off", "dae", "glb")
# The endings of files that an argument expects: by the name of its attribute, else by what the help calls it. None
# beside the path types: any file.
ENDINGS: dict[str, tuple[str, ...]] = {
    "files": (*PROBLEM, "jsonl"),
    "scene": YAML,
    "srdf": ("srdf",),
    "stages": ("py",),
    "urdf": ("urdf", "xacro"),
    "mesh": MESH,
    "plan": ("json",),
    "problem": PROBLEM,
    "report": ("json",),
    "known": ("json",),
    "model": ("jsonl",),
    "first": ("json",),
    "second": ("json",),
    "html": ("html",),
    "picture": ("png",),
    "config": ("json5", "json"),
    "log": ("jsonl", "log"),
    "file": (*YAML, "json"),
    "what": (*PROBLEM, "json", *MESH),
}
FOLDERS = ("FOLDER",)


@dataclass(frozen=True)
class Value:
    """What a value may be: one of `words`, a file with one of `endings` (empty: any file), a folder, or anything."""

    name: str
    words: tuple[str, ...] = ()
    endings: tuple[str, ...] | None = None  # None: no file
    folder: bool = False


@dataclass(frozen=True)
class Option:
    """An option with all its names, and its value, if it takes one; `again`: it may be given several times."""

    names: tuple[str, ...]
    help: str
    value: Value | None
    again: bool


@dataclass(frozen=True)
class Command:
    """A command by its words (`task`, `plan`), with its options, its values in order, and the commands within it."""

    path: tuple[str, ...]
    help: str
    options: tuple[Option, ...]
    values: tuple[tuple[Value, bool], ...]  # whether any number of them may follow
    inner: tuple["Command", ...]

    def all(self) -> Iterator["Command"]:
        """This command, and all within it."""
        yield self
        for command in self.inner:
            yield from command.all()


def tree_of(parser: argparse.ArgumentParser, path: tuple[str, ...] = (), help: str = "") -> Command:
    """What the command lines of a parser may hold."""
    options, values = [], []
    for action in parser._actions:
        if action.option_strings:
            takes = None if action.nargs == 0 else _value(action)
            again = isinstance(action, (argparse._AppendAction, argparse._ExtendAction, argparse._CountAction))
            options.append(Option(tuple(action.option_strings), _plain(action.help), takes, again))
        elif not isinstance(action, argparse._SubParsersAction):
            values.append((_value(action), action.nargs in ("+", "*")))
    helps = _helps(parser)
    inner = tuple(tree_of(own, (*path, name), helps.get(name, "")) for name, own in commands_of(parser).items())
    return Command(path, help, tuple(options), tuple(values), inner)


def _helps(parser: argparse.ArgumentParser) -> dict[str, str]:
    """The help of each command of a parser."""
    groups = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    return {choice.dest: _plain(choice.help) for group in groups for choice in group._choices_actions}


def _plain(text: str | None) -> str:
    """The help of an option as a short line."""
    said = "" if text in (None, argparse.SUPPRESS) else str(text).replace("%%", "%")
    return " ".join(said.split("(default")[0].split()).rstrip(";:, ")


def _value(action: argparse.Action) -> Value:
    name = str(action.metavar or action.dest)
    if action.choices is not None:
        return Value(name, words=tuple(map(str, action.choices)))
    if name in FOLDERS:
        return Value(name, folder=True)
    if action.dest in ENDINGS and (action.type is not None or action.dest in ("urdf", "srdf")):
        return Value(name, endings=ENDINGS[action.dest])
    if action.type in (Path, output_file) or name in ("FILE", "OUT", "PNG"):
        return Value(name, endings=())
    return Value(name)
