"""A box tree over triangles, with queries for the nearest triangle.

The tree is `boxes` (N, 6) lower and upper corners, `children` (N, 2), and the triangles (T, 3, 3) in the order of the
leaves; a leaf n has children (-1 - first triangle, count).
"""

from kabo.compilation import lean_kernel

LEAF_TRIANGLES = 4  # in a leaf at most
THIN_SQUARED_SINE = 1e-6  # of the angle at a corner: in thinner triangles the usual formulas cancel


@lean_kernel  # 6 f8 -> f8
def _segment_squared(x, y, z, ux, uy, uz):
    """The squared distance of the origin to the segment from (x, y, z) along u."""
    length = ux * ux + uy * uy + uz * uz
    part = 0.0
    if length > 0.0:
        part = min(max(-(x * ux + y * uy + z * uz) / length, 0.0), 1.0)
    x, y, z = x + part * ux, y + part * uy, z + part * uz
    return x * x + y * y + z * z


@lean_kernel  # 9 f8 -> f8
def _thin_squared(ax, ay, az, ux, uy, uz, vx, vy, vz):
    """The squared distance of the origin to a thin triangle: to its sides, or to its plane if it projects inside."""
    best = min(_segment_squared(ax, ay, az, ux, uy, uz), _segment_squared(ax, ay, az, vx, vy, vz))
    best = min(best, _segment_squared(ax + ux, ay + uy, az + uz, vx - ux, vy - uy, vz - uz))
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = nx * nx + ny * ny + nz * nz
    if area > 0.0:
        s = -((ay * vz - az * vy) * nx + (az * vx - ax * vz) * ny + (ax * vy - ay * vx) * nz) / area
        t = -((uy * az - uz * ay) * nx + (uz * ax - ux * az) * ny + (ux * ay - uy * ax) * nz) / area
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            x, y, z = ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz
            best = min(best, x * x + y * y + z * z)
    return best


@lean_kernel  # 9 f8 -> f8
def origin_squared(ax, ay, az, bx, by, bz, cx, cy, cz):
    """The squared distance of the origin to the triangle a, b, c [Ericson 2005, 5.1.5].

    The distance is that of a point with barycentric coordinates within [0, 1]: their errors make it larger, never
    smaller.
    """
    ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    d1, d2 = -(ux * ax + uy * ay + uz * az), -(vx * ax + vy * ay + vz * az)
    if d1 <= 0.0 and d2 <= 0.0:
        return ax * ax + ay * ay + az * az
    d3, d4 = -(ux * bx + uy * by + uz * bz), -(vx * bx + vy * by + vz * bz)
    if d3 >= 0.0 and d4 <= d3:
        return bx * bx + by * by + bz * bz
    d5, d6 = -(ux * cx + uy * cy + uz * cz), -(vx * cx + vy * cy + vz * cz)
    if d6 >= 0.0 and d5 <= d6:
        return cx * cx + cy * cy + cz * cz
    uu, vv, uv = d1 - d3, d2 - d6, d2 - d4
    if uu * vv - uv * uv <= THIN_SQUARED_SINE * uu * vv:
        return _thin_squared(ax, ay, az, ux, uy, uz, vx, vy, vz)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    s, t = 0.0, 0.0
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s = d1 / (d1 - d3) if d1 != d3 else 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6) if d2 != d6 else 0.0
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        whole = (d4 - d3) + (d5 - d6)
        t = (d4 - d3) / whole if whole != 0.0 else 0.0
        s = 1.0 - t
    else:
        whole = va + vb + vc
        if whole > 0.0:
            s = min(max(vb / whole, 0.0), 1.0)
            t = min(max(vc / whole, 0.0), 1.0 - s)
    x, y, z = ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz
    return x * x + y * y + z * z


@lean_kernel  # f8 x 3, (T, 3, 3) f8, i8 -> f8
def to_triangle_squared(x, y, z, triangles, t):
    """The squared distance of a point to triangle t."""
    ax, ay, az = triangles[t, 0, 0] - x, triangles[t, 0, 1] - y, triangles[t, 0, 2] - z
    bx, by, bz = triangles[t, 1, 0] - x, triangles[t, 1, 1] - y, triangles[t, 1, 2] - z
    cx, cy, cz = triangles[t, 2, 0] - x, triangles[t, 2, 1] - y, triangles[t, 2, 2] - z
    return origin_squared(ax, ay, az, bx, by, bz, cx, cy, cz)


