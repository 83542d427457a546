"""The keys of a case file, a module for each part of the file. In come values with units, out come frozen models.

from fretsolve.case.keys.friction_spec import FrictionSpec
FrictionSpec.model_validate(0.3).coefficient
"""
