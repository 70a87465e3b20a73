"""Interface resolution: the flow of every stage, and every reason why the stages do not fit together [T 3.2, 3.3].

Between two connectors (or a border and a connector) there is exactly one generator; the stages before it run backward,
those after it forward. A section at a border at which states come in has no generator.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kabo.tasks.core.model.containers import (
    Container,
    Merger,
    Parallel,
    Serial,
    Wrapper,
    is_connector,
    is_generator,
)
from kabo.tasks.core.model.errors import InitialisationError, TaskError
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.stages import Monitor, Stage


@dataclass
class _Resolution:
    """The flows resolved so far, and the faults found."""

    flows: dict[Stage, Flow] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)

    def resolve(self, stage: Stage, wanted: Flow) -> None:
        if isinstance(stage, Serial):
            self.flows[stage] = wanted
            self._serial(stage, wanted)
        elif isinstance(stage, (Parallel, Wrapper)):
            self.flows[stage] = wanted
            self._shared(stage, wanted)
        elif wanted in stage.flows:
            self.flows[stage] = wanted
        else:
            self.errors.append(_misfit(stage, wanted))

    def _shared(self, container: Container, wanted: Flow) -> None:
        if isinstance(container, Wrapper) and len(container.children) != 1:
            self.errors.append(f"wrapper {container.path!r} holds {len(container.children)} stages, not one")
        elif not container.children:
            self.errors.append(f"container {container.path!r} is empty")
        elif isinstance(container, Merger) and not (wanted is Flow.FORWARD or wanted is Flow.BACKWARD):
            self.errors.append(f"merger {container.path!r} ({wanted.value}) can only propagate (→ → or ← ←)")
        else:
            for child in container.children:
                self.resolve(child, wanted)

    def _serial(self, container: Serial, wanted: Flow) -> None:
        sections, connectors = _sections(container)
        if not container.children:
            self.errors.append(f"container {container.path!r} is empty")
            return
        for connector in connectors:
            self.resolve(connector, Flow.CONNECT)
        for i, section in enumerate(sections):
            first, last = i == 0, i == len(sections) - 1
            from_left, from_right = first and wanted.reads_start, last and wanted.reads_end
            if from_left and from_right:
                self.errors.append(
                    f"container {container.path!r} must connect ({wanted.value}) but has no connector"
                )
                continue
            self._section(container, section, from_left, from_right, wanted)

    def _section(
        self, container: Serial, section: list[Stage], from_left: bool, from_right: bool, wanted: Flow
    ) -> None:
        generators = [stage for stage in section if is_generator(stage)]
        if from_left or from_right:
            for stage in generators:
                side = "its start" if from_left else "its end"
                self.errors.append(
                    f"{stage.path!r} (← →) generates, but {container.path!r} ({wanted.value}) gets its states at {side}"
                )
            for stage in section:
                if stage not in generators:
                    self.resolve(stage, Flow.FORWARD if from_left else Flow.BACKWARD)
            return
        if len(generators) != 1:
            self.errors.append(_not_one(container, section, generators))
            if not generators:
                return
        where = section.index(generators[0])
        for i, stage in enumerate(section):
            flow = Flow.BACKWARD if i < where else Flow.FORWARD if i > where else Flow.GENERATE
            if stage in generators:
                flow = Flow.GENERATE
            self.resolve(stage, flow)


def _sections(container: Serial) -> tuple[list[list[Stage]], list[Stage]]:
    sections: list[list[Stage]] = [[]]
    connectors = []
    for child in container.children:
        if is_connector(child):
            connectors.append(child)
            sections.append([])
        else:
            sections[-1].append(child)
    return sections, connectors


def arrows(stage: Stage) -> str:
    """The flows that a stage permits, as arrows such as `→ →`, joined with `or`; `nothing` if it permits none."""
    return " or ".join(flow.value for flow in Flow if flow in stage.flows) or "nothing"


def _misfit(stage: Stage, wanted: Flow) -> str:
    hints = {
        Flow.BACKWARD: "it stands before a generator, or after a connector without one: end that section with a "
        "generator, or take a stage that can run backward",
        Flow.FORWARD: "it stands after a generator: take a stage that can run forward",
        Flow.GENERATE: "a generator is needed here",
        Flow.CONNECT: "a connector is needed here",
    }
    run = {Flow.BACKWARD: "run backward", Flow.FORWARD: "run forward", Flow.GENERATE: "generate"}
    would = run.get(wanted, "connect")
    return f"{stage.path!r} ({arrows(stage)}) would have to {would} ({wanted.value}) here: {hints[wanted]}"


def _not_one(container: Serial, section: list[Stage], generators: list[Stage]) -> str:
    if len(generators) > 1:
        names = " and ".join(f"{stage.path!r} (← →)" for stage in generators)
        return f"{names} both generate with no connector between them in {container.path!r}"
    if not section:
        return (
            f"in {container.path!r} two connectors (→ ←) meet, or one stands at the border: a generator is missing"
        )
    if len(section) == 1:
        only = section[0]
        direction = "backward" if Flow.BACKWARD in only.flows else "forward"
        return (
            f"{only.path!r} ({arrows(only)}) has no generator in its section of {container.path!r}: alone it would "
            f"run {direction} from nothing; add a generator beside it"
        )
    names = ", ".join(f"{stage.path!r} ({arrows(stage)})" for stage in section)
    return f"{names} in {container.path!r} have no generator (← →) between them"


def directions(task: Serial) -> tuple[Mapping[Stage, Flow], list[str]]:
    """The flow of each stage for which it can be determined, and all faults; properties are not checked."""
    resolution = _Resolution()
    resolution.resolve(task, Flow.GENERATE)
    return resolution.flows, resolution.errors


def resolve(task: Serial) -> Mapping[Stage, Flow]:
    """The flow of every stage of a task, which is a serial container that generates.

    Raises:
        InitialisationError: lists every fault, also of properties and monitors; the task is unchanged.
    """
    flows, errors = directions(task)
    for stage in task.walk():
        errors.extend(stage.properties.problems())
        errors.extend(f"{stage.path!r}: {each.message}" for each in stage.misfits(stage.properties.given))
        if isinstance(stage, Monitor):
            try:
                errors.extend(_unheard(task, stage))
            except TaskError as error:
                errors.append(str(error))
    if errors:
        raise InitialisationError(errors, tree(task, flows))
    return flows


def _unheard(task: Serial, stage: Monitor) -> list[str]:
    """Why a monitoring generator could never be triggered; empty if it could."""
    heard = stage.monitored
    if heard not in task.walk():
        return [f"stage {stage.path!r} monitors {heard.path!r}, which is not here"]
    if isinstance(heard, Container) and stage in heard.walk():
        return [f"stage {stage.path!r} monitors {heard.path!r}, which waits for it; monitor a stage beside it"]
    return []


def tree(task: Container, flows: Mapping[Stage, Flow] | None = None) -> str:
    """The stages of a task as text, one per line: arrows of the flow, name, class and given properties."""
    lines = []
    depths = {id(task): 0}
    for stage in task.walk():
        depth = depths[id(stage)]
        depths.update((id(child), depth + 1) for child in stage.children)
        arrow = flows[stage].value if flows and stage in flows else "? ?" if flows is not None else arrows(stage)
        given = ", ".join(f"{key}: {shown(value)}" for key, value in sorted(_given(stage).items()))
        kind = type(stage).__name__
        lines.append(f"{'  ' * depth}{arrow}  {stage.name}  [{kind}]{'  ' + given if given else ''}")
    return "\n".join(lines)


def _given(stage: Stage) -> dict[str, object]:
    """The properties that were set on a stage and, of a monitoring generator, the path of the monitored stage."""
    given = dict(stage.properties.given)
    if isinstance(stage, Monitor):
        try:
            given["monitors"] = stage.monitored.path
        except TaskError:
            given["monitors"] = stage.monitors
    return given


def shown(value: object) -> str:
    """A property value as text for users: `{min: 0.1, by: [1, 2]}`."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {shown(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(shown(v) for v in value) + "]"
    return str(value)
