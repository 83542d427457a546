"""The cycles of a result. In come its history and the stages of its load path, out comes a table, a row per cycle.

from fretsolve.result.cycles.table import cycle_table
table = cycle_table(history, stages_of(case), slip, ended=True)
"""
