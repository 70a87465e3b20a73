"""Work for the tests of the pool: does what the request's options say, without any planning."""

import json
import os
import signal
import time
from pathlib import Path

from kabo.planner.result import Progress
from kabo.service.worker import RequestRefused, Stopped, Ticker


def warm_up() -> None:
    """Waits, dies or notes that it was here, as the environment says."""
    if os.environ.get("STUB_COLD_DEATH"):
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(float(os.environ.get("STUB_WARM_S", "0")))
    if "STUB_WARM_LOG" in os.environ:
        with Path(os.environ["STUB_WARM_LOG"]).open("a") as log:
            log.write(f"{os.getpid()}\n")


def work(request: bytes, root: Path | None, ticker: Ticker) -> tuple[bytes, bytes | None]:
    """Waits `for_s`, dies while the file `die_if` exists, raises, or returns the square of `x`."""
    message = json.loads(request)
    wanted = message.get("options", {})
    if "log" in wanted:
        with Path(wanted["log"]).open("a") as log:
            log.write(f"{message['id']} {os.getpid()}\n")
    if "die_if" in wanted and Path(wanted["die_if"]).exists():
        if wanted.get("die_once"):
            Path(wanted["die_if"]).unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    if wanted.get("raise"):
        raise RuntimeError("on purpose")
    if wanted.get("refuse"):
        raise RequestRefused("forbidden", "on purpose")
    end = time.monotonic() + wanted.get("for_s", 0.0)
    if wanted.get("deaf"):
        time.sleep(wanted["for_s"])
    while time.monotonic() < end:
        ticker.progress(Progress("waiting", expanded=1))
        if ticker.cancelled():
            raise Stopped(ticker.stopped)
        time.sleep(0.002)
    x = wanted.get("x", 0)
    return json.dumps({"id": message["id"], "square": x * x}).encode(), b"plan of " + message["id"].encode()
