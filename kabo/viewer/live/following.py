"""Follows the requests of the servers at an endpoint: makes the page of each, and tells what is known of it."""

import hashlib
import tempfile
import threading
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import zenoh

from kabo.errors import Diagnostic, InputError, ServiceError
from kabo.language import load_problem
from kabo.scene import load_scene
from kabo.service import (
    Client,
    ErrorReply,
    Forbidden,
    Reply,
    SolveRequest,
    Unreadable,
    Watched,
    read,
    unpack_problem,
)
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import ViewDocument
from kabo.viewer.content.given import ViewOptions, document_of_file
from kabo.viewer.content.scene_view import scene_view
from kabo.viewer.live.http_server import EVENTS, LiveServer
from kabo.viewer.page.writing import page_of

FOUND_S = 3.0  # until which a server must be seen at the endpoint
LOOK_S = 0.3  # between two looks whether there is another request


@dataclass(frozen=True)
class Followed:
    """A request that is followed: where its files are, and what is known of its plan."""

    server: str
    identifier: str
    raw: bytes
    problem: Path
    domain: Path | None


class Follower:
    """Shows the request that the servers at an endpoint have let in last, until it is closed.

    Raises:
        ServiceError: there is no server at the endpoint; or no page can be served.
    """

    def __init__(self, config: zenoh.Config, where: str, port: int = 0) -> None:
        self._where, self._ended, self._lock = where, threading.Event(), threading.Lock()
        self._now: Followed | None = None
        self._answered: Followed | None = None
        with ExitStack() as opened:
            self._client = opened.enter_context(Client(config))
            self._wait_for_server()
            self._folder = Path(opened.enter_context(tempfile.TemporaryDirectory(prefix="kabo-view-")))
            self._live = LiveServer(page_of(self._waiting()), port)
            self._closing = opened.pop_all()
        self._client.watch(self._watched)
        self._looking = threading.Thread(target=self._look, daemon=True)
        self._looking.start()

    @property
    def address(self) -> str:
        """The address of the page for a browser."""
        return self._live.address

    def close(self) -> None:
        """Ends the page's server and the session."""
        self._ended.set()
        self._live.close()
        self._closing.close()

    def _wait_for_server(self) -> None:
        until = threading.Event()
        for _ in range(round(FOUND_S / LOOK_S)):
            if self._client.servers():
                return
            until.wait(LOOK_S)
        message = f"no server answers at {self._where}; kabo serve --listen {self._where} starts one"
        raise ServiceError("unavailable", message)

    # --------------------------------------------------------------------------------------------------- requests
    def _look(self) -> None:
        """Looks from time to time for another request, and shows it."""
        lost = False
        while not self._ended.wait(LOOK_S):
            servers = self._client.servers()
            if not servers and not lost:
                self._live.tell("state", {"text": f"the server at {self._where} is gone", "done": True})
            lost = not servers
            for server in servers:
                raw = self._client.latest_request(server)
                if raw is not None and (self._now is None or raw != self._now.raw):
                    self._follow(server, raw)

    def _follow(self, server: str, raw: bytes) -> None:
        """Shows a request, and waits elsewhere for its answer."""
        try:
            message: SolveRequest = read(SolveRequest, raw)
            folder = self._folder / hashlib.sha256(raw).hexdigest()[:16]
            folder.mkdir(exist_ok=True)
            problem, domain = self._files(server, message, folder)
        except (Unreadable, Forbidden) as error:
            self._now = Followed(server, "", raw, Path(), None)
            self._live.show(page_of(self._waiting()), "waiting")
            self._live.tell("state", {"text": f"a request that cannot be read: {error}", "done": True})
            return
        now = Followed(server, message.id, raw, problem, domain)
        with self._lock:
            self._now = now
        self._live.tell("state", {"text": "a request has come; its scene is being loaded", "done": False})
        self._show(now, b"", "a request is being worked on")
        threading.Thread(target=self._await, args=(now,), daemon=True).start()

    def _files(self, server: str, message: SolveRequest, folder: Path) -> tuple[Path, Path | None]:
        """The problem file of a request and its domain file: those that it brings, or below the server's root."""
        if message.problem.files is not None:
            found = folder / unpack_problem(message.problem, folder)
        else:
            status = self._client.status(server)
            if status is None or status.root is None or message.problem.path is None:
                raise Unreadable("its files are not here")
            folder = Path(status.root)
            found = folder / message.problem.path
        return found, None if message.problem.domain is None else folder / message.problem.domain

    def _await(self, now: Followed) -> None:
        """Waits for the answer to a request by joining it, and shows its plan."""
        answer = self._client.join(now.server, now.raw)
        if self._ended.is_set() or self._now is not now:
            return
        with (
            self._lock
        ):  # the page of an earlier plan, which takes seconds to make, must not come after the answer
            self._answered = now
        if isinstance(answer, Reply):
            if answer.plan is not None:
                self._show(now, answer.plan, _said(answer), last=True)
            reason = answer.body.get("reason") or {}
            self._live.tell("state", {"text": _said(answer), "details": reason.get("details", []), "done": True})
        else:
            told = answer.message if isinstance(answer, ErrorReply) else "the server was lost"
            self._live.tell("state", {"text": f"ended without an answer: {told}", "done": True})

    # --------------------------------------------------------------------------------------------------- messages
    def _watched(self, told: Watched) -> None:
        """Hands on a message of the server about the request that is shown."""
        now = self._now
        if now is None or (told.server, told.identifier) != (now.server, now.identifier) or self._ended.is_set():
            return
        if told.plan is not None:
            self._show(now, told.plan, "the best plan so far; it is being refined and certified")
        elif told.kind in ("progress", "follow"):
            self._live.tell(told.kind, told.body)

    # ------------------------------------------------------------------------------------------------------ pages
    def _show(self, now: Followed, plan: bytes, text: str, *, last: bool = False) -> None:
        """Shows the page of a request, with its plan if there is one; after its answer, only the `last` page."""
        version = hashlib.sha256(now.raw + plan).hexdigest()[:16]
        page = page_of(self._document(now, plan, version))
        with self._lock:
            if self._now is now and (last or self._answered is not now):
                self._live.show(page, version)
                self._live.tell("state", {"text": text, "done": False})

    def _document(self, now: Followed, plan: bytes, version: str) -> ViewDocument:
        try:
            if plan:
                path = self._folder / f"{version}.plan.json"  # an identifier is any text
                path.write_bytes(plan)
                made = document_of_file(path, ViewOptions(problem=now.problem, domain=now.domain))
            else:
                made = _scene_document(now)
        except (InputError, OSError):  # a problem without a scene, or one that the server will refuse
            return replace(self._waiting(version), title=now.problem.stem)
        return replace(made, live={"events": EVENTS, "where": self._where, "version": version})

    def _waiting(self, version: str = "waiting") -> ViewDocument:
        live = {"events": EVENTS, "where": self._where, "version": version}
        return ViewDocument(f"requests at {self._where}", "problem", live=live)


def _scene_document(now: Followed) -> ViewDocument:
    """The scene of a request as it is at the start; without findings, which take seconds.

    Raises:
        InputError: the problem cannot be read, or has no scene.
    """
    problem, arrays = load_problem(now.problem, now.domain), Arrays()
    if problem.scene is None:
        raise InputError([Diagnostic(str(now.problem), 1, 1, "this problem has no scene to show", None)])
    return ViewDocument(problem.name, "problem", scene_view(load_scene(problem.scene), arrays), arrays=arrays)


def _said(answer: Reply) -> str:
    """The outcome of a request as a sentence."""
    if answer.plan is not None:
        return "solved: this is the plan"
    reason = answer.body.get("reason") or {}
    return f"{answer.body.get('status', 'ended')}: {reason.get('message', 'no plan')}"
