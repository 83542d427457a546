"""Carry out each command. In come its options, out goes its exit code; errors are raised.

run_case(Path("case.yaml"), None, (), stop, overwrite=True)
"""
