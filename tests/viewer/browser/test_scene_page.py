"""The page of a scene in a real browser."""

from kabo.cli.main import main


def page_of(tmp_path, *arguments):
    path = tmp_path / "page.html"
    assert main(["view", *map(str, arguments), "-o", str(path), "--no-open"]) == 0
    return path


def test_a_scene_opens_from_disk_with_a_clean_console_and_without_a_request(tmp_path, open_page):
    shown = open_page(page_of(tmp_path, "domains/bartender/scene.yaml"))
    assert shown.run("document.documentElement.dataset.ready") == "yes"
    shown.require_clean()
    assert "bartender" in shown.page.title()
