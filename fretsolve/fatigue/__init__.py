"""Fatigue parameters of a cycle of stresses, and where they are largest.

In come stresses (steps, 6, points) in MPa, in the order xx, yy, zz, xy, xz, yz, and a `Material`; out come values with
critical planes. They know nothing of contact or files. For example::

    field = criterion("findley", material).field(stresses)
    field.value.max(), field.normal[:, field.value.argmax()]
"""
