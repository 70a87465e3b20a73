"""A scene in motion: MuJoCo steps it, and motors follow setpoints by computed torque.

Each motor gets the torque that gives its joint the acceleration of the setpoint, and a correction of what it is off: a
spring and damper, critically damped [Siciliano et al. 2009, section 8.5.2]. A hand that grips presses with a force
instead, whatever its width.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import settled
from kabo.scene import Scene
from kabo.scene.state import GeometricState
from kabo.simulation.hands import Hand, spread_of
from kabo.simulation.kernels.bias import Moving, add_point_mass
from kabo.simulation.kernels.friction import Contacts, Touches, complete_friction, no_contacts
from kabo.simulation.kernels.motors import Joints, Setpoints, drive, press, wanted_accelerations
from kabo.simulation.masses import mass_of_body
from kabo.simulation.mjcf import Motor, PhysicsModel, physics_model
from kabo.simulation.mujoco_library import model_from, mujoco, tree_of
from kabo.simulation.settings import USUAL, PhysicsSettings
from kabo.simulation.touching import Contact, RestingContacts
from kabo.simulation.turning_fingers import (
    FINGERS,
    Finger,
    TurningFingers,
    arms_when_open,
    levers_in_contact,
    middles_of_fingers,
    turns,
)

STIFFNESS = 100.0  # [1/s]: natural frequency of the correction
GRIP_DAMPING = 20.0  # [N s/m], of a hand that presses
IDENTITY = np.eye(4)
WAKING = 1e-9  # [m/s]: MuJoCo wakes what sleeps when its velocity is written, and not when something lets go of it
TOUCHING = 0.0  # [m]: contacts with a greater gap carry no force


class Physics:
    """A scene in physics, at first as it is at its start.

    Args:
        scene: the scene.
        settings: what the model needs beyond it.
        start: where everything is at first; None: as the scene says.
        masses: true masses of bodies [kg], of which the controller knows nothing; of others the scene's are true.
    """

    def __init__(
        self,
        scene: Scene,
        settings: PhysicsSettings = USUAL,
        start: GeometricState | None = None,
        masses: Mapping[str, float] | None = None,
    ) -> None:
        self.scene, self.settings = scene, settings
        self.description: PhysicsModel = physics_model(scene, settings, start)
        self._mujoco = mujoco()
        self.model = model_from(self.description.xml)
        self._make_true(masses or {})
        self.data = self._mujoco.MjData(self.model)
        self._index()
        self.place((start or scene.start).robots)
        self._load_kernels()

    def _load_kernels(self) -> None:
        """Loads what is called when a hand presses: to load it takes longer than a robot server may be silent."""
        for hand in self._hands.values():
            self._press(hand, np.zeros(len(self._rates)))
            self._add_load(hand.carrier, np.zeros(3), 0.0)
        self._complete_friction(no_contacts())

    def _make_true(self, masses: Mapping[str, float]) -> None:
        """Gives bodies their true masses, spread as before."""
        model = self.model
        for body, mass in masses.items():
            number = model.body(body).id
            model.body_inertia[number] *= mass / model.body_mass[number]
            model.body_mass[number] = mass
        if masses:
            self._mujoco.mj_setConst(model, self._mujoco.MjData(model))

    @property
    def time(self) -> float:
        """The simulated time [s]."""
        return float(self.data.time)

    @property
    def motors(self) -> tuple[Motor, ...]:
        """The motors, in the order of setpoints."""
        return self.description.motors

    def _index(self) -> None:
        model, motors = self.model, self.motors
        followers = [(k, *other) for k, motor in enumerate(motors) for other in motor.followers]
        names = [motor.name for motor in motors] + [name for _, name, _, _ in followers]
        self._values = np.array([model.joint(name).qposadr[0] for name in names], np.int64)
        self._rates = np.array([model.joint(name).dofadr[0] for name in names], np.int64)
        self._leader = np.array([*range(len(motors)), *(k for k, *_ in followers)], np.int64)
        self._ratio = np.array([1.0] * len(motors) + [ratio for *_, ratio, _ in followers])
        self._shift = np.array([0.0] * len(motors) + [shift for *_, shift in followers])
        self._limits = np.array([np.inf if motor.effort is None else motor.effort for motor in motors])
        self._number = {(motor.robot, motor.joint): k for k, motor in enumerate(motors)}
        self._thing = [self.description.things.get(model.geom(k).name, "") for k in range(model.ngeom)]
        self._hands = {name: hand for name in self.scene.robots if (hand := self._hand(name)) is not None}
        self._presses = np.zeros(len(self._hands), np.int64)  # 1 if it does
        count = len(motors)
        self.setpoint, self.speed, self.change = np.zeros(count), np.zeros(count), np.zeros(count)
        self._wanted, self._torques = np.zeros(model.nv), np.zeros(model.nv)
        self._own = {}  # of each robot, where its joints are among positions and velocities
        for name, own in self.scene.robots.items():
            mine = [self._number[name, joint] for joint in own.joint_names]
            self._own[name] = self._values[mine], self._rates[mine]
        self._numbers: dict[str, int] = {}  # of bodies of the model
        self._commanded: dict[tuple[str, tuple[str, ...]], Integers] = {}  # the motors of some joints of a robot
        self._expected = {
            name: float(mass_of_body(self.scene.bodies[name], self.settings).mass) for name in self.scene.movable
        }
        self._scratch, self._gravity = np.empty((6, 3)), np.array(model.opt.gravity)
        self._tree, self._touches, self._resting = tree_of(model), self._touching(), RestingContacts(model)
        data = self.data
        self._driven = Joints(self._values, self._rates, self._leader, self._ratio, self._shift)
        self._setpoints = Setpoints(self.setpoint, self.speed, self.change)
        self._moving = Moving(
            data.qvel, data.cvel, data.cdof, data.cdof_dot, data.subtree_com, data.xpos, data.xmat
        )
        self._positions, self._bias, self._passive = data.qpos, data.qfrc_bias, data.qfrc_passive  # views
        # The arrays of a model stay the same:
        self._want, self._drive, self._push = settled(wanted_accelerations), settled(drive), settled(press)
        self._bear, self._complete = settled(add_point_mass), settled(complete_friction)
        self._outputs = self._limits, self.model.actuator_gainprm[:, 0], data.ctrl, data.qfrc_applied

    def _touching(self) -> Touches:
        """What belongs to hands, and what is movable."""
        model = self.model
        named = [model.body(k).name for k in range(model.nbody)]
        hand = np.full(model.nbody, -1)
        for number, robot in enumerate(self._hands):
            gripper = self.scene.robots[robot].gripper
            links = set(gripper.touch_links) if gripper else set()
            hand[[name in links for name in named]] = number
        free = np.array([name in self.scene.movable for name in named], np.int64)
        return Touches(model.geom_bodyid.astype(np.int64), hand, free)

    def _hand(self, name: str) -> Hand | None:
        robot = self.scene.robots[name]
        if robot.gripper is None:
            return None
        tree, motors, levers = robot.tree, [], []
        joints = {joint: robot.joint_names.index(joint) for joint in robot.gripper.joints}
        moved = [
            j for j in range(1, len(tree.parent)) if tree.ratio[j] != 0.0 and tree.source[j] in joints.values()
        ]
        for joint, source in joints.items():
            closing = np.sign(robot.gripper.closed.get(joint, 0.0) - robot.gripper.open.get(joint, 0.0))
            shares = [abs(tree.ratio[j]) for j in moved if tree.source[j] == source]
            motors.append(self._number[name, joint])
            levers.append(closing * sum(shares) / max(FINGERS, len(moved)))  # virtual work: each bears its share
        carrier = robot.links[
            robot.tool.frame if robot.tool else robot.gripper.touch_links[0].partition(".")[2]
        ].joint
        number = self.model.body(f"{name}:{robot.model.names[carrier]}").id
        spread, dampings = spread_of(motors, self._leader, self._ratio), np.full(len(motors), GRIP_DAMPING)
        opened = np.array([robot.gripper.open.get(joint, 0.0) for joint in joints])
        rates = self._rates[motors], self._rates[spread[0]]
        armatures = self.model.dof_armature[rates[1]].copy()
        hand = Hand(motors, np.array(levers), number, dampings, *spread, opened, *rates, armatures)
        if turns(robot):
            hand.turning = turning = self._turning(name, motors, np.sign(levers))
            hand.levers = np.sign(levers) * turning.arms / FINGERS
            hand.dampings = hand.dampings * turning.arms**2
        return hand

    def _turning(self, name: str, motors: list[int], closing: Array) -> TurningFingers:
        """The fingers of a hand that turns, as they are when it is open."""
        robot, data = self.scene.robots[name], self._mujoco.MjData(self.model)
        assert robot.gripper is not None
        motions = np.zeros((len(motors), self.model.nv))
        for row, (motor, sign) in enumerate(zip(motors, closing, strict=True)):
            own = np.flatnonzero(self._leader == motor)
            motions[row, self._rates[own]] = sign * self._ratio[own]
            opened = robot.gripper.open.get(self.motors[motor].joint, 0.0)
            data.qpos[self._values[own]] = self._ratio[own] * opened + self._shift[own]
        self._mujoco.mj_kinematics(self.model, data)
        self._mujoco.mj_comPos(self.model, data)
        fingers = [Finger(self.model.body(link).id, place) for link, place in middles_of_fingers(robot)]
        arms = arms_when_open(self._mujoco, self.model, data, fingers, motions)
        return TurningFingers(tuple(fingers), motions, arms)

    def place(self, robots: Mapping[str, tuple[float, ...]]) -> None:
        """Puts robots at configurations at once, at rest."""
        for name, values in robots.items():
            for joint, value in zip(self.scene.robots[name].joint_names, values, strict=True):
                self.setpoint[self._number[name, joint]] = value
        self.speed[:] = 0.0
        self.change[:] = 0.0
        self.data.qpos[self._values] = self._ratio * self.setpoint[self._leader] + self._shift
        self.data.qvel[self._rates] = 0.0
        self._mujoco.mj_forward(self.model, self.data)
        self._stale = False

    def command(self, robot: str, joints: tuple[str, ...], setpoint: Array, speed: Array, change: Array) -> None:
        """The setpoint of some joints for the next steps: values, velocities, accelerations."""
        found = self._commanded.get((robot, joints))
        if found is None:
            numbers = [self._number[robot, each] for each in joints]
            found = self._commanded[robot, joints] = np.array(numbers, np.int64)
        self.setpoint[found], self.speed[found], self.change[found] = setpoint, speed, change

    def grip(self, robot: str, bodies: Sequence[str] = (), force: float | None = None) -> None:
        """A hand presses from now on, with a force [N] or as its scene says.

        The controller expects the masses of the bodies in the scene in this hand, where the bodies are now: true ones may
        be others, and a controller does not know when one is lost.
        """
        gripper, hand = self.scene.robots[robot].gripper, self._hands[robot]
        hand.since = self.time if hand.pressing is None else hand.since
        hand.act(self.setpoint[hand.motors])
        self.model.dof_armature[hand.joint_rates] = hand.locked(self.settings.rotor_inertia)
        hand.pressing = force or (None if gripper is None else gripper.force) or self.settings.grip_force
        data, carrier = self.data, hand.carrier
        turn = data.xmat[carrier].reshape(3, 3)
        offsets = (data.xipos[self.model.body(body).id] - data.xpos[carrier] for body in bodies)
        hand.bodies = tuple(self.model.body(body).id for body in bodies)
        self._presses[[*self._hands].index(robot)] = 1
        hand.held = [(offset @ turn, self._expected[body]) for offset, body in zip(offsets, bodies, strict=True)]

    def release(self, robot: str) -> None:
        """A hand follows its setpoints again, from where its fingers are."""
        hand = self._hands[robot]
        hand.pressing, hand.held = None, []
        self.model.dof_armature[hand.joint_rates] = hand.armatures
        self._presses[[*self._hands].index(robot)] = 0
        self.setpoint[hand.motors] = self.data.qpos[self._values[hand.motors]]

    def pressing(self, robot: str) -> float | None:
        """The force with which a hand presses [N]; None: it does not."""
        return self._hands[robot].pressing if robot in self._hands else None

    def builds_up(self, robot: str) -> bool:
        """Whether a hand does not yet press with its whole force."""
        return robot in self._hands and self._hands[robot].builds_up(self.time)

    def weld(self, holder: str, body: str) -> None:
        """Fixes a body, as it is now, to the hand of a robot that locks, or to a part with which it holds together."""
        library, data = self._mujoco, self.data
        number = self.model.equality(f"{holder}:{body}").id
        one, other = self.model.eq_obj1id[number], self.model.eq_obj2id[number]
        back, place, turn = np.empty(4), np.empty(3), np.empty(4)
        library.mju_negQuat(back, data.xquat[one])
        library.mju_rotVecQuat(place, data.xpos[other] - data.xpos[one], back)
        library.mju_mulQuat(turn, back, data.xquat[other])
        self.model.eq_data[number, :10] = [0.0, 0.0, 0.0, *place, *turn]
        data.eq_active[number] = 1

    def unweld(self, holder: str, body: str) -> None:
        """Lets go of a body that was fixed to a hand, or to a part."""
        self.data.eq_active[self.model.equality(f"{holder}:{body}").id] = 0
        self.data.qvel[self.model.joint(body).dofadr[0]] += WAKING

    def step(self) -> None:
        """Advances by one time step."""
        library, model, data = self._mujoco, self.model, self.data
        library.mj_step1(model, data)
        joints, moving = self._driven, self._moving
        self._want(joints, self._setpoints, self._positions, moving.velocity, STIFFNESS, self._wanted)
        library.mj_mulM(model, data, self._torques, self._wanted)
        self._torques += self._bias
        self._torques -= self._passive
        for hand in self._hands.values():
            for offset, mass in hand.held:
                self._add_load(hand.carrier, offset, mass)
        each, presses = self._torques[self._rates], False
        for hand in self._hands.values():
            if hand.pressing is not None:
                self._press(hand, each)
                presses = True
        self._drive(joints, each, *self._outputs)
        if presses and not self.settings.welds:
            found = data.contact
            self._complete_friction(Contacts(found.geom, found.pos, found.frame, found.efc_address, found.dim))
        library.mj_step2(model, data)
        self._stale = True

    def is_exhausted(self, robot: str, joint: str) -> bool:
        """Whether a motor gives all that it can."""
        number = self._number[robot, joint]
        return bool(abs(self.data.ctrl[number]) >= self._limits[number])

    def needed(self, robot: str, joint: str, change: float) -> float:
        """The share of its effort that a motor needs to bear what it bears and to accelerate alone [rad/s² or m/s²]."""
        number = self._number[robot, joint]
        own = self._leader == number
        alone = np.zeros(self.model.nv)
        alone[self._rates[own]] = change * self._ratio[own]
        forces = np.zeros(self.model.nv)
        self._mujoco.mj_mulM(self.model, self.data, forces, alone)
        inert, bias = ((each[self._rates[own]] * self._ratio[own]).sum() for each in (forces, self.data.qfrc_bias))
        return float((abs(inert) + abs(bias)) / self._limits[number])

    def _levers(self, hand: Hand) -> Array:
        """The torque of each motor per newton of force, where fingers that turn touch; in the air they close as usual."""
        if hand.turning is None or not hand.bodies:
            return hand.levers
        fingers = {finger.body for finger in hand.turning.fingers}
        touching: dict[int, list[tuple[Array, Array]]] = {}
        for contact in self.data.contact:
            pair = {int(self._touches.body[contact.geom1]), int(self._touches.body[contact.geom2])}
            if contact.dist <= 0.0 and (link := pair & fingers) and pair & {*hand.bodies}:
                touching.setdefault(link.pop(), []).append((contact.pos.copy(), contact.frame[:3].copy()))
        if not touching:
            return hand.levers
        found = levers_in_contact(self._mujoco, self.model, self.data, hand.turning, touching)
        return np.where(found > 0.0, np.sign(hand.levers) * found, hand.levers)

    def _press(self, hand: Hand, torques: Array) -> None:
        """Writes the torques (K,) of the driven joints with which a hand presses."""
        damped = self._levers(hand), hand.force(self.time), hand.dampings, hand.rates, self._moving.velocity
        self._push(hand.acting, *damped, self._bias, self._passive, torques)

    def _add_load(self, carrier: int, offset: Array, mass: float) -> None:
        """Adds the torques that move what a hand holds, a point mass where the hand has taken it."""
        given = self._wanted, self._gravity, self._tree, self._moving, self._scratch, self._torques
        self._bear(carrier, offset, mass, *given)

    def _complete_friction(self, contacts: Contacts) -> None:
        """Adds what MuJoCo leaves out of the acceleration at which contacts in a hand do not slip: that of J in J q'.

        Without it what is held slips by some mm/s wherever the hand moves on a curve, however hard it presses.
        """
        given = contacts, self._touches, self._presses, self._tree, self._moving
        self._complete(*given, self.data.efc_aref, self.data.efc_KBIP, self.settings.timestep)

    def configuration(self, robot: str) -> tuple[float, ...]:
        """The values of a robot's joints, as they are."""
        return tuple(self.data.qpos[self._own[robot][0]].tolist())

    def velocities(self, robot: str) -> tuple[float, ...]:
        """The velocities of a robot's joints, as they are."""
        return tuple(self.data.qvel[self._own[robot][1]].tolist())

    def pose(self, thing: str) -> Array:
        """The pose (4, 4) of a body or `robot.link` in the world, as it is."""
        robot, dot, link = thing.partition(".")
        if dot:
            own = self.scene.robots[robot]
            joint = own.links[link].joint
            return self._pose(f"{robot}:{own.model.names[joint] if joint else ''}") @ own.links[link].joint_T_link
        return self._pose(thing)

    def _pose(self, body: str) -> Array:
        if self._stale:  # a step leaves places as they were before it
            self._mujoco.mj_kinematics(self.model, self.data)
            self._stale = False
        number = self._numbers.get(body)
        if number is None:
            number = self._numbers[body] = self.model.body(body).id
        pose = IDENTITY.copy()
        pose[:3, :3], pose[:3, 3] = self.data.xmat[number].reshape(3, 3), self.data.xpos[number]
        return pose

    def expected_mass(self, body: str) -> float:
        """The mass of a body by the scene [kg], which the controller takes it to have."""
        return self._expected[body]

    def carried(self, robot: str) -> float:
        """The mass that the wrist of a robot feels beyond its own hand [kg]: true at rest, disturbed by motion.

        It is the force between the last joint of the arm and what that carries, along gravity, as a force sensor there
        measures it: by the recursion of Newton and Euler with all forces of contact [Featherstone 2008, section 5.3].
        """
        model, data, wrist = self.model, self.data, self._hands[robot].carrier
        self._mujoco.mj_rnePostConstraint(model, data)
        gravity = np.asarray(model.opt.gravity)
        felt = -float(data.cfrc_int[wrist, 3:] @ gravity) / float(gravity @ gravity)
        return felt - float(model.body_subtreemass[wrist])

    def contacts(self, deeper: float = TOUCHING, *, resting: bool = True) -> Iterator[Contact]:
        """What touches now, deeper than a depth [m]; what sleeps touches whatever it stands on, if that is asked for."""
        found = self.data.contact
        for shapes, distances in ((found.geom, found.dist), *([self._resting.of(self.data)] if resting else [])):
            for number in np.flatnonzero(distances < -deeper):
                one, other = shapes[number]
                first, second = sorted((self._thing[one], self._thing[other]))
                yield Contact((first, second), float(-distances[number]))

    def displace(self, body: str, offset: Array) -> None:
        """Moves a body by an offset (3,) [m], as somebody who pushes it."""
        start = self.model.joint(body).qposadr[0]
        self.data.qpos[start : start + 3] += offset
        self._mujoco.mj_forward(self.model, self.data)
