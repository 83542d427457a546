"""The command line. In come arguments, out goes an exit code.

It reads options, calls a function of `fretsolve.cli.commands`, and prints errors on one line.

    fretsolve run cases/mode1_similar.yaml --set friction=0.2
"""
