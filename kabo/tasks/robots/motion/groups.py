"""Groups of objects that are attached to each other and move as one.

A group's root is attached to something else.
"""

from kabo.arrays import Array
from kabo.scene import Attachment, attachment
from kabo.scene.transforms import inverse, transform
from kabo.tasks.robots.scenes import TaskScene


def hung(scene: TaskScene, name: str, parent: str, world_T_parent: Array) -> TaskScene:
    """The scene in which an object, with its whole group, is attached to a parent at the pose it has now.

    Args:
        scene: the scene before the change.
        name: the object; it becomes the root of its group.
        parent: `world`, `robot.link` or another object.
        world_T_parent: the pose (4, 4) of the parent.
    """
    changes: dict[str, Attachment] = {name: attachment(parent, inverse(world_T_parent) @ scene.pose(name))}
    child, own = name, scene.situation.attachment(name)
    while own.parent in scene.situation.objects:  # reverse each attachment from the object up to the old root
        above = own.parent
        before = scene.situation.attachment(above)
        changes[above] = attachment(child, inverse(transform(own.position, own.quaternion)))
        child, own = above, before
    return scene.having(changes)
