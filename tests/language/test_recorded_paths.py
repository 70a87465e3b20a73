"""Files are named in plans so that the name is the same wherever kabo is installed."""

from pathlib import Path

import pytest

from kabo.language import recorded_files


def recorded_path(path: Path, folder: Path) -> str:
    (name,) = recorded_files([(path, "sha256:0")], folder)
    return name


@pytest.fixture
def share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("sys.prefix", str(tmp_path / "environment"))
    return tmp_path / "environment" / "share"


def test_a_file_is_named_by_its_path_from_the_folder(share: Path, tmp_path: Path):
    assert recorded_path(tmp_path / "a" / "b.stl", tmp_path / "a") == "b.stl"
    assert recorded_path(tmp_path / "b.stl", tmp_path / "a") == "../b.stl"


def test_a_file_of_an_installed_package_is_named_by_its_package(share: Path, tmp_path: Path):
    assert recorded_path(share / "toy" / "b.stl", tmp_path / "a") == "package://toy/b.stl"


def test_a_problem_that_is_installed_itself_names_its_files_by_their_paths(share: Path):
    assert recorded_path(share / "toy" / "meshes" / "b.stl", share / "toy" / "problems") == "../meshes/b.stl"
    assert recorded_path(share / "toy" / "b.stl", share / "toy") == "b.stl"


def test_an_environment_within_the_folder_of_the_problem_has_installed_packages_too(share: Path, tmp_path: Path):
    assert recorded_path(share / "toy" / "b.stl", tmp_path) == "package://toy/b.stl"
