"""Pages in the frames of a notebook: as in JupyterLab, the page is the frame's `srcdoc`."""

from pathlib import Path

import kabo

REPOSITORY = Path(__file__).parents[3]


def test_a_frame_of_a_notebook_is_a_page_that_works(open_page, tmp_path):
    problem = kabo.load_problem(REPOSITORY / "domains" / "force_sensing" / "n2.yaml")
    result = kabo.solve(problem, geometry="none")
    document = f'<!DOCTYPE html><html data-ready="yes"><meta charset="utf-8">{result._repr_html_()}</html>'
    (tmp_path / "notebook.html").write_text(document)
    opened = open_page(tmp_path / "notebook.html")
    inner = opened.page.frame_locator("iframe[title=kabo]")
    inner.locator("html[data-ready=yes]").wait_for(state="attached")
    assert inner.locator("canvas").count() == 1
    assert opened.page.locator("table th").all_inner_texts()[0] == "outcome"
    opened.require_clean()


def test_a_plan_without_its_problem_is_a_graph_alone(open_page, tmp_path):
    plan = kabo.solve(kabo.load_problem(REPOSITORY / "domains" / "grid" / "n3.yaml")).plan
    opened = open_page(kabo.view(plan, tmp_path / "plan.html", open=False).path)
    assert opened.run("window.kabo.document.scene") is None
    assert "the problem was not given" in opened.page.locator("body").inner_text()
    opened.require_clean()
