"""Follows the log of a run while it is being written: a page shows each record soon after it was written."""

import threading
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from kabo.errors import InputError
from kabo.viewer.content.given import ViewOptions
from kabo.viewer.content.run_view import document_of_run, records_of, run_view
from kabo.viewer.live.http_server import EVENTS, LiveServer
from kabo.viewer.page.writing import page_of

LOOK_S = 0.1  # between two looks at the file


class RunFollower:
    """Serves the page of a run until it is closed; the log may not be there yet.

    Args:
        log: the file of the log.
        plan: the plan file; None: the log alone is shown.
        options: of the plan.
        port: of the page; 0 takes a free one.

    Raises:
        InputError: the plan cannot be shown.
        ServiceError: no page can be served.
    """

    def __init__(self, log: Path, plan: Path | None, options: ViewOptions, port: int = 0) -> None:
        self._log, self._ended = log, threading.Event()
        self._read = self._lines = 0  # bytes and lines
        page = page_of(replace(document_of_run([], log.name, plan, options), run=run_view([], EVENTS)))
        self._live = LiveServer(page, port)
        self._looking = threading.Thread(target=self._look, daemon=True)
        self._looking.start()

    @property
    def address(self) -> str:
        """The address of the page for a browser."""
        return self._live.address

    def close(self) -> None:
        """Ends the page's server."""
        self._ended.set()
        self._looking.join()
        self._live.close()

    def _look(self) -> None:
        while True:
            with suppress(OSError):  # not there yet
                self._look_once()
            if self._ended.wait(LOOK_S):
                return

    def _look_once(self) -> None:
        """Tells what has been written since the last look; a file that is shorter now is another run."""
        with self._log.open("rb") as file:
            if file.seek(0, 2) < self._read:
                self._read = self._lines = 0
                self._live.forget("records")
                self._live.tell("restart", {})
            file.seek(self._read)
            content = file.read()
        try:
            records, size = records_of(content, str(self._log), self._lines + 1)
        except InputError as error:
            self._live.tell("fault", {"text": str(error)})
            self._ended.set()
            return
        self._read, self._lines = self._read + size, self._lines + len(records)
        if records:
            self._live.add("records", records)
