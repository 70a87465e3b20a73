"""Sensors as a sensor file binds them: instruments are read, readings become answers, and looks are repeated if need be."""

from collections.abc import Mapping
from math import isfinite
from typing import Protocol, runtime_checkable

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.execution.log import Log
from kabo.execution.looks import PoseNoise
from kabo.execution.sequential import Decision, decide
from kabo.language import Measurement, SensorBinding, SensorsDescription
from kabo.plan import Plan

Reading = float | bool | str | None


class Instruments(Protocol):
    """What reads the world, once for each call: a user implements these for hardware."""

    @property
    def time(self) -> float:
        """On the robots' clock [s]."""

    def read(self, measurement: Measurement) -> Reading:
        """A weight [kg], or whether two things touch; None: that cannot be measured now."""

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) in the world of the movable bodies that are seen now."""


@runtime_checkable
class TellingInstruments(Instruments, Protocol):
    """Instruments that can say why they read nothing."""

    def why(self, measurement: Measurement) -> str | None:
        """Why there is no reading now, as the end of a sentence; None: it does not know, or there is one."""


class BoundSensors:
    """A `Sensor` that answers by the bindings of a sensor file.

    Args:
        sensors: the bindings.
        instruments: what they read.
        log: where each decision is written, with how often was looked, and its error.
    """

    def __init__(self, sensors: SensorsDescription, instruments: Instruments, log: Log | None = None) -> None:
        self.sensors, self.instruments, self.log = sensors, instruments, log
        self.decisions: dict[str, Decision] = {}
        self._looks = 0  # in the whole run

    @property
    def noise(self) -> PoseNoise | None:
        """Of the camera; None if bodies are seen as they are."""
        camera = self.sensors.camera
        exact = camera is None or camera.position == camera.angle == 0.0
        return None if exact or camera is None else PoseNoise(camera.position, camera.angle)

    @property
    def sees(self) -> tuple[str, ...] | None:
        """The bodies that the camera sees; None: all."""
        return None if self.sensors.camera is None else self.sensors.camera.bodies

    @property
    def rate(self) -> float | None:
        """Pictures of the camera a second [Hz]; None: it always sees."""
        return None if self.sensors.camera is None else self.sensors.camera.rate

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        """The outcome that is most probable after as many looks as the bound of the error needs."""
        binding = self.sensors.bindings.get(formula)
        if binding is None:
            return None
        found = self._decide(binding, outcomes)
        return found.outcome

    def value(self, term: str) -> object | None:
        """The value of a term: a number is read once, a name is decided upon."""
        binding = self.sensors.bindings.get(term)
        if binding is None:
            return None
        if binding.outcomes is not None:
            return self._decide(binding, binding.outcomes).outcome
        return self.look(binding)

    def poses(self) -> Mapping[str, Array]:
        """The bodies that are seen now."""
        return self.instruments.poses()

    def why(self, asked: str) -> str | None:
        """Why what was asked last was not measured, as the end of a sentence."""
        binding, decided = self.sensors.bindings.get(asked), self.decisions.get(asked)
        if binding is None:
            return "no sensor answers it"
        told = f"{binding.measurement.kind}({', '.join(binding.measurement.things)})"
        if isinstance(self.instruments, TellingInstruments):
            found = self.instruments.why(binding.measurement)
            if found is not None:
                return found
        if decided is not None and decided.looks > 1:
            return f"{decided.looks} looks were not enough"
        return None if binding.measurement.kind == "told" else f"there is no reading of {told}"

    def _decide(self, binding: SensorBinding, outcomes: tuple[str, ...]) -> Decision:
        wrong, error, most = binding.wrong, binding.error, binding.looks
        found = decide(lambda _: self.answer(binding, outcomes), outcomes, wrong, error, most)
        self.decisions[binding.asked] = found
        if self.log is not None:
            more = {"outcome": found.outcome, "looks": found.looks, "error": float(f"{found.error:.3g}")}
            self.log.add(self.instruments.time, "looked", asked=binding.asked, **more)
        return found

    def answer(self, binding: SensorBinding, outcomes: tuple[str, ...]) -> str | None:
        """The answer of one look."""
        found = answer_of(binding, self.look(binding))
        return found if found in outcomes else None

    def look(self, binding: SensorBinding) -> Reading:
        """What is read for a binding, once."""
        self._looks += 1
        return _finite(self.instruments.read(binding.measurement))


def _finite(reading: Reading) -> Reading:
    """A reading; of a number that is none, nothing: compared with a threshold it would say no."""
    return None if isinstance(reading, float) and not isfinite(reading) else reading


def answer_of(binding: SensorBinding, reading: Reading) -> str | None:
    """The answer to what a binding is asked, by a reading."""
    if reading is None:
        return None
    if binding.measurement.kind == "told":
        return str(reading)
    if binding.comparison == "not":
        return "false" if reading else "true"
    if binding.comparison is None:
        return "true" if reading is True else "false" if reading is False else str(reading)
    value, bound = float(reading), binding.threshold
    holds = {"<": value < bound, "<=": value <= bound, ">": value > bound, ">=": value >= bound}
    return "true" if holds[binding.comparison] else "false"


def require_answers(plan: Plan, sensors: SensorsDescription) -> None:
    """Checks that sensors answer all that a plan asks.

    Raises:
        InputError: the plan branches on formulas, or delivers terms, that no sensor answers.
    """
    asked = dict.fromkeys(name for node in plan.nodes.values() for name in node.delivers)
    asked |= dict.fromkeys(node.on for node in plan.nodes.values() if node.on is not None)
    missing = [name for name in asked if name not in sensors.bindings]
    if missing:
        hints = [did_you_mean(name, sensors.bindings) for name in missing]
        text = 'the plan asks "{}", which no sensor answers'
        raise InputError(
            [
                Diagnostic(sensors.file, 1, 1, text.format(name), hint or f"add it under `answers`: {name} when …")
                for name, hint in zip(missing, hints, strict=True)
            ]
        )
