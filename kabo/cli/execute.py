"""`kabo execute`: carries out a plan on a robot, in physics or without forces, and logs all that happens."""

import argparse
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import Any

from kabo import service
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file
from kabo.cli.filming import Filming, add_filming
from kabo.cli.limits import add_limits
from kabo.cli.simulate import add_connection, add_physics, endpoints_of, physics_of
from kabo.cli.solving import add_problem_argument, has_scene
from kabo.cli.terminal import answer, clean_standard_output, interruptible, print_json, tell, warn
from kabo.cli.truth import add_truth, truth_of
from kabo.errors import Diagnostic, InputError, ServiceError, did_you_mean, naming

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
    add_truth(parser)
    parser.add_argument(
        "--tracking-error",
        type=_error,
        action="append",
        default=[],
        metavar="[ROBOT=]M",
        help="how far robots may be off their paths, in metres: a plan with less proven clearance is refused",
    )
    parser.add_argument(
        "--delay",
        type=bounded(0.0, 1.0, "s"),
        default=0.0,
        metavar="S",
        help="how late robots follow what they are sent, in seconds; a tenth of a second more is no surprise; "
        "simulated robots are so late",
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
        help="after a surprise go on, if a plan from where everything is now is proven (default: yes)",
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
    parser.set_defaults(needs_kernels=_needs_kernels)


def _needs_kernels(options: argparse.Namespace) -> bool:
    """Whether kernels are needed; not for what is told to be wrong at once."""
    try:
        _connection(options)
    except ServiceError:
        return False
    return options.plan.is_file() and has_scene(options.problem)


def _connection(options: argparse.Namespace) -> Any:
    """The configuration of a connection to a robot server, if there is to be one.

    Raises:
        ServiceError: it cannot be used.
    """
    return service.client_config(endpoints_of(options), options.config) if options.on == "zenoh" else None


def run(options: argparse.Namespace) -> int:
    """Carries out the plan; the exit code is 7 if it stopped before a goal."""
    report = None
    with naming(plan=options.plan), clean_standard_output():
        filming, connection = Filming(options), _connection(options)
        plan = rooms.load_plan(options.plan)
        scene = None if plan.start is None else rooms.load_scene(options.problem)
        if options.verify:
            report = rooms.verify_file(options.problem, options.plan, domain=options.domain, scene=scene)
            if not report.ok:
                answer(f"{options.plan}: {report}".rstrip("\n"))
                return exit_codes.VERIFICATION_FAILED
        sensors, hidden = truth_of(options, options.problem, options.domain, plan)
        if sensors is not None:
            rooms.require_answers(plan, sensors)
        if options.on == "zenoh" and options.truth_file is not None:
            text = "what is true there, only the robot server knows"
            raise InputError([Diagnostic("--truth-file", 1, 1, text, "give it to `kabo simulate --serve`")])
        opened = ExitStack()
        robot, judge = (None, None) if scene is None else _robot(options, scene, plan, hidden, opened, connection)
        sensor = _sensor(options, robot, sensors, hidden)
        settings = rooms.ExecutionSettings(
            tracking_error=_errors(options, scene),
            delay=options.delay,
            despite_margins=options.despite_margins,
            log_rate=_log_rate(options, filming),
        )
        recovery = _recovery(options, plan, scene) if options.recover else None
        with opened, interruptible() as stop:
            seen = filming.listener(robot)
            found = _carried_out(options, plan, scene, robot, sensor, settings, stop, recovery, report, seen)
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
    plan, scene, robot, sensor, settings, stop, recovery, report, listener = given
    with nullcontext() if options.output is None else options.output.open("w", encoding="utf-8") as file:
        log = rooms.Log(file, listener)
        if isinstance(sensor, rooms.BoundSensors):
            sensor.log = log
        return rooms.execute(plan, scene, robot, sensor, settings, log, stop, recovery, report)


def _error(text: str) -> tuple[str | None, float]:
    """A tracking error [m], and of which robot it is; None: of all."""
    robot, sign, value = text.rpartition("=")
    return (robot.strip() if sign else None), bounded(0.0, 1.0, "m")(value)


def _errors(options: argparse.Namespace, scene: "rooms.Scene | None") -> dict[str, float]:
    """The tracking error of each robot [m]; what is said of one goes before what is said of all."""
    robots = () if scene is None else tuple(scene.robots)
    stated: dict[str | None, float] = dict(options.tracking_error)
    for name in stated:
        if name is not None and name not in robots:
            hint = did_you_mean(name, robots)
            raise InputError([Diagnostic("--tracking-error", 1, 1, f'the scene has no robot "{name}"', hint)])
    return {name: stated.get(name, stated.get(None, 0.0)) for name in robots}


def _recovery(options: argparse.Namespace, plan: "rooms.Plan", scene: "rooms.Scene | None") -> Any:
    """What plans anew after a surprise; None for a plan that is of no problem, or has no motions."""
    if scene is None or rooms.kind_of_file(options.problem) == "scene":
        return None
    problem = rooms.load_problem(options.problem, options.domain)
    chosen: Any = {name: value for name, value in plan.options.items() if value is not None}
    chosen |= {"quality": "fast"}  # robots stand and wait
    return rooms.Replanner(problem, scene, chosen, rooms.Memo.of_plan(problem, plan))


def _sensor(
    options: argparse.Namespace,
    robot: Any,
    sensors: "rooms.SensorsDescription | None",
    hidden: "rooms.TruthDescription",
) -> Any:
    if sensors is None:
        return rooms.KnownTruth(hidden.answers, options.seed, dict if robot is None else robot.poses)
    if robot is not None and options.on == "zenoh":
        return rooms.RemoteSensors(sensors, robot)
    if robot is None:
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
    connection: Any,
) -> tuple[Any, Any]:
    """The robot, which may be `opened` until the run has ended, and the judge of contacts if there are any."""
    rooms.require_fit(plan, scene)
    if options.on == "zenoh":
        return opened.enter_context(rooms.ZenohRobot(connection, scene)), None
    start = rooms.Belief.at_start(scene, plan.start).state
    start = rooms.true_start(scene, start, hidden, options.seed)
    if options.on == "kinematic":
        return rooms.KinematicRobot(scene, start, rate=options.rate, delay=options.delay), None
    judge = rooms.ContactJudge(scene)
    rate, delay = options.rate, options.delay
    robot = rooms.SimulatedRobot(scene, physics_of(options), start, rate=rate, masses=hidden.masses, delay=delay)
    robot.judge = judge.look
    for doubt in robot.doubts:
        warn(f"in the simulation {doubt}")
    return robot, judge


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
