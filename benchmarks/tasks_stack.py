"""The whole stack measured by one task [T 3.10]: pick and place over several runs, every stage by itself.

The reports are those of `kabo task plan --repeat`; two of them, of two versions, are compared by

    kabo task compare BEFORE/stack-NAME.json AFTER/stack-NAME.json
"""

from pathlib import Path
from statistics import fmean, median

from table import Table
from tasks_applications import applications

from kabo.tasks import load_task_file
from kabo.tasks.files.report_form import report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import PlanningOptions, plan_file


def stack_tables(robots: list[str], runs: int, output: Path) -> list[Table]:
    """A table for each robot, and its report in the output folder."""
    tables = []
    for application in applications("pick_and_place", robots, "panda.yaml"):
        file = load_task_file(application.task)
        plan_file(file, {}, application.scene, PlanningOptions(max_solutions=1, seed=1000))  # compiles
        made = plan_file(file, {}, application.scene, PlanningOptions(max_solutions=1, repeat=runs))
        path = output / f"stack-{application.scene.name}.json"
        path.write_bytes(report_bytes(report(made, file=application.task.name)))
        table = Table(f"Pick and place, first solution, {application.scene.name}: {runs} runs, {path}")
        for name in made[0].task.statistics:
            figures = [run.task.statistics[name] for run in made]
            costs = [cost for each in figures for cost in each.costs]
            table.add(
                name,
                calls=fmean(each.calls for each in figures),
                **{"ms a call": 1e3 * sum(f.seconds for f in figures) / max(1, sum(f.calls for f in figures))},
                s=fmean(each.seconds for each in figures),
                successes=fmean(each.successes for each in figures),
                failures=fmean(sum(each.failures.values()) for each in figures),
                cost=fmean(costs) if costs else None,
            )
        table.add("whole", s=median(run.seconds for run in made), successes=fmean(len(r.found) for r in made))
        tables.append(table)
    return tables
