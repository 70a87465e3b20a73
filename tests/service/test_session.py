"""Sessions listen where they are told to, and nowhere else."""

import json
from pathlib import Path

from kabo.service.session import client_config, server_config, unanswered


def listens(config):
    """What a configuration listens on."""
    return json.loads(config.get_json("listen/endpoints"))


def written(folder: Path, text: str) -> Path:
    """A zenoh configuration file."""
    file = folder / "zenoh.json5"
    file.write_text(text)
    return file


def test_a_peer_whose_file_names_no_endpoints_opens_no_port(tmp_path):
    assert listens(client_config(file=written(tmp_path, '{mode: "peer"}'))) == []
    assert listens(client_config(file=written(tmp_path, "{}"))) == []


def test_endpoints_of_a_file_or_of_the_command_line_are_listened_on(tmp_path):
    file = written(tmp_path, '{mode: "peer", listen: {endpoints: ["tcp/127.0.0.1:7000"]}}')
    assert listens(server_config(file=file)) == ["tcp/127.0.0.1:7000"]
    assert listens(server_config(["tcp/127.0.0.1:7001"], file=file)) == ["tcp/127.0.0.1:7001"]
    assert listens(server_config(["tcp/127.0.0.1:7001"], file=written(tmp_path, "{}"))) == ["tcp/127.0.0.1:7001"]


def test_a_router_keeps_the_endpoints_of_zenoh(tmp_path):
    assert "router" in listens(server_config(file=written(tmp_path, '{mode: "router"}')))


def test_who_finds_no_server_by_tls_is_told_that_it_may_have_been_refused(tmp_path):
    for endpoints in (
        '["tls/localhost:7447"]',
        '{peer: ["tls/localhost:7447"]}',
        '["tls/localhost:7447#root_ca_certificate=ca.pem"]',
    ):
        file = written(tmp_path, f'{{mode: "peer", connect: {{endpoints: {endpoints}}}}}')
        said = unanswered(client_config(file=file))
        assert said.startswith(
            "no server answers at tls/localhost:7447: none runs there, or it refuses this client"
        )
        assert "docs/how-to/deploy.md" in said
    plain = written(tmp_path, '{mode: "peer", connect: {endpoints: ["tcp/localhost:7447"]}}')
    for config in (client_config(), client_config(file=plain)):
        assert unanswered(config) == "no server answers; `kabo serve` starts one"
