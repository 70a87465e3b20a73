"""Every command with its arguments and options, from the parsers of the command line."""

import argparse
import re
from collections.abc import Iterator

from kabo.cli.main import parser
from kabo.options import OPTIONS
from scripts.reference import solve_options
from scripts.reference.markdown import cell, code, plain, table


def sections() -> str:
    """A section for each command, and for each command of a command."""
    return "\n\n" + "\n\n".join(section(words, each) for words, each in commands(parser(), "kabo")) + "\n\n"


def commands(top: argparse.ArgumentParser, words: str) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """A parser and those of its commands, each with the words that call it."""
    yield words, top
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield from commands(inner, f"{words} {name}")


def section(words: str, each: argparse.ArgumentParser) -> str:
    """The section of one command: what it does, how it is called, what it takes."""
    parts = [f"## {words}", sentence(each.description or ""), f"```text\n{usage(words, each)}\n```"]
    everywhere = {option for action in parser()._actions for option in action.option_strings}
    shown = [action for action in each._actions if is_shown(action)]
    if words != "kabo":
        shown = [action for action in shown if not everywhere & set(action.option_strings)]
    rows = [(written(action), *described(action)) for action in shown]
    if rows:
        parts.append(table(("argument", "default", "meaning"), rows))
    return "\n\n".join(part for part in parts if part)


def described(action: argparse.Action) -> tuple[str, str]:
    """The default and the meaning of an argument; the table of options has those of a solve as Markdown."""
    text = help_of(action)
    found = re.search(r" ?\(default: ((?:[^()]|\([^()]*\))*)\)", text)
    said = default(action) if found is None else found[1] if " " in found[1] else code(found[1])
    rest = text if found is None else text.replace(found[0], "")
    option = OPTIONS.get(action.dest)
    if option is None or rest != option.help.replace("`", ""):
        return said, meaning(action, rest)
    known = solve_options.default(option)
    return known if known.replace("`", "") == said.strip("`") else said, solve_options.meaning(option)


def sentence(text: str) -> str:
    """A help message as a sentence."""
    return plain(text[:1].upper() + text[1:].removesuffix(".") + ".") if text else ""


def is_shown(action: argparse.Action) -> bool:
    """Whether an action is described: commands have sections of their own, and every command has --help."""
    hidden = isinstance(action, argparse._SubParsersAction | argparse._HelpAction)
    return not hidden and action.help != argparse.SUPPRESS


def usage(words: str, each: argparse.ArgumentParser) -> str:
    """The words of a call: what must be given, and that there are options."""
    shown = [action for action in each._actions if is_shown(action)]
    positional = [operand(action) for action in shown if not action.option_strings]
    needed = [
        f"{action.option_strings[-1]} {value(action)}"
        for action in shown
        if action.option_strings and action.required
    ]
    inner = (
        ["COMMAND …"] if any(isinstance(action, argparse._SubParsersAction) for action in each._actions) else []
    )
    options = ["[OPTIONS]"] if any(action.option_strings and not action.required for action in shown) else []
    return " ".join([words, *positional, *needed, *options, *inner])


def operand(action: argparse.Action) -> str:
    """An argument without a name, as usages write it: how often it may stand."""
    name = value(action).split()[0]
    return {"?": f"[{name}]", "*": f"[{name} …]", "+": f"{name} …"}.get(str(action.nargs), name)


def value(action: argparse.Action) -> str:
    """What stands for the value of an argument; empty if it takes none."""
    if action.nargs == 0:
        return ""
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    name = action.metavar or ("NAME" if action.choices else action.dest.upper())
    return f"{name} …" if action.nargs in ("+", "*") else name


def written(action: argparse.Action) -> str:
    """An argument or option as it is written on the command line."""
    if not action.option_strings:
        return code(operand(action))
    if isinstance(action, argparse.BooleanOptionalAction):
        return ", ".join(code(option) for option in action.option_strings)
    *short, last = action.option_strings
    return ", ".join([*(code(each) for each in short), code(f"{last} {value(action)}".strip())])


def default(action: argparse.Action) -> str:
    """What holds without the argument."""
    if not action.option_strings:
        return ""
    if action.required:
        return "must be given"
    if action.nargs == 0 and not isinstance(action, argparse.BooleanOptionalAction):
        return ""
    if action.default in (None, argparse.SUPPRESS, "") or action.default == []:
        return ""
    if isinstance(action.default, bool):
        return "yes" if action.default else "no"
    return code(f"{action.default:g}" if isinstance(action.default, float) else action.default)


def help_of(action: argparse.Action) -> str:
    """The help message of an argument, as `--help` prints it."""
    words, text = {**vars(action), "prog": "kabo"}, action.help or ""
    if isinstance(action, argparse.BooleanOptionalAction):
        text = text.replace(" (default: %(default)s)", "")  # older versions of Python append it
    return re.sub(r"%\((\w+)\)s", lambda found: str(words.get(found[1], "")), text).replace("%%", "%")


def meaning(action: argparse.Action, text: str) -> str:
    """A help message, with the choices that it does not name."""
    unnamed = [str(each) for each in action.choices or () if str(each) not in text]
    listed = ", ".join(code(each) for each in action.choices or ())
    return cell(plain(text) + (f" ({listed})" if unnamed else ""))
