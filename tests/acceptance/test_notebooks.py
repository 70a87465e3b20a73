"""The notebooks of examples/notebooks: small, without outputs, and one of them is executed as a person would."""

import json
import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
MAX_BYTES = 20_000
SECONDS = 300  # of one cell: kernels may have to be compiled first


def test_there_are_three():
    assert [path.stem for path in NOTEBOOKS] == ["explain", "own_robot", "plan_and_look"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_small_and_without_outputs(path):
    assert path.stat().st_size < MAX_BYTES
    content = json.loads(path.read_text())
    assert not [cell for cell in content["cells"] if cell.get("outputs") or cell.get("execution_count")]
    assert content["cells"][0]["source"][0].startswith("# ")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_code_of_a_notebook_names_files_that_are_there(path):
    text = path.read_text()
    named = re.findall(r'\\"(\.\./[a-z0-9_./]+)\\"', text)
    assert named and not [name for name in named if not (FOLDER / name).exists()]


@pytest.mark.slow
def test_a_notebook_runs_and_shows_figures_and_pages():
    nbformat = pytest.importorskip("nbformat", reason="notebooks need the extra `dev`")
    nbclient = pytest.importorskip("nbclient", reason="notebooks need the extra `dev`")
    notebook = nbformat.read(FOLDER / "plan_and_look.ipynb", as_version=4)
    notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    client = nbclient.NotebookClient(notebook, timeout=SECONDS, resources={"metadata": {"path": str(FOLDER)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    shown = "".join(output.get("data", {}).get("text/html", "") for output in outputs)
    assert shown.count("<iframe srcdoc=") == 4 and "Report: verified" in shown
    assert not [output for output in outputs if output.output_type == "error"]
    printed = "".join(output.get("text", "") for output in outputs)
    assert "n0   grasp(r=arm, o=cup_1)" in printed  # the tree as `kabo solve` prints it
