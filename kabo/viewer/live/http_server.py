"""The server of a live page: the page, and its events as a browser reads them, on this machine only.

It listens on the loopback interface and answers nobody who calls it by another name than this machine's, so that no
page of the internet can read it.
"""

import json
import queue
import threading
from collections.abc import Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from kabo.errors import ServiceError

HOST = "127.0.0.1"
EVENTS = "/events"
ALIVE_S = 5.0  # after which a line is sent, so that browsers that have gone are noticed
MAX_WAITING = 200  # events that a browser has not taken; a slower one is let go, and asks again


class LiveServer:
    """Serves a page that may change, and hands events to every browser that has it open.

    Args:
        port: the port; 0 takes a free one.

    Raises:
        ServiceError: the port is in use, or may not be used.
    """

    def __init__(self, page: bytes, port: int = 0) -> None:
        self._page = page
        self._latest: dict[str, bytes] = {}
        self._kept: dict[str, list[Any]] = {}
        self._listening: list[queue.Queue[bytes | None]] = []
        self._lock = threading.Lock()
        try:
            self._http = _Http((HOST, port), self)
        except OSError as error:
            message = f"no page can be served on port {port}: {error.strerror}; --port takes another"
            raise ServiceError("unavailable", message) from None
        self._thread = threading.Thread(target=self._http.serve_forever, daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """The address of the page for a browser."""
        return f"http://{HOST}:{self._http.server_address[1]}/"

    @property
    def page(self) -> bytes:
        """The page as it is now."""
        return self._page

    def show(self, page: bytes, version: str) -> None:
        """Serves another page from now on, and tells the browsers to load it; what was told before is dropped."""
        with self._lock:
            self._page = page
            self._latest.clear()
        self.tell("page", {"version": version})

    def tell(self, kind: str, content: Mapping[str, Any]) -> None:
        """Sends an event to all browsers; one that comes later gets the latest of each kind."""
        event = _event(kind, content)
        with self._lock:
            self._latest[kind] = event
            self._send(event)

    def add(self, kind: str, items: Sequence[Any]) -> None:
        """Sends further items of a list to all browsers, with the number of the first; one that comes later gets all."""
        with self._lock:
            kept = self._kept.setdefault(kind, [])
            event = _event(kind, {"from": len(kept), "items": items})
            kept.extend(items)
            self._send(event)

    def forget(self, kind: str) -> None:
        """Begins a list anew."""
        with self._lock:
            self._kept.pop(kind, None)

    def _send(self, event: bytes) -> None:
        for each in list(self._listening):
            if each.qsize() < MAX_WAITING:
                each.put(event)
            else:
                self._listening.remove(each)
                each.put(None)

    def listen(self) -> "queue.Queue[bytes | None]":
        """A queue of events from now on, the latest of each kind and all items of lists first; None ends it."""
        made: queue.Queue[bytes | None] = queue.Queue()
        with self._lock:
            for event in self._latest.values():
                made.put(event)
            for kind, items in self._kept.items():
                made.put(_event(kind, {"from": 0, "items": items}))
            self._listening.append(made)
        return made

    def leave(self, listening: "queue.Queue[bytes | None]") -> None:
        """Sends no further events to a queue."""
        with self._lock:
            if listening in self._listening:
                self._listening.remove(listening)

    def close(self) -> None:
        """Ends the server and all its connections."""
        with self._lock:
            for each in self._listening:
                each.put(None)
            self._listening.clear()
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()


def _event(kind: str, content: Mapping[str, Any]) -> bytes:
    """An event as browsers read it."""
    return f"event: {kind}\ndata: {json.dumps(content, allow_nan=False)}\n\n".encode()


class _Http(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False

    def __init__(self, address: tuple[str, int], live: LiveServer) -> None:
        self.live = live
        super().__init__(address, _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Says nothing: a browser that has gone is no fault."""


class _Handler(BaseHTTPRequestHandler):
    server: _Http

    def do_GET(self) -> None:  # noqa: N802 - the name that the standard library calls
        """Answers a browser."""
        name = self.headers.get("Host", "").rsplit(":", 1)[0]
        path = self.path.partition("?")[0]
        if name not in (HOST, "localhost"):
            self.send_error(403)
        elif path == "/":
            self._send_page()
        elif path == EVENTS:
            self._send_events()
        else:
            self.send_error(404)

    def _send_page(self) -> None:
        page = self.server.live.page
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(page)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(page)

    def _send_events(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        events = self.server.live.listen()
        try:
            while True:
                try:
                    event = events.get(timeout=ALIVE_S)
                except queue.Empty:
                    event = b": alive\n\n"
                if event is None:
                    return
                self.wfile.write(event)
                self.wfile.flush()
        except OSError:
            return  # the browser has gone
        finally:
            self.server.live.leave(events)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the standard library's name
        """Says nothing: the terminal belongs to the command."""
