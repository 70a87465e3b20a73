from kabo.tasks.robots.catalogue import STAGES as STAGES
from kabo.tasks.robots.declaring import RobotStage as RobotStage
from kabo.tasks.robots.declaring import check_meaning as check_meaning
from kabo.tasks.robots.declaring import check_names as check_names
from kabo.tasks.robots.motion.costs import clearance as clearance
from kabo.tasks.robots.motion.costs import distance_to_reference as distance_to_reference
from kabo.tasks.robots.motion.costs import duration as duration
from kabo.tasks.robots.motion.costs import path_length as path_length
from kabo.tasks.robots.motion.costs import tool_distance as tool_distance
from kabo.tasks.robots.motion.directions import Direction as Direction
from kabo.tasks.robots.motion.exporting import changed as changed
from kabo.tasks.robots.motion.exporting import changed_between as changed_between
from kabo.tasks.robots.motion.exporting import segments as segments
from kabo.tasks.robots.motion.exporting import stretches as stretches
from kabo.tasks.robots.scenes import Stretch as Stretch
from kabo.tasks.robots.scenes import TaskScene as TaskScene
from kabo.tasks.robots.scenes import stretch as stretch
from kabo.tasks.robots.stages import *
