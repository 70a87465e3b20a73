"""`kabo execute`: carries out a plan on a robot, in physics or without forces, and logs all that happens."""

import argparse
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from kabo import service
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, natural, output_file
from kabo.cli.filming import Filming, add_filming
from kabo.cli.limits import add_limits
from kabo.cli.simulate import add_connection, add_physics, endpoints_of, physics_of
from kabo.cli.solving import add_problem_argument
from kabo.cli.terminal import answer, clean_standard_output, interruptible, print_json, tell, warn
from kabo.errors import Diagnostic, InputError

NAME = "execute"
HELP = "carry out a plan: follow its motions, sense, branch, watch; ends at the goal or in a safe stop with its reason"
SHOWN_FAULTS = 4


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo execute` to the parser."""
    add_problem_argument(parser)
    parser.add_argument("plan", type=Path, metavar="PLAN", help="the plan file")
    parser.add_argument(
        "--on",
        choices=("kinematic", "simulation", "zenoh"),
        default="kinematic",
        help="the robot: one without forces, one in physics, or that of a robot server (default: kinematic)",
    )
    add_connection(parser, "whose robots are driven")
    parser.add_argument(
        "--rate",
        type=bounded(1.0, 1000.0, "Hz"),
        default=1000.0,
        metavar="HZ",
        help="setpoints a second (default: 1000)",
    )
    parser.add_argument("--seed", type=natural, default=0, metavar="N", help="of what sensors find (default: 0)")
    parser.add_argument(
        "--truth",
        action="append",
        default=[],
        metavar="FORMULA=OUTCOME",
        help="what a sensor finds, in place of the seed; may be given several times",
    )
    parser.add_argument(
        "--sensors", type=Path, metavar="FILE", help="what answers the questions of the plan, and how well"
    )
    parser.add_argument(
        "--truth-file",
        type=Path,
        metavar="FILE",
        help="what is true and neither plan nor controller knows: masses, places, answers",
    )
    parser.add_argument(
        "--tracking-error",
        type=bounded(0.0, 1.0, "m"),
        default=0.0,
        metavar="M",
        help="how far robots may be off their paths, in metres: a plan with less proven clearance is refused",
    )
    parser.add_argument("--despite-margins", action="store_true", help="carry it out nevertheless")
    parser.add_argument(
        "--verify",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="verify the plan first, and refuse one that is not proven (default: yes)",
    )
    parser.add_argument(
        "--recover",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="after a surprise go on, if a plan from where everything is now is proven (default: yes, but not over zenoh)",
    )
    parser.add_argument(
        "--state", type=output_file, metavar="FILE", help="the state at the end, for kabo replan, as JSON"
    )
    add_physics(parser)
    parser.add_argument(
        "-o", dest="output", type=output_file, metavar="FILE", help="the log, one JSON object a line"
    )
    parser.add_argument(
        "--log-rate",
        type=bounded(0.1, 1000.0, "Hz"),
        default=20.0,
        metavar="HZ",
        help="how often the log says where everything is (default: 20)",
    )
    parser.add_argument(
        "--page",
        type=output_file,
        metavar="FILE",
        help="write a page for a browser that shows the run: errors, clearances, decisions, the true state and the plan",
    )
    add_filming(parser)
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda _: True)


def run(options: argparse.Namespace) -> int:
    """Carries out the plan; the exit code is 7 if it stopped before a goal."""
    truth = dict(map(_pair, options.truth))
    with clean_standard_output():
        filming = Filming(options)
        if options.verify:
            report = rooms.verify_file(options.problem, options.plan, domain=options.domain)
            if not report.ok:
                answer(f"{options.plan}: {report}".rstrip("\n"))
                return exit_codes.VERIFICATION_FAILED
        plan = rooms.load_plan(options.plan)
        scene = None if plan.start is None else rooms.load_scene(options.problem)
        sensors, hidden = _files(options, plan, truth)
        opened = ExitStack()
        robot, judge = (None, None) if scene is None else _robot(options, scene, plan, hidden, opened)
        sensor = _sensor(options, robot, sensors, hidden)
        settings = rooms.ExecutionSettings(
            tracking_error=options.tracking_error,
            despite_margins=options.despite_margins,
            log_rate=_log_rate(options, filming),
        )
        recovery = _recovery(options, plan, scene) if options.recover and options.on != "zenoh" else None
        with opened, interruptible() as stop:
            seen = filming.listener(robot)
            found = _carried_out(options, plan, scene, robot, sensor, settings, stop, recovery, seen)
        if options.state is not None:
            found.state.save(options.state)
        if options.page is not None:
            chosen = rooms.ViewOptions(problem=options.problem, domain=options.domain)
            made = rooms.document_of_run(found.log.records, options.plan.name, options.plan, chosen)
            rooms.write_atomically(options.page, rooms.page_of(made))
        if scene is not None:
            filming.draw(scene)
    faults = {} if judge is None else judge.faults
    if options.json:
        print_json(_body(found, faults))
    else:
        answer(_told(found, faults))
        if options.output is not None:
            tell(f"{options.output}: {rooms.counted(len(found.log.records), 'record')}")
    return exit_codes.DONE if found.reached_goal else exit_codes.STOPPED


def _log_rate(options: argparse.Namespace, filming: Filming) -> float:
    """How often the log says where everything is [Hz]: as often as whoever reads it needs."""
    read = options.output is not None or options.page is not None
    return max(options.log_rate if read else 0.0, filming.log_rate)


def _carried_out(options: argparse.Namespace, *given: Any) -> "rooms.Run":
    plan, scene, robot, sensor, settings, stop, recovery, listener = given
    with nullcontext() if options.output is None else options.output.open("w", encoding="utf-8") as file:
        log = rooms.Log(file, listener)
        if isinstance(sensor, rooms.BoundSensors):
            sensor.log = log
        return rooms.execute(plan, scene, robot, sensor, settings, log, stop, recovery)


def _recovery(options: argparse.Namespace, plan: "rooms.Plan", scene: "rooms.Scene | None") -> Any:
    """What plans anew after a surprise; None for a plan that is of no problem, or has no motions."""
    if scene is None or rooms.kind_of_file(options.problem) == "scene":
        return None
    problem = rooms.load_problem(options.problem, options.domain)
    chosen: Any = {name: value for name, value in plan.options.items() if value is not None}
    chosen |= {"quality": "fast"}  # robots stand and wait
    return rooms.Replanner(problem, scene, chosen, rooms.Memo.of_plan(problem, plan))


def _files(
    options: argparse.Namespace, plan: "rooms.Plan", answers: dict[str, str]
) -> tuple["rooms.SensorsDescription | None", "rooms.TruthDescription"]:
    """The sensors, if there is a file of them, and what is true: by its file, and by the answers of the command."""
    if options.sensors is None and options.truth_file is None:
        return None, rooms.TruthDescription(answers=answers)
    problem = rooms.load_problem(options.problem, options.domain)
    sensors = None if options.sensors is None else rooms.load_sensors(options.sensors, problem)
    if sensors is not None:
        rooms.require_answers(plan, sensors)
    if options.truth_file is None:
        return sensors, rooms.TruthDescription(answers=answers)
    hidden = rooms.load_truth(options.truth_file, problem)
    return sensors, replace(hidden, answers={**hidden.answers, **answers})


def _sensor(
    options: argparse.Namespace,
    robot: Any,
    sensors: "rooms.SensorsDescription | None",
    hidden: "rooms.TruthDescription",
) -> Any:
    if sensors is None:
        return rooms.KnownTruth(hidden.answers, options.seed, dict if robot is None else robot.poses)
    if robot is None or options.on == "zenoh":  # a robot server sees bodies, and has no other instruments
        instruments: Any = rooms.NoInstruments()
    elif options.on == "kinematic":
        instruments = rooms.KinematicInstruments(robot, hidden)
    else:
        instruments = rooms.PhysicsInstruments(robot, sensors)
    return rooms.SimulatedSensors(sensors, instruments, hidden, options.seed)


def _robot(
    options: argparse.Namespace,
    scene: "rooms.Scene",
    plan: "rooms.Plan",
    hidden: "rooms.TruthDescription",
    opened: ExitStack,
) -> tuple[Any, Any]:
    """The robot, which may be `opened` until the run has ended, and the judge of contacts if there are any."""
    rooms.require_fit(plan, scene)
    if options.on == "zenoh":
        config = service.client_config(endpoints_of(options), options.config)
        return opened.enter_context(rooms.ZenohRobot(config, scene)), None
    start = rooms.Belief.at_start(scene, plan.start).state
    start = rooms.true_start(scene, start, hidden, options.seed)
    if options.on == "kinematic":
        return rooms.KinematicRobot(scene, start, rate=options.rate), None
    judge = rooms.ContactJudge(scene)
    robot = rooms.SimulatedRobot(scene, physics_of(options), start, rate=options.rate, masses=hidden.masses)
    robot.judge = judge.look
    for doubt in robot.doubts:
        warn(f"in the simulation {doubt}")
    return robot, judge


def _pair(text: str) -> tuple[str, str]:
    formula, sign, outcome = text.rpartition("=")
    if not sign or not formula.strip() or not outcome.strip():
        hint = "write --truth 'empty(bottle_1)=true'"
        raise InputError([Diagnostic("--truth", 1, 1, f"{text!r} is no formula with its outcome", hint)])
    return formula.strip(), outcome.strip()


def _told(found: "rooms.Run", faults: dict[tuple[str, str], float]) -> str:
    followed = list(found.log.of("followed"))
    lines = [("goal" if found.reached_goal else "stopped") + f" at {found.node}: {found.reason}"]
    if followed:
        worst = 1000.0 * max(record["tracking"] for record in followed)
        lines.append(f"{found.log.records[-1]['time']:.1f} s, at most {worst:.2g} mm off the path")
    deepest = sorted(faults.items(), key=lambda each: -each[1])
    for (first, second), depth in deepest[:SHOWN_FAULTS]:
        lines.append(f"{first} and {second} touched, which no segment permits ({1000 * depth:.2g} mm deep)")
    return "\n".join(lines)


def _body(found: "rooms.Run", faults: dict[tuple[str, str], float]) -> dict[str, Any]:
    return {
        "reached_goal": found.reached_goal,
        "reason": found.reason,
        "node": found.node,
        "history": [{"node": node, "outcome": outcome} for node, outcome in found.history],
        "contacts": [{"between": list(pair), "depth": depth} for pair, depth in sorted(faults.items())],
        "log": found.log.records,
    }
