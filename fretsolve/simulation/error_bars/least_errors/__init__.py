"""The least errors of the discretisation: what no coarse run shows.

`least_errors` adds them up for an increment: those of `zone_errors`, `hidden_pressure`, `unseen_slip`, `thin_shear`,
`moments` and `map_holes`.
"""
