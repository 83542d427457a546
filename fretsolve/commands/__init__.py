"""The work of each command. In come its options, out goes its exit code; errors are raised.

    run_case(RunOptions(Path("case.yaml"), None, (), False, False, 1, False), stop)
"""
