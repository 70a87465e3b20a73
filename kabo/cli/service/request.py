"""`kabo request`: `kabo solve` on a server, with the same options, output and files."""

import argparse
import uuid
from pathlib import Path
from typing import Any

from kabo import service
from kabo.cli import rooms
from kabo.cli.solving import add_search_arguments, chosen_options, finish
from kabo.cli.terminal import complain
from kabo.errors import Diagnostic, InputError

NAME = "request"
HELP = "ask a server to solve a problem file; the answer is that of `kabo solve`"
DEADLINE_S = 3600.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo request` to the parser."""
    add_search_arguments(parser, NAME)
    parser.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT", help="e.g. tcp/127.0.0.1:7447"
    )
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="a zenoh configuration (JSON5): TLS, passwords"
    )


def run(options: argparse.Namespace) -> int:
    """Sends the problem, shows the answer, and writes the plan file if there is a plan."""
    identifier = uuid.uuid4().hex
    try:
        problem = service.problem_for(options.problem, options.domain)
    except InputError as error:  # a server would say the same
        if not options.json:
            complain(str(error))
        return finish({**rooms.invalid_to_json(error), "id": identifier}, None, options)
    reply = _asked(problem, identifier, options)
    if not options.json:
        for fields in reply.body["diagnostics"]:
            complain(str(Diagnostic(**fields)))
    return finish(reply.body, reply.plan, options)


def _asked(problem: "service.ProblemFor", identifier: str, options: argparse.Namespace) -> "service.Reply":
    """The server's reply; Ctrl-C also cancels the job on the server."""
    deadline_s = min(DEADLINE_S, options.surrounding.left(options.timeout) or DEADLINE_S)
    report = options.surrounding.planning
    with service.Client(service.client_config(options.connect, options.config)) as client:
        chosen = chosen_options(options) | ({} if options.timeout is None else {"timeout": deadline_s})
        asked: dict[str, Any] = {"deadline_s": deadline_s, "identifier": identifier}
        try:
            return client.solve(problem, chosen, **asked, on_progress=lambda body: report(rooms.Progress(**body)))
        except KeyboardInterrupt:
            client.cancel(identifier)
            raise
