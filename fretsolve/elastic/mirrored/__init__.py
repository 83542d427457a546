"""The elastic operator on one half of fields that are mirror images of themselves about y = 0.

In: the half y > 0 of p, qx (even in y) and qy (odd). Out: that of uz, ux and uy. For example
``MirroredOperator((nx, ny // 2), (dx, dy), compliances, terms).normal(pressure, uz)``.
"""
