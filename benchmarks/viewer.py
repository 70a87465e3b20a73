"""How large are pages of plans, how soon is their first frame seen, and how fast is scrubbing? In a real browser.

    python benchmarks/viewer.py                          # three plans, solved first: minutes
    python benchmarks/viewer.py --plans DIRECTORY        # of plans that are there: <domain>_<problem>.json

The browser of this machine draws by software, without a display, at 1280 x 720. The first frame counts from the moment
when the browser begins to load the file; scrubbing goes to a hundred times of the longest branch, and waits for each
frame. Overlaps are counted among all boxes of the graph as it is drawn. No time is asserted.
"""

import argparse
import shutil
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from table import Table, finish, percentile

import kabo
from kabo.plan import Plan, load_plan
from kabo.viewer import ViewDocument, page_of, scene_view
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.plan.plan_view import plan_view

ROOT = Path(__file__).resolve().parent.parent
PROBLEMS = ("bartender/four_bottles", "force_sensing/n10", "stacked/n20")
SOFTWARE = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SCRUBS = 100
SCRUB = """async (count) => {
  const { player } = kabo;
  const began = performance.now();
  for (let i = 0; i < count; i += 1) {
    player.scrub(player.film.duration * i / count);
    await new Promise((done) => requestAnimationFrame(done));
  }
  return 1000 * count / (performance.now() - began);
}"""
FIRST_FRAME = "() => kabo.ready.then(() => performance.now())"
OVERLAPS = """() => {
  const boxes = [...kabo.plan.dag.boxes.values()];
  return boxes.reduce((sum, a, i) => sum + boxes.slice(i + 1).filter((b) => a.x < b.x + b.width && b.x < a.x + a.width
    && a.y < b.y + b.height && b.y < a.y + a.height).length, 0);
}"""


def page(problem_file: Path, plan: Plan | None, seed: int) -> tuple[bytes, float]:
    """The page of a problem's plan, and the seconds of processor time that it took."""
    problem = kabo.load_problem(problem_file)
    scene = None if problem.scene is None else kabo.load_scene(problem.scene)
    plan = plan or kabo.solve(problem, seed=seed).plan
    assert plan is not None
    began, arrays = process_time(), Arrays()
    shown = None if scene is None else scene_view(scene, arrays)
    view = plan_view(plan, problem, scene, arrays, sweeps=True)
    content = page_of(ViewDocument(problem.name, "plan", shown, plan=view, arrays=arrays))
    return content, process_time() - began


def measured(browser: Any, path: Path, rounds: int) -> dict[str, Any]:
    """Seconds to the first frame and frames per second, medians of some rounds; and what the page holds."""
    first, frames = [], []
    for _ in range(rounds):
        shown = browser.new_page(viewport={"width": 1280, "height": 720})
        began = perf_counter()
        shown.goto(path.resolve().as_uri())
        shown.wait_for_selector("html[data-ready=yes]", state="attached", timeout=120_000)
        seconds = min(perf_counter() - began, shown.evaluate(FIRST_FRAME) / 1000)
        first.append(seconds)
        frames.append(shown.evaluate(SCRUB, SCRUBS))
        nodes, branches = shown.evaluate("[kabo.document.plan.nodes.length, kabo.document.plan.branches]")
        overlaps = shown.evaluate(OVERLAPS)
        shown.close()
    return {
        "nodes": nodes,
        "branches": branches,
        "first frame [s]": percentile(first, 0.5),
        "frames per second": percentile(frames, 0.5),
        "overlaps": overlaps,
    }


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problems", nargs="*", default=list(PROBLEMS), metavar="DOMAIN/PROBLEM")
    parser.add_argument("--plans", type=Path, metavar="DIRECTORY", help="where plans are (default: solve)")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pages", type=Path, default=Path("pages"), metavar="DIRECTORY", help="where pages go")
    parser.add_argument("--output", type=Path, metavar="FILE")
    options = parser.parse_args()
    from playwright.sync_api import sync_playwright

    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        parser.error("this machine has no browser: apt-get install chromium")
    options.pages.mkdir(parents=True, exist_ok=True)
    table = Table("pages of plans")
    with sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=browser, args=list(SOFTWARE))
        for name in options.problems:
            stored = None if options.plans is None else options.plans / f"{name.replace('/', '_')}.json"
            plan = None if stored is None else load_plan(stored)
            content, seconds = page(ROOT / "domains" / f"{name}.yaml", plan, options.seed)
            path = options.pages / f"{name.replace('/', '_')}.html"
            path.write_bytes(content)
            figures = measured(chromium, path, options.rounds)
            table.add(name, **{"page [MB]": len(content) / 1e6, "made in [s]": seconds, **figures})
        chromium.close()
    finish([table], options.output, seed=options.seed, rounds=options.rounds)


if __name__ == "__main__":
    main()
