"""What greets somebody who comes to the repository: the workflow, the hooks, templates, the citation, `python -m kabo`."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

import kabo

REPOSITORY = Path(__file__).parents[2]
PYPROJECT = (REPOSITORY / "pyproject.toml").read_text()
CI = (REPOSITORY / ".ci" / "run").read_text()
FORMS = sorted((REPOSITORY / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


def read(path: str) -> Any:
    """A YAML file of the repository."""
    return yaml.safe_load((REPOSITORY / path).read_text())


def test_the_workflow_runs_all_checks_with_the_lowest_and_the_newest_python():
    (job,) = read(".github/workflows/ci.yml")["jobs"].values()
    lowest = re.search(r'requires-python = ">=([\d.]+)"', PYPROJECT)
    listed = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', PYPROJECT)
    assert lowest and listed[0] == lowest[1]
    assert job["strategy"]["matrix"]["python"] == [listed[0], listed[-1]]
    assert ".ci/run" in [step.get("run") for step in job["steps"]]


def test_hooks_before_a_commit_are_the_quick_checks_of_ci():
    repositories = read(".pre-commit-config.yaml")["repos"]
    assert [each["repo"] for each in repositories] == ["local"]
    checks = [hook["entry"] for hook in repositories[0]["hooks"]]
    tools = {" ".join(word for word in check.split() if not word.startswith("-")) for check in checks}
    assert tools == {"ruff check", "ruff format", "lint-imports", "mypy"}
    for tool in tools:
        command, *arguments = tool.split()
        assert re.search(rf"/{command}\"(?: --?[\w-]+)* {arguments[0]}" if arguments else rf"/{command}\"", CI), (
            tool
        )


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_an_issue_form_asks_for_something(path):
    form = yaml.safe_load(path.read_text())
    if path.stem == "config":
        assert form["blank_issues_enabled"] is True
        return
    assert form["name"] and form["description"]
    fields = [field for field in form["body"] if field["type"] != "markdown"]
    assert fields and all(field["attributes"]["label"] for field in fields)
    assert len({field["id"] for field in fields}) == len(fields)


def test_the_citation_is_of_this_version_and_names_the_theses():
    citation = read("CITATION.cff")
    assert citation["version"] == kabo.__version__
    assert f'license = "{citation["license"]}"' in PYPROJECT
    sources = (REPOSITORY / "docs" / "explanation" / "thesis.md").read_text()
    theses = [each for each in citation["references"] if each["type"] == "thesis"]
    assert [each["authors"][0]["family-names"] for each in theses] == ["Gaschler", "Görner"]
    for thesis in theses:
        assert thesis["title"] in sources and str(thesis["year"]) in sources


def test_python_dash_m_kabo_is_the_command():
    program = [sys.executable, "-m", "kabo", "--version"]
    done = subprocess.run(program, capture_output=True, text=True, cwd=REPOSITORY, check=True)
    assert done.stdout == f"kabo {kabo.__version__}\n"
