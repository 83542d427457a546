"""The work of each command; `fretsolve.cli` has their options and turns errors into exit codes."""
