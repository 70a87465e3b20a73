"""The server of a live page: the page, its events in order, and nobody from elsewhere."""

import json
import socket
import urllib.error
import urllib.request
from collections.abc import Iterator

import pytest

from kabo.errors import ServiceError
from kabo.viewer.live.http_server import LiveServer


@pytest.fixture
def live() -> Iterator[LiveServer]:
    server = LiveServer(b"<p>first</p>")
    yield server
    server.close()


def opened(live: LiveServer, path: str = "", **headers: str) -> bytes:
    request = urllib.request.Request(live.address + path, headers=headers)
    with urllib.request.urlopen(request, timeout=10) as answer:
        content: bytes = answer.read()
    return content


def test_the_page_is_the_one_that_was_shown_last(live: LiveServer) -> None:
    assert opened(live) == b"<p>first</p>"
    live.show(b"<p>second</p>", "2")
    assert opened(live) == b"<p>second</p>"


def test_a_browser_gets_the_latest_of_each_kind_and_then_what_comes(live: LiveServer) -> None:
    live.tell("progress", {"expanded": 1})
    live.tell("progress", {"expanded": 2})
    with urllib.request.urlopen(live.address + "events", timeout=10) as events:
        assert events.headers["Content-Type"] == "text/event-stream"
        assert [events.readline() for _ in range(2)] == [b"event: progress\n", b'data: {"expanded": 2}\n']
        events.readline()
        live.tell("state", {"text": "done"})
        assert [events.readline() for _ in range(2)] == [b"event: state\n", b'data: {"text": "done"}\n']


def test_another_page_drops_what_was_told_of_the_one_before(live: LiveServer) -> None:
    live.tell("follow", {"refused": ["of the page before"]})
    live.show(b"<p>second</p>", "2")
    queue = live.listen()
    assert json.loads(queue.get(timeout=1).split(b"data: ")[1]) == {"version": "2"}  # type: ignore[union-attr]
    assert queue.empty()


def test_only_the_page_and_its_events_are_there_and_only_by_the_name_of_this_machine(live: LiveServer) -> None:
    with pytest.raises(urllib.error.HTTPError, match="404"):
        opened(live, "etc/passwd")
    with pytest.raises(urllib.error.HTTPError, match="403"):
        opened(live, Host="pages.example")


def test_a_port_that_is_taken_is_told_with_the_remedy() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ServiceError, match="--port takes another"):
            LiveServer(b"", taken.getsockname()[1])


def test_a_browser_that_takes_nothing_is_let_go(live: LiveServer) -> None:
    queue = live.listen()
    for number in range(300):
        live.tell("progress", {"expanded": number})
    assert queue.qsize() <= 201 and [queue.get() for _ in range(queue.qsize())][-1] is None  # noqa: PLR2004
