"""`kabo serve`: answers requests over zenoh until SIGTERM or Ctrl-C."""

import argparse
import signal
import threading
from functools import partial
from pathlib import Path

from kabo import service
from kabo.cli import exit_codes
from kabo.cli.argument_types import natural
from kabo.cli.logs import log_into
from kabo.cli.terminal import tell
from kabo.cli.waiting.display import ticking
from kabo.cli.waiting.doing import Doing

NAME = "serve"
HELP = "answer requests over zenoh; without endpoints, on the loopback interface only"
FINISH_S = 10.0  # how long running jobs may take after the first signal
WARMING_UP = Doing("warming up", "warming up; the first time on a machine, this compiles for a minute")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo serve` to the parser."""
    parser.add_argument(
        "--listen", action="append", default=[], metavar="ENDPOINT", help="e.g. tcp/127.0.0.1:7447"
    )
    parser.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT", help="a zenoh router or peer"
    )
    parser.add_argument("--workers", type=natural, default=2, metavar="N", help="worker processes (default: 2)")
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="a zenoh configuration (JSON5): TLS, access rules"
    )
    parser.add_argument(
        "--root", type=Path, metavar="FOLDER", help="let requests name problem files below this folder"
    )


def run(options: argparse.Namespace) -> int:
    """Serves until SIGTERM or Ctrl-C; a second signal ends the server without waiting for running jobs."""
    config = service.server_config(options.listen, options.connect, options.config)
    log = getattr(options, "log", None)
    begin = None if log is None else partial(log_into, log.resolve())
    settings = service.ServerSettings(workers=max(1, options.workers), root=options.root, begin=begin)
    with ticking(WARMING_UP):
        server = service.Server(config, settings)
    asked_to_end = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: asked_to_end.set())
    tell(f"kabo: {server.name} is ready")
    asked_to_end.wait()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)
    tell("kabo: finishing running jobs")
    server.close(FINISH_S)
    return exit_codes.DONE
