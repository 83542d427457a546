"""Passes over all cells of the contact solvers, in NumPy and compiled by numba: ``kernels_of(operator)`` binds them."""