@lean_kernel  # f8 x 3, (V, 3) f8, (F, 3) i8, i8 -> f8
def to_face_squared(x, y, z, vertices, faces, f):
    """The squared distance of a point to face f."""
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    ax, ay, az = vertices[a, 0] - x, vertices[a, 1] - y, vertices[a, 2] - z
    bx, by, bz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
    cx, cy, cz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
    return origin_squared(ax, ay, az, bx, by, bz, cx, cy, cz)


@lean_kernel  # (T, 3, 3) f8, (T,) i8, i8, i8, (N, 6) f8, i8 -> nothing
def _bound(triangles, order, first, end, boxes, node):
    """Writes the box of a range of triangles."""
    for r in range(3):
        boxes[node, r] = boxes[node, 3 + r] = triangles[order[first], 0, r]
    for i in range(first, end):
        t = order[i]
        for c in range(3):
            for r in range(3):
                value = triangles[t, c, r]
                if value < boxes[node, r]:
                    boxes[node, r] = value
                if value > boxes[node, 3 + r]:
                    boxes[node, 3 + r] = value


@lean_kernel  # (T,) f8, (T,) i8, i8, i8, i8 -> nothing
def _split(keys, order, first, end, middle):
    """Reorders triangles so that no key before `middle` exceeds one from there on [Hoare 1961]; equal keys by index."""
    low, high = first, end - 1
    while low < high:
        pivot = order[(low + high) // 2]
        value = keys[pivot]
        i, j = low, high
        while i <= j:
            while keys[order[i]] < value or (keys[order[i]] == value and order[i] < pivot):
                i += 1
            while keys[order[j]] > value or (keys[order[j]] == value and order[j] > pivot):
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@lean_kernel
def build_tree(triangles, order, keys, boxes, children, stack):
    """Fills boxes (2 T, 6), children (2 T, 2) and order (T,), which starts as 0 … T-1; returns the number of nodes.

    keys (T,) f8 and stack (128, 3) i8 are scratch.
    """
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, triangles.shape[0]
    top, nodes = 1, 1
    while top > 0:
        top -= 1
        node, first, end = stack[top, 0], stack[top, 1], stack[top, 2]
        _bound(triangles, order, first, end, boxes, node)
        children[node, 0], children[node, 1] = -1 - first, end - first
        if end - first <= LEAF_TRIANGLES:
            continue
        axis = 0
        for r in range(1, 3):
            if boxes[node, 3 + r] - boxes[node, r] > boxes[node, 3 + axis] - boxes[node, axis]:
                axis = r
        for i in range(first, end):
            t = order[i]
            keys[t] = triangles[t, 0, axis] + triangles[t, 1, axis] + triangles[t, 2, axis]
        middle = (first + end) // 2
        _split(keys, order, first, end, middle)
        children[node, 0], children[node, 1] = nodes, nodes + 1
        stack[top, 0], stack[top, 1], stack[top, 2] = nodes + 1, middle, end
        stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = nodes, first, middle
        top, nodes = top + 2, nodes + 2
    return nodes


@lean_kernel  # (N, 6) f8, i8, f8 x 3 -> f8
def to_box_squared(boxes, n, x, y, z):
    """The squared distance of a point to box n."""
    dx = max(0.0, max(boxes[n, 0] - x, x - boxes[n, 3]))
    dy = max(0.0, max(boxes[n, 1] - y, y - boxes[n, 4]))
    dz = max(0.0, max(boxes[n, 2] - z, z - boxes[n, 5]))
    return dx * dx + dy * dy + dz * dz


@lean_kernel
def nearest_triangle(tree, x, y, z, hint, enough, stack):
    """The squared distance to the nearest triangle, and its index; stops at any squared distance up to `enough`.

    `hint`: the index of the triangle that is tested first; it affects the speed only. stack (64,) i8.
    """
    boxes, children, triangles = tree.boxes, tree.children, tree.triangles
    best, found = to_triangle_squared(x, y, z, triangles, hint), hint
    if best <= enough:
        return best, found
    stack[0], top = 0, 1
    while top > 0:
        top -= 1
        n = stack[top]
        if to_box_squared(boxes, n, x, y, z) >= best:
            continue
        first, second = children[n, 0], children[n, 1]
        if first < 0:
            for t in range(-1 - first, -1 - first + second):
                squared = to_triangle_squared(x, y, z, triangles, t)
                if squared < best:
                    best, found = squared, t
            if best <= enough:
                break
        else:
            near, far = first, second
            if to_box_squared(boxes, far, x, y, z) < to_box_squared(boxes, near, x, y, z):
                near, far = far, near
            stack[top], stack[top + 1] = far, near
            top += 2
    return best, found
