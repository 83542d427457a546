"""Closed-form solutions as functions of numbers: the reference of the solvers.

In: loads in N and N mm, lengths in mm, moduli in MPa, compliances in 1/MPa, angles in rad. Out: frozen dataclasses with
radii, displacements and traction profiles. `fretsolve.problem.setup.closed_forms` finds the ones that hold for a case.

    hertz_sphere(load=400.0, radius=10.0, contact_modulus=110e3).contact_radius
"""
