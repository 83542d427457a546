"""The case file. In comes a YAML file with its overrides, out comes a frozen `Case` in mm, N, MPa, rad.

Every mistake is a `CaseError` with its line. Only pydantic and YAML are loaded, for dimensions not even these.

    from fretsolve.case.loading import load_case
    case = load_case("cases/mode1_similar.yaml", ["friction=0.2", "stage.2.increments=20"])
"""
