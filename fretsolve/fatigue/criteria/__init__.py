"""The criteria. In come stresses (steps, 6, points) over a closed cycle, out comes a parameter at each point.

    from fretsolve.fatigue.criteria.by_name import fatigue_field
    field = fatigue_field("findley", material, stresses)
    field.value.max(), field.normal[:, field.worst]

They know nothing of contact or files.
"""
