"""Carry out each command. In come its options, out goes its exit code; errors are raised. For example::

    run_case(Path("case.yaml"), None, (), stop, overwrite=True)

The modules here load what their command needs, so `fretsolve.cli` imports each of them only when it is called.
"""
