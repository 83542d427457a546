"""The work of each command; `fretsolve.cli.main` has their options and turns errors into exit codes."""
