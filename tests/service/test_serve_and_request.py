"""`kabo serve` and `kabo request` as two processes: the same answers as from `kabo solve`."""

import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import jsonschema
import msgspec
import pytest

from kabo.cli import main
from kabo.plan import schema
from kabo.service import Client, client_config, pack_problem
from tests.service.conftest import REPOSITORY, free_endpoint

PARCELS = REPOSITORY / "tests" / "acceptance" / "parcels"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where that process and its worker write what they log."""
    return tmp_path_factory.mktemp("log") / "serve.jsonl"


@pytest.fixture(scope="module")
def endpoint(log: Path) -> Iterator[str]:
    """Where a `kabo serve` process listens; it ends cleanly after the tests."""
    chosen = free_endpoint()
    command = [sys.executable, "-m", "kabo.cli", "serve", "--listen", chosen, "--workers", "1", "--log", str(log)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        assert any("is ready" in line for line in server.stderr)
        yield chosen
        server.send_signal(signal.SIGTERM)
        assert server.wait(15) == 0


@pytest.fixture
def parcels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the parcels domain, the current one during the test."""
    shutil.copytree(PARCELS, tmp_path / "parcels")
    monkeypatch.chdir(tmp_path / "parcels")
    return tmp_path / "parcels"


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command."""
    capsys.readouterr()
    return main(arguments), *capsys.readouterr()


def untimed(body: dict) -> dict:
    """A result without what may differ between two runs: seconds, the id, the path."""
    figures = {k: v for k, v in (body["statistics"] or {}).items() if not k.endswith("_s")}
    return {**{k: v for k, v in body.items() if k not in ("id", "plan")}, "statistics": figures}


@pytest.mark.parametrize(("name", "code"), [("one.yaml", 0), ("hopeless.yaml", 3)])
def test_a_server_answers_as_solve_does(endpoint, parcels, capsys, name, code):
    own = said(capsys, "solve", name, "--json", "-o", "own.json")
    asked = said(capsys, "request", name, "--json", "-o", "asked.json", "--connect", endpoint)
    jsonschema.validate(json.loads(asked[1]), schema("kabo-result-1"))
    assert (own[0], asked[0]) == (code, code)
    assert untimed(json.loads(asked[1])) == untimed(json.loads(own[1]))
    assert json.loads(asked[1])["id"]
    if code == 0:
        assert Path("own.json").read_bytes() == Path("asked.json").read_bytes()
        assert json.loads(asked[1])["plan"] == "asked.json"


def test_the_worker_writes_whole_lines_into_the_log_of_the_server(endpoint, parcels, capsys, log):
    before = len(log.read_text().splitlines())
    assert said(capsys, "request", "one.yaml", "--connect", endpoint)[0] == 0
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    assert {"kabo.cli"} == {line["logger"] for line in lines[:1]}
    assert "searching" in {
        line["fields"].get("phase") for line in lines[before:] if line["logger"] == "kabo.planner"
    }


def test_the_tree_is_shown_as_solve_shows_it(endpoint, parcels, capsys):
    own = said(capsys, "solve", "one.yaml")
    asked = said(capsys, "request", "one.yaml", "--connect", endpoint)
    assert asked[:2] == own[:2]


def test_options_and_their_budgets_travel(endpoint, parcels, capsys):
    code, out, _ = said(capsys, "request", "one.yaml", "--max-expansions", "0", "--json", "--connect", endpoint)
    assert (code, json.loads(out)["reason"]["budget"]) == (4, "expansions")


def test_bad_files_are_told_with_the_names_of_the_client(endpoint, parcels):
    packed = pack_problem(Path("one.yaml"))
    packed["files"]["domain.yaml"] = packed["files"]["domain.yaml"].replace("K(held(p))", "K(hold(p))")
    with Client(client_config([endpoint])) as client:
        body = client.solve(lambda _: packed, {}, deadline_s=30).body
    assert (body["status"], {d["file"] for d in body["diagnostics"]}) == ("invalid", {"domain.yaml"})


@pytest.mark.parametrize(
    ("problem", "options", "code"),
    [
        ({"path": "one.yaml"}, {}, "forbidden"),
        ({}, {}, "bad_request"),
        ({"files": {"../p.yaml": "problem: p"}}, {}, "forbidden"),
        ({"files": {"p.yaml": 7}}, {}, "bad_request"),
        ({"files": {"p.yaml": {"base64": "!"}}}, {}, "bad_request"),
        ({"files": {"p.yaml": "problem: p"}}, {"workers": 8}, "bad_request"),
        ({"files": {"p.yaml": "problem: p"}}, {"search": "fastest"}, "bad_request"),
    ],
)
def test_requests_that_cannot_be_used_get_an_error_reply(endpoint, problem, options, code):
    request = {"id": "odd", "deadline_s": 20, "problem": problem, "options": options}
    request["id"] += str(abs(hash(msgspec.json.encode(request))))
    with Client(client_config([endpoint])) as client:
        server = client._pick(set(), 1e12)
        answer = client._ask(server, "solve", msgspec.json.encode(request), 30)
    assert answer is not None and not hasattr(answer, "attachment")
    error = json.loads(answer.payload.to_bytes())
    assert (error["code"], error["id"]) == (code, request["id"])


def test_without_a_server_request_is_exit_6_in_a_few_seconds(parcels, capsys):
    code, out, err = said(capsys, "request", "one.yaml", "--json", "--connect", free_endpoint())
    assert code == 6 and json.loads(out)["code"] == "unavailable" and "kabo serve" in err


def test_two_servers_cannot_listen_on_one_endpoint(endpoint, capsys):
    code, _, err = said(capsys, "serve", "--listen", endpoint)
    assert code == 6 and endpoint.removeprefix("tcp/") in err


def test_a_server_says_what_is_beyond_knowledge_as_solve_does(endpoint, parcels, capsys):
    Path("either.pddl").write_text(
        "(define (domain c) (:predicates (p) (q) (g))\n"
        " (:action a :parameters () :precondition (or (p) (q)) :effect (g)))\n"
        "(define (problem c1) (:domain c) (:init (oneof (p) (q))) (:goal (g)))\n"
    )
    own = said(capsys, "solve", "either.pddl", "--json")
    asked = said(capsys, "request", "either.pddl", "--json", "--connect", endpoint)
    assert (own[0], asked[0]) == (4, 4)
    jsonschema.validate(json.loads(asked[1]), schema("kabo-result-1"))
    assert json.loads(asked[1])["reason"]["budget"] == "reasoning"
    assert untimed(json.loads(asked[1])) == untimed(json.loads(own[1]))
