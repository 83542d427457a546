"""The pictures, by their concept. In comes a result, out comes a figure, as `fretsolve.post.plots` says.

from fretsolve.post.plots.pictures.histories import loop
figure = loop(result)
"""
