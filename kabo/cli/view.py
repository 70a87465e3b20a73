"""`kabo view`: writes a page that shows a scene, a plan, a report or an explanation, and opens it in a browser."""

import argparse
import json
import signal
import threading
import webbrowser
from pathlib import Path

from kabo import service
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import output_file, port, whole
from kabo.cli.limits import add_limits
from kabo.cli.solving import has_scene
from kabo.cli.terminal import clean_standard_output, tell
from kabo.errors import Diagnostic, InputError
from kabo.phases import phase

NAME = "view"
HELP = "show a scene, problem, task, plan, report or explanation as one page for a browser"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo view` to the parser."""
    parser.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE",
        help="a scene, problem or task file, a plan, a task's report, an explanation (kabo explain --json), or a run's log",
    )
    parser.add_argument(
        "plan",
        type=Path,
        nargs="?",
        metavar="PLAN",
        help="the plan, if FILE is its problem: of a run that is followed",
    )
    parser.add_argument(
        "-o",
        dest="output",
        type=output_file,
        default=Path("page.html"),
        metavar="FILE",
        help="the page: one file that needs no server and no network (default: page.html)",
    )
    parser.add_argument("--open", action=argparse.BooleanOptionalAction, default=True, help="open it in a browser")
    parser.add_argument(
        "--problem",
        type=Path,
        metavar="FILE",
        help="the problem of a plan or an explanation (default: of a plan, found by name and hash)",
    )
    parser.add_argument("--domain", type=Path, metavar="FILE", help="the domain file of a problem in PDDL or PKS")
    parser.add_argument("--scene", type=Path, metavar="FILE", help="the scene of a task, report or explanation")
    parser.add_argument(
        "--solution", type=whole(1), metavar="N", help="of a report: play this solution (default: the first ones)"
    )
    parser.add_argument(
        "--detail",
        choices=("low", "original"),
        default="low",
        help="whether meshes have fewer triangles than their files (default: low)",
    )
    parser.add_argument(
        "--prepare",
        action="store_true",
        help="make the convex parts that planning needs and that are in no file yet, as kabo check does",
    )
    parser.add_argument(
        "--follow",
        metavar="WHAT",
        help="show what a server does, as it does it: e.g. tcp/127.0.0.1:7447, where kabo serve listens; "
        "or a run, by its log, with its plan: kabo view PROBLEM PLAN --follow LOG.jsonl",
    )
    parser.add_argument(
        "--port", type=port, default=0, metavar="N", help="with --follow: the page's port (default: a free one)"
    )
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="with --follow: a zenoh configuration (JSON5): TLS, passwords"
    )
    add_limits(parser)
    parser.set_defaults(needs_kernels=_shows_motion)


def run(options: argparse.Namespace) -> int:
    """Writes the page, or follows a server until Ctrl-C; opens the page if that is wanted; returns the exit code."""
    if options.follow is not None and rooms.is_log(Path(options.follow)):
        return _follow_run(options)
    if options.file is not None and rooms.is_log(options.file):
        return _write(options, rooms.document_of_run(rooms.read_log(options.file), options.file.name))
    if (options.file is None) == (options.follow is None) or options.plan is not None:
        message = "give a file to show, or a server to follow: not both, not none"
        raise InputError(
            [Diagnostic("kabo view", 1, 1, message, "kabo view FILE, or kabo view --follow ENDPOINT")]
        )
    if options.follow is not None:
        return _follow(options)
    with clean_standard_output():
        chosen = rooms.ViewOptions(
            options.problem,
            options.scene,
            options.domain,
            options.detail,
            options.prepare,
            options.surrounding.preparing,
            options.solution,
        )
        with phase("making the page"):
            made = rooms.document_of_file(options.file, chosen)
    return _write(options, made)


def _write(options: argparse.Namespace, made: "rooms.ViewDocument") -> int:
    """Writes a page, and opens it if that is wanted."""
    page = rooms.page_of(made)
    rooms.write_atomically(options.output, page)
    tell(f"{options.output}: {len(page) / 1e6:.2f} MB")
    if options.open and not webbrowser.open(options.output.resolve().as_uri()):
        tell(f"no browser was found: open {options.output} yourself")
    return exit_codes.DONE


def _shows_motion(options: argparse.Namespace) -> bool:
    """Whether the page needs kinematics: symbolic plans do not, nor does a page that follows a server."""
    if options.file is None:
        return False
    if options.file.suffix != ".json":
        return options.scene is not None or has_scene(options.file)
    try:
        document = json.loads(options.file.read_bytes())
    except (OSError, ValueError):  # told by the command
        return False
    return isinstance(document, dict) and (
        document.get("format") not in rooms.READABLE_FORMATS or "start" in document
    )


def _follow_run(options: argparse.Namespace) -> int:
    """Writes the page of a run that has ended; serves that of one that goes on, until Ctrl-C or the limit of time."""
    log, plan = Path(options.follow), options.plan or options.file
    problem = options.problem if options.plan is None else options.file
    chosen = rooms.ViewOptions(problem=problem, domain=options.domain, detail=options.detail)
    records = rooms.read_log(log) if log.is_file() else []
    if rooms.has_ended(records):
        with clean_standard_output():
            made = rooms.document_of_run(records, log.name, plan, chosen)
        return _write(options, made)
    with clean_standard_output():
        return _serve_page(options, rooms.RunFollower(log, plan, chosen, options.port), f"the run of {log}")


def _follow(options: argparse.Namespace) -> int:
    """Serves the page of a server's requests until Ctrl-C, SIGTERM or the limit of time."""
    follower = rooms.Follower(
        service.client_config([options.follow], options.config), options.follow, options.port
    )
    return _serve_page(options, follower, f"the requests at {options.follow}")


def _serve_page(options: argparse.Namespace, follower: "rooms.Follower | rooms.RunFollower", what: str) -> int:
    ended = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    try:
        tell(f"{follower.address} shows {what}; Ctrl-C ends it")
        if options.open and not webbrowser.open(follower.address):
            tell("no browser was found: open this address yourself")
        options.surrounding.rest()
        ended.wait(options.surrounding.left(options.timeout))
    finally:
        follower.close()
    return exit_codes.DONE
