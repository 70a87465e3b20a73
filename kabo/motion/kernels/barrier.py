"""The fastest time law by a barrier method whose linear systems are solved by a recursion over the cells of the grid.

Unknown are x and g = x' at nodes 1 … N - 1 and w = x'' in cells 1 … N - 2: x_{i+1} = x_i + h g_i + h² w_i / 2 and
g_{i+1} = g_i + h w_i. In the first cell the jerk is constant from rest, so x ~ s^(4/3) and g_1 = 4/3 x_1 / h_0; in the
last cell likewise. The time of the motion is convex in x, limits of velocity and acceleration are linear, and a limit of
jerk is sqrt(x) |c| <= 1 with c linear: of the Hessian of its barrier, -log(1 - x c²), the negative part is left out.
Newton's steps minimise a quadratic function under linear dynamics: a Riccati recursion [Rao, Wright, Rawlings 1998].
"""

import numpy as np

from kabo.compilation import kernel

DECREASE = 0.02  # of the weight of the barrier, when a minimum is near
NEAR, ROUGHLY = 0.5, 20.0  # promised decreases below which a minimum is near: at the last weight, and before
PATIENCE = 12  # Newton steps at one weight, at most
TINY = 1e-280


@kernel  # Rows, (N + 1,) f8 x 2, (N,) f8, f8 -> f8
def merit(rows, x, g, w, weight):
    """The time divided by the weight, plus the barriers of all limits; infinite outside the limits."""
    h, last = rows.h, len(rows.h) - 1
    if not x[1] > 0.0 or not x[last] > 0.0:
        return np.inf
    time, logs, product = 3.0 * h[0] / np.sqrt(x[1]) + 3.0 * h[last] / np.sqrt(x[last]), 0.0, 1.0
    gravity = rows.held[0, 0, 0], rows.held[0, 0, 1], rows.held[0, 0, 2]
    for i in range(1, last + 1):
        if not x[i] > 0.0:
            return np.inf
        slack = 1.0 - x[i] / rows.cap[i]
        if not slack > 0.0:
            return np.inf
        product *= slack
        for r in range(rows.node_start[i], rows.node_start[i + 1]):
            c = rows.node_rows[r, 0] * x[i] + rows.node_rows[r, 1] * g[i]
            slack = 1.0 - c * c
            if not slack > 0.0:
                return np.inf
            product *= slack
        if len(rows.held) > 1:
            total = 0.0
            for k in range(3):
                v = rows.held[i, 1, k] * x[i] + rows.held[i, 0, k] * g[i] - gravity[k]
                total += v * v
            slack = 1.0 - total
            if not slack > 0.0:
                return np.inf
            product *= slack
        if product < 1e-100:
            logs, product = logs - np.log(max(product, TINY)), 1.0
        if i == last:
            break
        middle = x[i] + 0.5 * h[i] * g[i] + 0.125 * h[i] * h[i] * w[i]
        slack = 1.0 - middle / rows.middle_cap[i]
        if not middle > 0.0 or not slack > 0.0:
            return np.inf
        product *= slack
        quarter = x[i] + 0.25 * h[i] * g[i] + 0.03125 * h[i] * h[i] * w[i]
        later = x[i] + 0.75 * h[i] * g[i] + 0.28125 * h[i] * h[i] * w[i]
        if not quarter > 0.0 or not later > 0.0:
            return np.inf
        ends = 1.0 / np.sqrt(x[i]) + 1.0 / np.sqrt(max(x[i + 1], TINY))
        inner = 32.0 / np.sqrt(quarter) + 12.0 / np.sqrt(middle) + 32.0 / np.sqrt(later)
        time += h[i] * (7.0 * ends + inner) / 90.0
        for r in range(rows.cell_start[i], rows.cell_start[i + 1]):
            for e in range(2):
                row = rows.cell_rows[r, e]
                c = row[0] * x[i + e] + row[1] * g[i + e] + row[2] * w[i]
                slack = 1.0 - x[i + e] * c * c
                if not slack > 0.0:
                    return np.inf
                product *= slack
            row = rows.cell_rows[r, 2]
            c = row[0] * x[i] + row[1] * g[i] + row[2] * w[i]
            slack = 1.0 - c * c
            if not slack > 0.0:
                return np.inf
            product *= slack
            if product < 1e-100:
                logs, product = logs - np.log(max(product, TINY)), 1.0
    return time / weight + logs - np.log(max(product, TINY))


@kernel  # (3,) f8, (6,) f8, f8 x 5 -> none
def add_square(q, m, a, b, c, first, second):
    """Adds `first` (a, b, c) to a gradient, and `second` times its outer product to a Hessian xx xg gg xw gw ww."""
    q[0] += first * a
    q[1] += first * b
    q[2] += first * c
    m[0] += second * a * a
    m[1] += second * a * b
    m[2] += second * b * b
    m[3] += second * a * c
    m[4] += second * b * c
    m[5] += second * c * c


