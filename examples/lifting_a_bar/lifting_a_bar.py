"""Trials of a lift in MuJoCo (extra `simulation`): a parallel gripper takes a bar of unknown balance, and lifts it.

kabo explore run exploration.yaml --stages lifting_a_bar.py --trials 120 -o model.jsonl

What is valid is not written here: the bar slips, turns between the pads or bears what presses on it, as friction and
contact have it. The test of this file compares that with the statics of a bar between two pads.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.trials import Invalid, Valid, register

LENGTH, WIDTH, HEIGHT = 0.30, 0.02, 0.06  # of every bar [m]; it lies along x, on its narrow side
PAD = (0.012, 0.015)  # half length along the bar and half height of a finger's pad [m]
LIFT = 0.10  # how far the hand rises [m]
STEP = 0.002  # of the simulation [s]
CLOSED, PRESSED, RISING, RISEN, READING, END = (0.2, 0.4, 0.45, 1.05, 1.4, 1.5)  # when a lift's phases end [s]
TOUCH = 1.0  # force with which the fingers close before they press [N]
HANGING = np.radians(10.0)  # a bar that is tilted farther hangs [rad]
DROPPED = LIFT / 2  # a bar that is raised less is dropped [m]
# Standard deviations of what no robot does twice alike.
ALONG_ERROR, FORCE_ERROR, TORQUE_ERROR = 0.001, 0.03, 0.01  # [m], share of the force, [Nm]
RESOLUTION = 1e-4  # of the torque sensor at the wrist [Nm]

HOLD = """
<mujoco model="lifting a bar">
  <option timestep="{step}" cone="elliptic" impratio="10" integrator="implicitfast" gravity="0 0 -9.81"/>
  <default><geom condim="3" solref="0.005 1" friction="0.3 0 0"/></default>
  <worldbody>
    <geom name="table" type="plane" size="1 1 0.1"/>
    <body name="bar" pos="0 0 {middle}">
      <freejoint/>
      <geom name="bar" type="box" size="{half} {thin} {middle}" mass="{shell}"/>
      <geom name="lead" type="box" size="0.022 0.008 0.025" pos="{lead} 0 0" mass="{shell}" contype="0" conaffinity="0"/>
    </body>
    <body name="hand" pos="0 0 {middle}">
      <joint name="along" type="slide" axis="1 0 0"/>
      <joint name="up" type="slide" axis="0 0 1" damping="20"/>
      <geom type="box" size="0.03 0.06 0.02" pos="0 0 0.1" mass="0.5" contype="0" conaffinity="0"/>
      <site name="wrist"/>
      <body name="left" pos="0 0.036 0">
        <joint name="left" type="slide" axis="0 -1 0" range="0 0.04" damping="20"/>
        <geom name="left" type="box" size="{pad_x} 0.006 {pad_z}" friction="{friction} 0 0" mass="0.05"/>
        <site name="pad" type="box" size="{pad_x} 0.008 {pad_z}"/>
      </body>
      <body name="right" pos="0 -0.036 0">
        <joint name="right" type="slide" axis="0 1 0" range="0 0.04" damping="20"/>
        <geom name="right" type="box" size="{pad_x} 0.006 {pad_z}" friction="{friction} 0 0" mass="0.05"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="along" kp="5000" kv="100"/>
    <position joint="up" kp="5000" kv="200"/>
    <motor joint="left"/>
    <motor joint="right"/>
  </actuator>
  <sensor><torque site="wrist"/><touch site="pad"/></sensor>
