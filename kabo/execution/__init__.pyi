from kabo.execution.following import Follower as Follower
from kabo.execution.kinematic import KinematicRobot as KinematicRobot
from kabo.execution.motions import Motion as Motion
from kabo.execution.motions import motion_of as motion_of
from kabo.execution.motions import parts_of as parts_of
from kabo.execution.protocols import Robot as Robot
from kabo.execution.protocols import RobotState as RobotState
from kabo.execution.protocols import Sensor as Sensor
