"""Groups: objects that hang together move as one; whoever of them is held, or hung on something, becomes the root."""

from kabo.arrays import Array
from kabo.scene import Attachment, attachment
from kabo.scene.transforms import inverse, transform
from kabo.tasks.robots.scenes import TaskScene


def hung(scene: TaskScene, name: str, parent: str, world_T_parent: Array) -> TaskScene:
    """The scene in which an object, and all that hangs together with it, hangs on a parent, where it is now.

    Args:
        scene: where everything is.
        name: the object, which becomes the root of its group.
        parent: `world`, `robot.link` or another object.
        world_T_parent: (4, 4) where that is.
    """
    changes: dict[str, Attachment] = {name: attachment(parent, inverse(world_T_parent) @ scene.pose(name))}
    child, own = name, scene.situation.attachment(name)
    while own.parent in scene.situation.objects:  # from the object up to the old root each link is turned round
        above = own.parent
        before = scene.situation.attachment(above)
        changes[above] = attachment(child, inverse(transform(own.position, own.quaternion)))
        child, own = above, before
    return scene.having(changes)
