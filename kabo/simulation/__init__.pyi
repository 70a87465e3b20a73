from kabo.simulation.judging import ContactJudge as ContactJudge
from kabo.simulation.mjcf import Motor as Motor
from kabo.simulation.mjcf import PhysicsModel as PhysicsModel
from kabo.simulation.mjcf import physics_model as physics_model
from kabo.simulation.physics import Contact as Contact
from kabo.simulation.physics import Physics as Physics
from kabo.simulation.settings import PhysicsSettings as PhysicsSettings
from kabo.simulation.simulated_robot import SimulatedRobot as SimulatedRobot