@kernel  # Rows, (N + 1,) f8 x 2, (N,) f8, f8, (N, 3) f8, (N, 6) f8 -> none
def derivatives(rows, x, g, w, weight, q, m):
    """Writes gradient and Hessian of `merit` by (x, g, w) of each node and cell; of the last node by (x, g)."""
    h, last = rows.h, len(rows.h) - 1
    q[:] = 0.0
    m[:] = 0.0
    for end in range(2):
        i = 1 if end == 0 else last
        size = 3.0 * (h[0] if end == 0 else h[last]) / weight
        root = np.sqrt(x[i])
        q[i, 0] -= 0.5 * size / (x[i] * root)
        m[i, 0] += 0.75 * size / (x[i] * x[i] * root)
    for i in range(1, last + 1):
        s = rows.cap[i] - x[i]
        q[i, 0] += 1.0 / s
        m[i, 0] += 1.0 / (s * s)
        for r in range(rows.node_start[i], rows.node_start[i + 1]):
            a, b = rows.node_rows[r, 0], rows.node_rows[r, 1]
            c = a * x[i] + b * g[i]
            s = 1.0 - c * c
            add_square(q[i], m[i], a, b, 0.0, 2.0 * c / s, (2.0 + 4.0 * c * c / s) / s)
        if len(rows.held) > 1:
            total, a, b = 0.0, 0.0, 0.0
            for k in range(3):
                v = rows.held[i, 1, k] * x[i] + rows.held[i, 0, k] * g[i] - rows.held[0, 0, k]
                total += v * v
                a += v * rows.held[i, 1, k]
                b += v * rows.held[i, 0, k]
            s = 1.0 - total
            add_square(q[i], m[i], a, b, 0.0, 2.0 / s, 4.0 / (s * s))
            for k in range(3):
                add_square(q[i], m[i], rows.held[i, 1, k], rows.held[i, 0, k], 0.0, 0.0, 2.0 / s)
        if i == last:
            break
        hi = h[i]
        # The time of a cell by Boole's rule.
        for place in range(5):
            t = 0.25 * place * hi
            value = x[i] + t * g[i] + 0.5 * t * t * w[i]
            size = (12.0 if place == 2 else 32.0 if place % 2 == 1 else 7.0) * hi / 90.0 / weight
            root = np.sqrt(value)
            first, second = -0.5 * size / (value * root), 0.75 * size / (value * value * root)
            if place == 2:
                s = rows.middle_cap[i] - value
                first, second = first + 1.0 / s, second + 1.0 / (s * s)
            add_square(q[i], m[i], 1.0, t, 0.5 * t * t, first, second)
        for r in range(rows.cell_start[i], rows.cell_start[i + 1]):
            row = rows.cell_rows[r, 2]
            if row[1] != 0.0 or row[0] != 0.0:
                c = row[0] * x[i] + row[1] * g[i] + row[2] * w[i]
                s = 1.0 - c * c
                add_square(q[i], m[i], row[0], row[1], row[2], 2.0 * c / s, (2.0 + 4.0 * c * c / s) / s)
            for e in range(2):
                row = rows.cell_rows[r, e]
                value = x[i + e]
                c = row[0] * value + row[1] * g[i + e] + row[2] * w[i]
                s = 1.0 - value * c * c
                # By (x, g, w) of the left end.
                t = e * hi
                ca, cb, cc = row[0], row[1] + t * row[0], row[2] + t * row[1] + 0.5 * t * t * row[0]
                ea, eb, ec = 1.0, t, 0.5 * t * t
                k = 2.0 * value * c
                ga, gb, gc = k * ca + c * c * ea, k * cb + c * c * eb, k * cc + c * c * ec
                add_square(q[i], m[i], ga, gb, gc, 1.0 / s, 1.0 / (s * s))
                k = c / value
                add_square(q[i], m[i], ca + k * ea, cb + k * eb, cc + k * ec, 0.0, 2.0 * value / s)


