"""Wrong command lines: one line that says what is wrong, what was meant perhaps, and where help is."""

import argparse
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn

from kabo.errors import did_you_mean

PLAIN = {
    "help": "--help",
    "version": "--version",
    "completion": "--completion",
}  # what other programs call commands
MEANT = {"plan": "solve"}  # a command within one, of which somebody may think otherwise
NEGATIVE = re.compile(r"-\.?\d")  # how a value begins; no option does
# What argparse says (in Python 3.10 to 3.14), and what kabo says instead.
PHRASES: tuple[tuple[str, Callable[[re.Match[str]], str]], ...] = (
    (r"the following arguments are required: (.*)", lambda found: _missing(found[1].split(", "))),
    (r"one of the arguments (.*) is required", lambda found: f"one of {_listed(found[1].split())} is missing"),
    (r"argument (\S+): expected one argument", lambda found: f"{_name(found[1])} needs a value"),
    (r"argument (\S+): expected at least one argument", lambda found: f"{_name(found[1])} needs a value"),
    (
        r"argument (\S+): not allowed with argument (\S+)",
        lambda found: f"{found[1]} and {found[2]} exclude each other",
    ),
    (
        r"argument (\S+): ignored explicit argument '(.*)'",
        lambda found: f'{_name(found[1])} takes no value, not "{found[2]}"',
    ),
    (
        r"ambiguous option: (\S+) could match (.*)",
        lambda found: f"{found[1]} may mean {_listed(found[2].split(', '), 'or')}",
    ),
    (r"argument (\S+): (.*)", lambda found: f"{_name(found[1])}: {found[2]}"),
)


class UsageError(Exception):
    """A command line that cannot be read: `prog` is the command that was meant, such as `kabo task plan`."""

    def __init__(self, prog: str, message: str, hint: str | None = None) -> None:
        self.prog = prog
        if message.endswith("?"):
            super().__init__(message)
        else:
            super().__init__(f"{message}; {hint or f'see `{prog} --help`'}")

    def __str__(self) -> str:
        """The one line that is shown."""
        return f"{self.prog}: {self.args[0]}"


class UnknownCommand(UsageError):
    """A command that does not exist; `word` is what stands in its place."""

    word: str


class CommandParser(argparse.ArgumentParser):
    """A parser that raises its errors, so that `main` reports them, as JSON where that is asked for.

    A word that begins with a negative number is a value (`--to -0.5,0.3`), as of Python 3.14.
    """

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._negative_number_matcher = NEGATIVE

    def error(self, message: str) -> NoReturn:
        """Raises UsageError."""
        text = " ".join(message.split())
        for pattern, said in PHRASES:
            if (found := re.fullmatch(pattern, text)) is not None:
                raise UsageError(self.prog, said(found))
        raise UsageError(self.prog, text)

    def _check_value(self, action: argparse.Action, value: object) -> None:
        """Raises UsageError for a value that is none of an action's choices: argparse would list them all."""
        known = [str(each) for each in action.choices or ()]
        if action.choices is None or value in action.choices:
            return
        if isinstance(action, argparse._SubParsersAction):
            raise _unknown_command(self, str(value), action)
        near = did_you_mean(str(value), known)
        hint = near or f"choose {_listed(known, 'or')}"
        name = action.option_strings[-1] if action.option_strings else action.metavar or action.dest
        raise UsageError(self.prog, f'{name}: there is no "{value}"', hint)


def parsed(top: CommandParser, given: Sequence[str]) -> argparse.Namespace:
    """The options that a command line gives.

    Raises:
        UsageError: the command line is wrong; an option that does not exist is told before all else.
    """
    for word in given:
        if "\0" in word:  # no shell gives one, but a program may: no path can have it
            raise UsageError(top.prog, "an argument holds a null character")
    try:
        options, left = top.parse_known_args(given)
    except UnknownCommand as error:
        _require_known(top, given, given.index(error.word))
        raise
    except UsageError:
        _require_known(top, given)
        raise
    _require_known(top, given)
    if left:
        parser, _ = _meant(top, given)
        words = " ".join(f'"{word}"' for word in left)
        raise UsageError(parser.prog, f"too many arguments: {words}")
    return options