</mujoco>
"""


@dataclass(frozen=True)
class Bar:
    """What nobody can see of a bar: a tube, with lead hidden somewhere inside."""

    mass: float  # with the lead, half of which it is [kg]
    balance: float  # where it balances, from its middle [m]
    friction: float  # between it and the pads
    bears: float  # the force between the pads at which its wall gives way [N]


@dataclass(frozen=True)
class Lifted:
    """What is sensed of one lift, without noise."""

    torque: float  # about y at the wrist; positive where the bar's heavier end is towards -x [Nm]
    tilt: float  # of the bar, up at its +x end [rad]
    middle: tuple[float, float]  # of the bar, x and z [m]
    raised: float  # how far the place between the pads has come up with the hand [m]
    pressed: float  # the greatest force on a pad [N]


BARS = {
    "steel": Bar(mass=0.80, balance=0.031, friction=0.60, bears=34.0),
    "wood": Bar(mass=0.35, balance=-0.022, friction=0.75, bears=15.0),
}


def lift(case: Mapping[str, str], parameters: Mapping[str, float], seed: int) -> Valid | Invalid:
    """The torque at the wrist [Nm] of a bar that is held level, or the reason why it is not.

    Raises:
        ValueError: there is no such bar.
        ImportError: MuJoCo is not installed.
    """
    if case["bar"] not in BARS:
        raise ValueError(f'there is no bar "{case["bar"]}"; there are {", ".join(BARS)}')
    return trial(BARS[case["bar"]], parameters["along"], parameters["force"], seed)


def trial(bar: Bar, along: float, force: float, seed: int) -> Valid | Invalid:
    """A lift with the errors of a robot, which `seed` draws: of the place [m], of the force [N], of the reading [Nm]."""
    place, share, reading = np.random.default_rng(seed).normal(0.0, (ALONG_ERROR, FORCE_ERROR, TORQUE_ERROR))
    found = simulate(bar, along + place, force * (1.0 + share))
    return fault(bar, found) or Valid(
        {"torque": round(round((found.torque + reading) / RESOLUTION) * RESOLUTION, 6)}
    )


def fault(bar: Bar, found: Lifted) -> Invalid | None:
    """Why a lift is not valid; None: the bar is whole, and held level."""
    if found.pressed > bar.bears:
        return Invalid("crushed", f"pressed with {found.pressed:.1f} N")
    if found.raised < DROPPED:
        return Invalid("dropped", f"raised by {1e3 * found.raised:.0f} mm")
    if abs(found.tilt) > HANGING:
        return Invalid("hanging", f"tilted by {np.degrees(abs(found.tilt)):.0f} deg")
    return None


def simulate(bar: Bar, along: float, force: float) -> Lifted:
    """What comes of a lift without any error: the fingers close, press, rise and hold."""
    mujoco = _mujoco()
    model = mujoco.MjModel.from_xml_string(_described(bar))
    data = mujoco.MjData(model)
    data.qpos[model.joint("along").qposadr[0]] = along
    torques, pressed = [], 0.0
    for number in range(round(END / STEP)):
        time = number * STEP
        press = TOUCH + (force - TOUCH) * _risen(time, CLOSED, PRESSED)
        data.ctrl[:] = along, LIFT * _risen(time, RISING, RISEN), press, press
        mujoco.mj_step(model, data)
        pressed = max(pressed, float(data.sensordata[3]))
        if time >= READING:
            torques.append(float(data.sensordata[1]))
    axis, (x, _, z) = data.body("bar").xmat.reshape(3, 3)[:, 0], data.body("bar").xpos
    raised = float(z + along * axis[2] - HEIGHT / 2)
    tilt = float(np.arctan2(axis[2], axis[0]))
    return Lifted(float(np.mean(torques)), tilt, (float(x), float(z)), raised, pressed)


def _described(bar: Bar) -> str:
    return HOLD.format(
        step=STEP,
        half=LENGTH / 2,
        thin=WIDTH / 2,
        middle=HEIGHT / 2,
        shell=bar.mass / 2,
        lead=2 * bar.balance,
        pad_x=PAD[0],
        pad_z=PAD[1],
        friction=bar.friction,
    )


def _risen(time: float, begin: float, end: float) -> float:
    """From 0 to 1 between two times, without a jump in speed."""
    share = min(1.0, max(0.0, (time - begin) / (end - begin)))
    return share * share * (3.0 - 2.0 * share)


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise ImportError('lifting a bar needs MuJoCo: pip install "kabo[simulation]"') from error
    return mujoco


register(lift, "lifting_a_bar/Lift")