@kernel  # (N,) f8, (N, 3) f8, (N, 6) f8, (N, 4) f8, (N + 1,) f8 x 2, (N,) f8 -> f8
def newton_step(h, q, m, gains, dx, dg, dw):
    """Writes the Newton step, and returns the decrease that the quadratic model promises, doubled."""
    last = len(h) - 1
    pa, pb, pc, va, vb = m[last, 0], m[last, 1], m[last, 2], q[last, 0], q[last, 1]
    for i in range(last - 1, 0, -1):
        t = h[i]
        u = 0.5 * t * t
        # Stage and cost to go by (x, g, w): x' = x + t g + u w, g' = g + t w.
        xx = m[i, 0] + pa
        xg = m[i, 1] + pa * t + pb
        gg = m[i, 2] + t * t * pa + 2.0 * t * pb + pc
        xw = m[i, 3] + pa * u + pb * t
        gw = m[i, 4] + (pa * t + pb) * u + (pb * t + pc) * t
        ww = m[i, 5] + u * u * pa + 2.0 * u * t * pb + t * t * pc
        qx = q[i, 0] + va
        qg = q[i, 1] + t * va + vb
        qw = q[i, 2] + u * va + t * vb
        if i == last - 1:  # the last w is what the last cell needs: tau x' + g' = 0
            tau = 4.0 / (3.0 * h[last])
            below = tau * u + t
            ka, kb, k0 = -tau / below, -(tau * t + 1.0) / below, 0.0
        else:
            ka, kb, k0 = -xw / ww, -gw / ww, -qw / ww
        gains[i, 0], gains[i, 1], gains[i, 2] = ka, kb, k0
        va, vb = qx + ka * qw + (xw + ka * ww) * k0, qg + kb * qw + (gw + kb * ww) * k0
        pa, pb, pc = (
            xx + 2.0 * ka * xw + ka * ka * ww,
            xg + ka * gw + kb * xw + ka * kb * ww,
            gg + 2.0 * kb * gw + kb * kb * ww,
        )
    tau = 4.0 / (3.0 * h[0])
    step = -(va + tau * vb) / (pa + 2.0 * tau * pb + tau * tau * pc)
    dx[1], dg[1] = step, tau * step
    slope = 0.0
    for i in range(1, last):
        dw[i] = gains[i, 0] * dx[i] + gains[i, 1] * dg[i] + gains[i, 2]
        slope += q[i, 0] * dx[i] + q[i, 1] * dg[i] + q[i, 2] * dw[i]
        dx[i + 1] = dx[i] + h[i] * dg[i] + 0.5 * h[i] * h[i] * dw[i]
        dg[i + 1] = dg[i] + h[i] * dw[i]
    slope += q[last, 0] * dx[last] + q[last, 1] * dg[last]
    return -slope


@kernel  # Rows, f8, i8 -> (N + 1,) f8 x 2, (N,) f8, i8
def fastest_law(rows, precision, most):
    """x, g and w of a law whose time is longer than the least by a share of about `precision`, and the Newton steps made.

    The number of steps is -1 if no law was found that keeps the limits.
    """
    h = rows.h
    cells, last = len(h), len(h) - 1
    x, g, w = np.zeros(cells + 1), np.zeros(cells + 1), np.zeros(cells)
    # A parabola that fits both ends: x = (p + s)(q + way - s).
    way = 0.0
    for i in range(1, last):
        way += h[i]
    p, r = 0.75 * h[0], 0.75 * h[last]
    for _ in range(20):
        p = 1.0 / (4.0 / (3.0 * h[0]) + 1.0 / (r + way))
        r = 1.0 / (4.0 / (3.0 * h[last]) + 1.0 / (p + way))
    size = 1.0
    for tries in range(400):
        s = 0.0
        for i in range(1, cells):
            x[i], g[i] = size * (p + s) * (r + way - s), size * (r + way - p - 2.0 * s)
            w[i] = -2.0 * size if i < last else 0.0
            s += h[i]
        if np.isfinite(merit(rows, x, g, w, 1.0)):
            break
        size *= 0.25
        if tries == 399:
            return x, g, w, -1
    size *= 0.5
    for i in range(1, cells):
        x[i], g[i], w[i] = 0.5 * x[i], 0.5 * g[i], 0.5 * w[i]
    q, m, gains = np.zeros((cells, 3)), np.zeros((cells, 6)), np.zeros((cells, 4))
    dx, dg, dw = np.zeros(cells + 1), np.zeros(cells + 1), np.zeros(cells)
    tx, tg, tw = np.zeros(cells + 1), np.zeros(cells + 1), np.zeros(cells)
    time = merit(rows, x, g, w, 1e-30) * 1e-30
    weight, steps, patience = time / (4.0 * cells), 0, 0
    now = merit(rows, x, g, w, weight)
    while steps < most:
        derivatives(rows, x, g, w, weight, q, m)
        promise = newton_step(h, q, m, gains, dx, dg, dw)
        steps, patience = steps + 1, patience + 1
        share = 1.0
        moved = False
        for _ in range(40):
            for i in range(1, cells):
                tx[i], tg[i], tw[i] = x[i] + share * dx[i], g[i] + share * dg[i], w[i] + share * dw[i]
            new = merit(rows, tx, tg, tw, weight)
            if new <= now - 0.05 * share * promise:
                moved = True
                break
            share *= 0.5
        if moved:
            now = new
            x[:] = tx
            g[:] = tg
            w[:] = tw
        limit = NEAR if weight * 2.0 * cells <= precision * time else ROUGHLY
        if promise < limit or not moved or patience >= PATIENCE:
            time = merit(rows, x, g, w, 1e-30) * 1e-30
            if weight * 2.0 * cells <= precision * time:
                break
            weight, patience = weight * DECREASE, 0
            now = merit(rows, x, g, w, weight)
    return x, g, w, steps
