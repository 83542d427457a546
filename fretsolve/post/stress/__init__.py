"""Stresses below the surface of a finished result.

In come the tractions and bulk stresses of its increments, out come the six stress components of either body at chosen
depths, and the largest stresses with error bars. No solver imports this folder. For example::

    with open_result("case.h5") as result:
        tractions = TractionHistory(result)
        request = stress_request(tractions, result.steps, bodies=(2,), depths=(0.0, 0.05))
        write_stress(tractions, request, Path("case.stress.h5"))
"""
