"""The commands, called in this process with captured output; small symbolic problems to call them on."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from kabo.cli import main

PARCELS = Path(__file__).parents[1] / "acceptance" / "parcels"


@dataclass(frozen=True)
class Said:
    """What a command returned, printed and told."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on standard output; fails if there is anything else."""
        value: dict[str, Any] = json.loads(self.out)
        return value


@pytest.fixture
def kabo(capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Runs a command: `kabo("solve", path)`."""

    def run(*arguments: object) -> Said:
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as ended:  # argparse
            code = int(ended.code or 0)
        return Said(code, *capsys.readouterr())

    return run


@pytest.fixture
def parcels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the parcels domain and its problems; the current one during the test."""
    folder = tmp_path / "parcels"
    shutil.copytree(PARCELS, folder)
    monkeypatch.chdir(folder)
    return folder
