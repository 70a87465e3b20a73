"""A joint path along a straight line of the tool in one call: way points by projection, segments between them proven."""

import numpy as np

from kabo.compilation import kernel
from kabo.kinematics.kernels.motion_bounds import first_row_not_kept
from kabo.kinematics.kernels.projection import FREEZES, pull_of, pulled
from kabo.kinematics.kernels.rows import LOWER, UPPER


@kernel  # (n,) f8, f8, (R, W) f8, (R,) f8, KinematicTree, the same with limits to keep, (n,) b1, Pieces, i8, (3,) f8
def followed(start, length, rows, tolerances, tree, within, active, pieces, iterations, limits):
    """Way points (m, n) from the start on, and the shares of the line where the last one is and where the next failed.

    The first row is the progress along the line; its bounds are written. Steps are halved where they fail, down to a
    least share; if the end is reached, both shares are 1.

    Args:
        start: the configuration where the line begins.
        length: of the line [m].
        rows, tolerances: what holds along the line, and how far it may be off on proven segments.
        tree, within: the joints, and the same with the limits that way points keep.
        active: the joints that may move.
        pieces: scratch arrays of proofs.
        iterations: of a projection, at most.
        limits: the greatest change of a joint between way points, the least share of the line, ten to the decimals of
            joint values.
    """
    n, count = len(start), 1
    way, q = np.empty((16, n)), np.empty(n)
    way[0] = start
    pull = pull_of(rows, 0.0, within, active)
    here, share = 0.0, 1.0
    while here < 1.0:
        there, last = min(1.0, here + share), way[count - 1]
        q[:] = last
        for row in (pull.target.rows[0], rows[0]):
            row[LOWER], row[UPPER] = there * length, there * length
        pull.target.low[0], pull.target.high[0] = there * length, there * length
        good = pulled(q, pull, iterations, FREEZES)
        for j in range(n):
            q[j] = np.rint(q[j] * limits[2]) / limits[2]
            good = good and abs(q[j] - last[j]) <= limits[0]
        if good:
            rows[0, LOWER] = here * length
            good = first_row_not_kept(rows, tolerances, last, q, tree, pieces) < 0
        if good:
            if count == len(way):
                longer = np.empty((2 * count, n))
                longer[:count] = way
                way = longer
            way[count] = q
            count += 1
            share, here = 2.0 * (there - here), there
        else:
            share = 0.5 * (there - here)
            if share < limits[1]:
                return way[:count], here, there
    return way[:count], 1.0, 1.0