def _require_known(top: CommandParser, given: Sequence[str], end: int | None = None) -> None:
    """Raises UsageError if an option does not exist for the command that is meant; of the words before `end`."""
    parser, begin = _meant(top, given)
    for word in _options(given[: begin if end is None else end]):
        if not _knows(top, word):
            raise _misplaced(top, parser, word)
    for word in _options(given[begin:end]):
        if not _knows(parser, word):
            name = word.partition("=")[0]
            near = _near(parser, name)
            hint = near and f"{near} `{parser.prog} --help` lists all"
            raise UsageError(parser.prog, f"there is no option {name}", hint)


def _misplaced(top: CommandParser, parser: argparse.ArgumentParser, word: str) -> UsageError:
    """The error for an unknown option before the name of the command."""
    name = word.partition("=")[0]
    if parser is not top and _knows(parser, word):
        command = parser.prog
        return UsageError(
            top.prog, f"{name} is an option of `{command}`", f"write it after that: {command} … {name}"
        )
    return UsageError(top.prog, f"there is no option {name}", _near(top, name))


def _near(parser: argparse.ArgumentParser, name: str) -> str | None:
    """The remedy `did you mean --seed?`, if an option is near; the dashes make none near."""
    near = did_you_mean(name.lstrip("-"), [each[2:] for each in _names(parser) if each.startswith("--")])
    return near and near.replace('"', "--", 1).replace('"', "")


def _options(words: Iterable[str]) -> list[str]:
    """The words that argparse takes for options: up to `--`, and no negative numbers."""
    found = []
    for word in words:
        if word == "--":
            break
        if len(word) > 1 and word[0] == "-" and " " not in word and NEGATIVE.match(word) is None:
            found.append(word)
    return found


def _names(parser: argparse.ArgumentParser) -> list[str]:
    return [name for action in parser._actions for name in action.option_strings]


def _knows(parser: argparse.ArgumentParser, word: str) -> bool:
    """Whether a word is an option of a parser, or begins like one: `--js` is `--json`."""
    name, known = word.partition("=")[0], _names(parser)
    if word.startswith("--"):
        return any(each.startswith(name) for each in known)
    return word[:2] in known


def _meant(top: CommandParser, given: Sequence[str]) -> tuple[argparse.ArgumentParser, int]:
    """The parser of the command that a command line names, and the number of words before its own."""
    parser: argparse.ArgumentParser = top
    begin = 0
    for index, word in enumerate(given):
        commands = commands_of(parser)
        if word == "--" or not commands:
            break
        if word in commands:
            parser, begin = commands[word], index + 1
    return parser, begin


def commands_of(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """The parsers of a parser's commands, by their names; none if it has no commands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def _unknown_command(
    parser: argparse.ArgumentParser, word: str, action: "argparse._SubParsersAction[argparse.ArgumentParser]"
) -> UnknownCommand:
    inner = {name: f"{own.prog} {name}" for own in action.choices.values() for name in commands_of(own)}
    if word.lower().lstrip("-") in PLAIN:
        hint = f"did you mean `{parser.prog} {PLAIN[word.lower().lstrip('-')]}`?"
    elif word in inner:
        other = f"`{parser.prog} {MEANT[word]}` or " if MEANT.get(word) in action.choices else ""
        hint = f"did you mean {other}`{inner[word]}`?"
    elif near := did_you_mean(word.lower(), action.choices):
        hint = near
    elif "." in word or "/" in word:
        hint = f"a command comes first: {_listed(list(action.choices), 'or')}"
    else:
        hint = f"there are {_listed(list(action.choices))}"
    error = UnknownCommand(parser.prog, f'there is no command "{word}"', hint)
    error.word = word
    return error


def _missing(names: list[str]) -> str:
    return f"{_listed([_name(name) for name in names])} {'is' if len(names) == 1 else 'are'} missing"


def _name(argument: str) -> str:
    """An argument's name as it is usually written: `--verbose` of `-v/--verbose`."""
    names = argument.split("/") if argument.startswith("-") else [argument]
    return next((name for name in names if name.startswith("--")), names[0])


def _listed(names: Sequence[str], last: str = "and") -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {last} {names[-1]}"
