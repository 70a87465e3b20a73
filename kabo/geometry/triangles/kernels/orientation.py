"""Exact orientation: on which side of a plane a point lies, with the sign 0 only if it is exactly on the plane.

A floating-point determinant decides where it exceeds its own rounding bound; else the volume is summed up without
rounding, as an expansion: doubles that do not overlap, smallest first [Shewchuk 1997]. Nothing is rounded where
coordinates are 0 or of magnitude 1e-80 to 1e80. Callers compile their callees again, so functions are few and
small.

`scratch` is (SCRATCH_SIZE,) f8; its contents before and after do not matter.
"""

from kabo.compilation import lean_kernel

SCRATCH_SIZE = 256
VOLUME_ERROR = (
    7.771561172376103e-16  # (7 + 56 u) u, u = 2^-53: of the sum of all |products| [Shewchuk 1997, fig. 21]
)
_START = 30  # place of the expansion in scratch: before it 12 coordinates and 9 differences as sums of two


@lean_kernel  # f8, f8 -> f8
def _product_error(a, b):
    """The rounding error of a * b [Dekker 1971], without a fused multiply-add."""
    split = 134217729.0 * a  # 2^27 + 1
    a_high = split - (split - a)
    a_low = a - a_high
    split = 134217729.0 * b
    b_high = split - (split - b)
    b_low = b - b_high
    return a_low * b_low - (((a * b - a_high * b_high) - a_low * b_high) - a_high * b_low)


@lean_kernel  # (SCRATCH_SIZE,) f8, i8, f8 -> i8
def _grow(scratch, count, value):
    """Adds a number to the expansion without rounding; returns the number of its components, none of them zero."""
    kept = 0
    for i in range(count):
        term = scratch[_START + i]
        total = value + term
        taken = total - value
        error = (value - (total - taken)) + (term - taken)
        if error != 0.0:
            scratch[_START + kept] = error
            kept += 1
        value = total
    if value != 0.0:
        scratch[_START + kept] = value
        kept += 1
    return kept


@lean_kernel  # (SCRATCH_SIZE,) f8 with a, b, c, d at 0..11 -> i8
def _exact_orientation(scratch):
    """The sign of `orientation` without rounding, from the exact sum of the determinant's six products."""
    for i in range(9):
        a, d = scratch[i], -scratch[9 + i % 3]
        total = a + d
        taken = total - a
        scratch[12 + 2 * i], scratch[13 + 2 * i] = total, (a - (total - taken)) + (d - taken)
    count = 0
    for code in range(48):
        first, step, sign = (code >> 3) % 3, 1 if code < 24 else 2, -1.0 if code < 24 else 1.0
        x = sign * scratch[12 + 2 * first + (code & 1)]
        y = scratch[18 + 2 * ((first + step) % 3) + ((code >> 1) & 1)]
        z = scratch[24 + 2 * ((first + 2 * step) % 3) + ((code >> 2) & 1)]
        if x == 0.0 or y == 0.0 or z == 0.0:
            continue
        for part in range(4):
            factor = x * y if part < 2 else _product_error(x, y)
            count = _grow(scratch, count, factor * z if part % 2 == 0 else _product_error(factor, z))
    if count == 0:
        return 0
    return 1 if scratch[_START + count - 1] > 0.0 else -1


@lean_kernel  # (N, 3) f8 [m], i8 x 4 -> i8
def likely_orientation(points, a, b, c, d):
    """The sign that `orientation` computes if rounding cannot change it, else 0 for "undecided"."""
    dx, dy, dz = points[d, 0], points[d, 1], points[d, 2]
    adx, ady, adz = points[a, 0] - dx, points[a, 1] - dy, points[a, 2] - dz
    bdx, bdy, bdz = points[b, 0] - dx, points[b, 1] - dy, points[b, 2] - dz
    cdx, cdy, cdz = points[c, 0] - dx, points[c, 1] - dy, points[c, 2] - dz
    bc, cb, ca, ac, ab, ba = bdx * cdy, cdx * bdy, cdx * ady, adx * cdy, adx * bdy, bdx * ady
    volume = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba)
    products = (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    if volume > VOLUME_ERROR * products:
        return -1
    return 1 if volume < -VOLUME_ERROR * products else 0


@lean_kernel  # (N, 3) f8 [m], i8 x 4, (SCRATCH_SIZE,) f8 -> i8
def orientation(points, a, b, c, d, scratch):
    """The exact sign, 1, 0 or -1, of the volume (b - a) x (c - a) . (d - a): 1 where d lies in front of a, b, c.

    a, b, c and d are rows of `points`. The front is the side to which the normal of the counter-clockwise triangle
    a, b, c points.
    """
    sign = likely_orientation(points, a, b, c, d)
    if sign != 0:
        return sign
    for k in range(3):
        scratch[k], scratch[3 + k] = points[a, k], points[b, k]
        scratch[6 + k], scratch[9 + k] = points[c, k], points[d, k]
    return _exact_orientation(scratch)
