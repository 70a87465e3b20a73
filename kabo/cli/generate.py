"""`kabo generate`: writes a problem of a given size, by the generator that lies beside its domain.

The generator is `problem(n, home, …)` in `domains/<name>/generate.py`. It returns the text of a problem file; `home` is
the path from the folder of the problem file to the folder of the domain. All other parameters of the generator
have defaults and are set by `--set`. kabo itself contains no scenario.
"""

import argparse
import importlib.util
import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import kabo
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural, output_file
from kabo.cli.limits import add_limits
from kabo.errors import Diagnostic, InputError, did_you_mean

NAME = "generate"
HELP = "write a problem file of size N for one of the domains"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo generate` to the parser."""
    parser.add_argument("domain", metavar="DOMAIN", help="a name under domains/, or a folder with generate.py")
    parser.add_argument("--n", type=natural, required=True, metavar="N", help="the size, as the domain counts it")
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        metavar="KEY=VALUE",
        help="other parameters of the domain's generator; its README lists them",
    )
    parser.add_argument(
        "-o", dest="output", type=output_file, required=True, metavar="FILE", help="the problem file"
    )
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Writes the problem with paths relative to its file, and prints the file's path."""
    folder = domain_folder(options.domain)
    rule = _rule(folder)
    settings = dict(_setting(rule, options.domain, text) for text in options.set)
    text = rule(options.n, home_from(options.output.parent, folder), **settings)
    rooms.write_atomically(options.output, text.encode())
    print(options.output)
    return exit_codes.DONE


def domain_folder(name: str) -> Path:
    """The folder of a domain with a generator; `name` is its path, or the name of a known domain.

    Raises:
        InputError: there is no generator of this name; proposes a similar name.
    """
    if (Path(name) / "generate.py").is_file():
        return Path(name)
    package = Path(kabo.__file__).parent
    homes = [Path("domains"), package.parent / "domains", package / "data" / "domains"]
    for home in homes:
        if (home / name / "generate.py").is_file():
            return home / name
    known = sorted({found.parent.name for home in homes for found in home.glob("*/generate.py")})
    hint = did_you_mean(name, known) or f"domains with a generator: {', '.join(known) or 'none'}"
    raise InputError([Diagnostic(name, 1, 1, "no such domain with a generate.py", hint)])


def home_from(start: Path, folder: Path) -> str:
    """The path from one folder to another, as a prefix of relative paths: empty, or ending with `/`."""
    way = Path(os.path.relpath(folder.resolve(), start.resolve())).as_posix()
    return "" if way == "." else f"{way}/"


def _setting(rule: Callable[..., str], domain: str, text: str) -> tuple[str, Any]:
    """A parameter of the generator and its value, of the type of the parameter's default."""
    taken = {p.name: p.default for p in list(inspect.signature(rule).parameters.values())[2:]}
    name, equals, value = text.partition("=")
    if name not in taken or not equals:
        hint = did_you_mean(name, list(taken)) or f"it takes {', '.join(taken) or 'nothing but --n'}"
        raise InputError([Diagnostic(text, 1, 1, f"{domain} has no such setting; write KEY=VALUE", hint)])
    kind = type(taken[name])
    read: Callable[[str], Any] = {"true": True, "false": False}.__getitem__ if kind is bool else kind
    try:
        return name, read(value)
    except (KeyError, ValueError):
        wanted = {bool: "true or false", int: "a whole number", float: "a number"}.get(kind, "a text")
        raise InputError([Diagnostic(text, 1, 1, f"{name} takes {wanted}, not {value!r}", None)]) from None


def _rule(folder: Path) -> Callable[..., str]:
    path = folder / "generate.py"
    specification = importlib.util.spec_from_file_location(f"kabo_generator_{folder.name}", path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    rule: Callable[..., str] = module.problem
    return rule
