"""Wear: the surfaces change by what is rubbed off, one solved cycle standing for many.

In come the law of wear, the fields at the end of a solved cycle and the number of cycles that it stands for; out comes
the worn depth of each cell, by which the separation of the surfaces grows. For example::

    law = WearLaw("energy", alpha=1e-7)
    depth = law.depth(energy_density, slip_path, pressure)
"""
