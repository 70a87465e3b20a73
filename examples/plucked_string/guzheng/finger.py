"""A plectrum on a soft finger, led along a path across a string: what it drags, and when that slips off.

The plane across the string, at rest at (0, 0): y along the pluck, z up [T Fig. 4.3]. The finger is a spring between
the path and the tip. A string that the tip meets is dragged along until it slips over the tip.
"""

from dataclasses import dataclass

import numpy as np

from guzheng.instrument import Guzheng, String

DIRECTIONS = ("in", "out")
STEP = 0.001  # of the simulation [s]
START, END = (-0.008, 0.004), (0.025, 0.012)  # of each path: before and above, behind and above [m]
DEPTH = -0.004  # delta_z, the height of the waypoint [m]
VELOCITY = (0.03, 0.06)  # rho, with which the tip passes the waypoint [m/s]
DIVE, RISE = 0.25, 0.25  # from the start to the waypoint, and on to the end [s]


@dataclass(frozen=True)
class Finger:
    """A finger with its plectrum."""

    stiffness: float = 200.0  # [N/m]
    repeatability: float = 0.0004  # of the arm, across and up, standard deviation [m]
    placing: float = 0.002  # of the arm, along the string, standard deviation [m]
    grip: float = 0.0002  # how far the tip has to be below a string to hold it [m]
    slip: float = 0.00015  # how much farther by newton of pull: the tip is round [m/N]


@dataclass(frozen=True)
class Release:
    """What really happened: a string slipped off the tip."""

    string: String
    share: float  # where on the string
    time: float  # [s] from the start of the path
    force: float  # that was released [N]


def path(deflection: float) -> np.ndarray:
    """The path (N, 2) of the tip through the waypoint (deflection, DEPTH) with VELOCITY, in steps of STEP [m] [T e6].

    Two cubics in time, at rest at start and end: to be rising at the waypoint the tip dives below it before.
    """
    waypoint = np.array([deflection, DEPTH])
    dive = _cubic(np.array(START), waypoint, np.zeros(2), np.array(VELOCITY), DIVE)
    rise = _cubic(waypoint, np.array(END), np.array(VELOCITY), np.zeros(2), RISE)
    return np.vstack([dive, rise])


def _cubic(p: np.ndarray, q: np.ndarray, from_p: np.ndarray, to_q: np.ndarray, duration: float) -> np.ndarray:
    """The points (N, 2) of a cubic Hermite spline between two places with given velocities, without its last."""
    t = np.arange(0.0, 1.0, STEP / duration)[:, None]
    here, there = 2 * t**3 - 3 * t**2 + 1, 3 * t**2 - 2 * t**3
    return here * p + there * q + duration * ((t**3 - 2 * t**2 + t) * from_p + (t**3 - t**2) * to_q)


@dataclass(frozen=True)
class _Obstacle:
    """A string in the way of the tip, at a place of the plane."""

    string: String
    share: float
    y: float
    z: float
    stiffness: float


def pluck(
    instrument: Guzheng,
    finger: Finger,
    string: str,
    direction: str,
    eta: float,
    deflection: float,
    rng: np.random.Generator,
) -> tuple[list[Release], np.ndarray]:
    """The strings that slip off the tip, in the order of time, and the pull (N,) at the finger in each step [N].

    The arm repeats a path with an error drawn anew from `rng`, besides its constant one.
    """
    off_y, off_z, off_x = rng.normal(0.0, (finger.repeatability, finger.repeatability, finger.placing))
    return _drag(_obstacles(instrument, string, direction, eta, off_x), path(deflection) + (off_y, off_z), finger)


def _obstacles(instrument: Guzheng, name: str, direction: str, eta: float, off_x: float) -> list[_Obstacle]:
    """The string itself and, if there is one, its neighbour behind."""
    string, (y, z) = instrument.strings[name], instrument.biases[name, direction].at(eta)
    eta = eta + off_x / (string.reach * string.length)
    found = [_Obstacle(string, string.share(eta), y, z, string.stiffness(eta))]
    behind = instrument.neighbour(name, direction)
    if behind is not None:
        other, distance, height = behind
        found.append(_Obstacle(other, other.share(eta), y + distance, z + height, other.stiffness(eta)))
    return found


def _drag(obstacles: list[_Obstacle], command: np.ndarray, finger: Finger) -> tuple[list[Release], np.ndarray]:
    """Leads the tip along a path; at most one string is on it at a time."""
    releases, pulls = [], np.zeros(len(command))
    held: _Obstacle | None = None
    before = float(command[0, 0])  # where the tip was
    for step, (y, z) in enumerate(command.tolist()):
        tip = y
        if held is None:
            held = next((o for o in obstacles if before <= o.y < y and z < o.z - finger.grip), None)
        if held is not None:
            overlap = max(0.0, y - held.y)
            give = finger.stiffness / (finger.stiffness + held.stiffness)  # the share that the string takes
            pull = held.stiffness * give * overlap
            if overlap == 0.0:
                held = None
            elif held.z - z < finger.grip + finger.slip * pull:
                releases.append(Release(held.string, held.share, step * STEP, pulls[step - 1]))
                tip, held = held.y + give * overlap, None
            else:
                pulls[step] = pull
                tip = held.y + give * overlap
        before = tip
    return releases, pulls
