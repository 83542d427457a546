"""Error bars: how far a run's values may lie from the continuum's values, beside each state of a run.

`error_bars` runs a case with them and adds up the errors of the cells, of the increments and of the iteration.
`coarse_runs` solve the case on fewer points and with fewer increments. `floors` stand for what no coarse run shows.
"""
