"""The pictures, by their concept. In comes a result, out comes a figure, as `fretsolve.plots` says.

from fretsolve.plots.pictures.histories import loop
figure = loop(result)
"""
