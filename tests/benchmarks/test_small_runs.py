"""Every script in `benchmarks/` runs, as small as its options allow, and writes its tables.

Four are not run: `construction_set_peer.py` needs hpp-python, `viewer.py` a browser, `motion_ways.py` problems that
others have, and the sections `bounding` and `decomposition` of `geometry.py` an environment of the judge's.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROPERTY_SCALE

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
RUNS = (
    "certificates stacked/n2 --output out.json",
    "construction_set --seeds 1 --output out.json",
    "execution worlds --problems domains/doors/n3.yaml --worlds 20 --output out.json",
    "execution robots --robots Panda --output out.json",
    "execution_displaced --runs 1 --only stacked --output out.json",
    "execution_faults --runs 1 --workers 1 --output out.json",
    "execution_physics --only stacked/n2 --not n20 --branches 1 --output out.json",
    "exploration bar --small --output out",
    "exploration line string budget speed worlds --small --seeds 1 --output out",
    "geometry predicates --scene generated --configurations 8 --output out",
    "geometry refused --output out",
    "geometry scaling --largest 1e2 --output out",
    "inverse_kinematics --poses 5 --at-least 0.01 --output out.json",
    "kernel --scene generated --configurations 8 --segments 3 --output out.json",
    "knowledge --only unix-1 doors-3 --repeat 1 --output out.json",
    "margins --only two_cans --mutants 6 --output out.json",
    "motion_law --motions 1 --rounds 1 --output out.json",
    "motion --only stacked/n2 --not n20 --rounds 0 --quality fast --output out.json",
    "promises --only start-up --seeds 1 --verify 1 --starts 1 --output out.json",
    "quality --only force_sensing --seeds 1 --output out.json",
    "robots ready --only Panda --output out.json",
    "sampling --samples 200 --peers 2 --rounds 1 --output out.json",
    "service_memory --requests 6 --output out.json",
    "tasks core law --trees 20 --repeat 1 --output out",
    "tasks pick_and_place padding --robots generated --seeds 1 --solutions 1 --judged 1 --output out",
    "tasks reparameterisation stack --robots generated --seeds 1 --runs 1 --output out",
    "tasks pouring --robots generated --pourings 1 --limit 1 --output out",
    "tasks_workers --small --output out",
    "thesis --only bartender --trials 1 --seconds 1 --output out.json",
    "tuning --only MAX_SEEDS --output out.json",
    "verification --cases stacked --colliding 1 --seconds 20 --output out.json",
)
LONG = (  # ten seconds to half a minute each: only where everything is run
    "execution_remote --runs 1 --whole 0 -o out.json",
    "exploration reach journal --small --seeds 1 --output out",
    "motion --only stacked/n2 --not n20 --rounds 1 --quality fast --output out.json",
    "promises --only bartender --seeds 1 --verify 1 --starts 1 --output out.json",
    "robots epsilon --only ASSEMBLY --epsilon 0.02 --output out.json",
)
NOT_RUN = {"construction_set_peer.py", "motion_ways.py", "viewer.py"}


def scripts():
    """The scripts that are called, not imported."""
    return {path.name for path in BENCHMARKS.glob("*.py") if "ArgumentParser(" in path.read_text()}


def test_every_script_has_a_small_run():
    assert {f"{run.split()[0]}.py" for run in RUNS + LONG} == scripts() - NOT_RUN


@pytest.mark.slow
@pytest.mark.parametrize("run", RUNS + LONG if PROPERTY_SCALE >= 1.0 else RUNS)
def test_a_small_run_prints_rows_as_they_come_and_writes_its_tables(run, tmp_path):
    name, *arguments = run.split()
    done = subprocess.run(
        [sys.executable, str(BENCHMARKS / f"{name}.py"), *arguments],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    written = [json.loads(path.read_text()) for path in tmp_path.rglob("*.json")]
    tables = [table for content in written for table in content.get("tables", ())]
    assert tables
    for table in tables:
        assert table["rows"], table["title"]
        assert table["title"] in done.stdout
        assert f"{table['title']} | {table['rows'][0]['']}: " in done.stderr
