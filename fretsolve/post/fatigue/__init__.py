"""Fatigue parameters of a cycle of stresses, and where they are largest.

In comes a result, or its stresses, and the constants of a material; out comes a file of fatigue parameters. One call::

    require_fatigue(setup, free_disk)  # before a run whose case asks for them
    path = write_case_fatigue(result, case)
"""
