"""The data of an exploration: trials, parameters to try next, parameters for a wanted outcome."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Case = Mapping[str, str]  # variable: value, such as {"string": "d4"}
Parameters = Mapping[str, float]  # in their own units
Target = Mapping[str, float | Literal["least", "most"]]  # outcome: the wanted value, or its extreme


@dataclass(frozen=True)
class Validity:
    """How the validity of parameters is modelled.

    Attributes:
        scale: λ_v, the length of V's kernel: the distance over which trials say something about each other, as a share of
            the parameters' bounds; 0.12 suits two parameters, 0.2 three or more.
        noise: the standard deviation of a single answer, valid (+1) or not (-1).
        alpha: V must be greater than this for parameters to be tried [T 4.4].
    """

    scale: float = 0.12
    noise: float = 0.15
    alpha: float = 0.7


@dataclass(frozen=True)
class Trial:
    """One trial: what was tried, whether it was valid, and its outcomes or the reason why it was not [T e7].

    Attributes:
        outcomes: outcome: value, of a valid trial; else empty.
        reason: a word for why the trial is invalid; else empty.
    """

    case: Case
    parameters: Parameters
    valid: bool
    outcomes: Mapping[str, float] = field(default_factory=dict)
    reason: str = ""


@dataclass(frozen=True)
class Question:
    """Parameters to try next, and V there, the probability that they are valid."""

    case: Case
    parameters: Parameters
    validity: float


@dataclass(frozen=True)
class Inferred:
    """Parameters for a wanted outcome.

    Attributes:
        validity: V, the probability that they are valid.
        expected: outcome: its expected value.
        deviation: outcome: the standard deviation of the next observation.
    """

    case: Case
    parameters: Parameters
    validity: float
    expected: Mapping[str, float]
    deviation: Mapping[str, float]
