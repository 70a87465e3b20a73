"""`kabo view`: pages are written where they are wanted; what cannot be shown is exit code 2, with what would help."""

from pathlib import Path

import pytest

from kabo.cli.main import parser

REPOSITORY = Path(__file__).parents[2]
BARTENDER = REPOSITORY / "domains" / "bartender"


def test_a_page_is_written_and_not_opened(kabo, tmp_path):
    said = kabo("view", str(BARTENDER / "scene.yaml"), "-o", str(tmp_path / "seen.html"), "--no-open")
    assert said.code == 0
    assert said.out == ""
    assert "seen.html: 0." in said.err
    assert (tmp_path / "seen.html").read_text().startswith("<!DOCTYPE html>")


def test_the_same_scene_gives_the_same_page(kabo, tmp_path):
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    for page in pages:
        assert kabo("view", str(BARTENDER / "four_bottles.yaml"), "-o", str(page), "--no-open").code == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("absent.yaml", "absent.yaml"),
        ("one.yaml", "this problem has no scene to show"),
        ("domain.yaml", "a file of kind domain, which shows nothing by itself"),
        (str(REPOSITORY / "examples/pick_and_place/task.yaml"), "--scene FILE"),
    ],
)
def test_what_cannot_be_shown_is_exit_2_with_a_remedy_and_without_a_page(kabo, parcels, file, said):
    answer = kabo("view", file, "-o", "page.html", "--no-open")
    assert answer.code == 2
    assert said in answer.err
    assert not (parcels / "page.html").exists()


def test_a_task_is_shown_in_the_scene_that_is_named(kabo, tmp_path):
    example = REPOSITORY / "examples" / "pick_and_place"
    page = tmp_path / "page.html"
    scene = ("--scene", str(example / "scene.yaml"))
    assert kabo("view", str(example / "task.yaml"), *scene, "-o", str(page), "--no-open").code == 0
    assert "pick_and_place" in page.read_text()


def test_what_is_shown_is_not_overwritten_by_its_page(kabo, parcels):
    before = (parcels / "one.yaml").read_bytes()
    answer = kabo("view", "one.yaml", "-o", "../parcels/one.yaml", "--no-open")
    assert answer.code == 2
    assert "it would be overwritten" in answer.err
    assert (parcels / "one.yaml").read_bytes() == before


def test_a_dash_is_no_file(kabo, parcels):
    answer = kabo("solve", "one.yaml", "-o", "-")
    assert answer.code == 2
    assert "/dev/stdout" in answer.err
    assert not (parcels / "-").exists()


def test_a_port_that_cannot_be_is_told_before_anything_is_done(kabo):
    answer = kabo("view", "--follow", "tcp/127.0.0.1:1", "--port", "65536", "--no-open")
    assert answer.code == 2
    assert "a port from 0 to 65535" in answer.err


def test_what_is_no_endpoint_is_told_without_the_sources_of_a_library(kabo):
    answer = kabo("view", "--follow", "rubbish", "--no-open")
    assert "Endpoints must be of the form" in answer.err
    assert ".rs" not in answer.err and "Json5Err" not in answer.err


def test_only_pages_with_kinematics_wait_for_kernels(tmp_path):
    def waits(*given: str) -> bool:
        options = parser().parse_args(["view", *given])
        return bool(options.needs_kernels(options))

    symbolic = tmp_path / "symbolic.json"
    symbolic.write_text('{"format": "kabo-plan/1", "nodes": {}}')
    moving = tmp_path / "moving.json"
    moving.write_text('{"format": "kabo-plan/1", "nodes": {}, "start": {}}')
    assert not waits(str(symbolic)) and waits(str(moving))
    assert waits(str(REPOSITORY / "domains/stacked/n2.yaml"))
    assert not waits(str(REPOSITORY / "domains/doors/n3.yaml"))
    assert not waits("--follow", "tcp/127.0.0.1:7447")
