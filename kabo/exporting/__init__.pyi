from kabo.exporting.formats import FORMATS as FORMATS
from kabo.exporting.formats import check_export as check_export
from kabo.exporting.formats import export as export
from kabo.exporting.formats import ros_trajectories as ros_trajectories
from kabo.exporting.ros_bridge import key_of_topic as key_of_topic
from kabo.exporting.ros_bridge import put_trajectory as put_trajectory
from kabo.exporting.ros_messages import RosTrajectory as RosTrajectory
from kabo.exporting.ros_messages import TrajectoryPoint as TrajectoryPoint
