"""What a finished result tells: stresses, fatigue parameters, exported files and pictures.

A result comes in, files and figures go out: ``fretsolve.post.plots.loop(fretsolve.open_result("case.h5"))``.
"""
