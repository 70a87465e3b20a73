"""Messages on the keys that zenoh-bridge-ros2dds maps to topics of ROS 2.

The bridge takes the payload of a sample as the bytes that DDS sends, with the four bytes of their encapsulation, and
writes them to the topic whose name is the key, once a node of ROS on its side subscribes to this topic. It reads neither
an encoding nor an attachment [eclipse-zenoh/zenoh-plugin-ros2dds 1.9, route_subscriber.rs, ros2_utils.rs].
"""

import re
from typing import Any

from kabo.exporting.ros_messages import RosTrajectory

_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")


def key_of_topic(topic: str, namespace: str = "/") -> str:
    """The key of a topic: its full name without the first slash, below the bridge's `namespace`.

    Raises:
        ValueError: a name is no full name of ROS, such as `/arm_controller/joint_trajectory`.
    """
    for name in (topic, *([] if namespace == "/" else [namespace])):
        if not _NAME.fullmatch(name) or "__" in name:
            raise ValueError(f"{name!r} is no full name of ROS: write it as /arm_controller/joint_trajectory")
    return (topic if namespace == "/" else namespace + topic).lstrip("/")


def put_trajectory(session: Any, topic: str, message: RosTrajectory, namespace: str = "/") -> None:
    """Puts a message on the key of a topic, reliably: it is not dropped when the network is busy.

    Args:
        session: an open `zenoh.Session`.
        topic: the full name of the topic.
        message: the message.
        namespace: as the bridge is configured.

    Raises:
        ValueError: the name is no full name of ROS.
    """
    import zenoh

    session.put(
        key_of_topic(topic, namespace),
        message.to_cdr(),
        encoding=zenoh.Encoding.APPLICATION_CDR,
        congestion_control=zenoh.CongestionControl.BLOCK,
    )
