"""Print whether bodies can shake down elastically over the cycles whose stresses are known."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.post.fatigue.shakedown import Extent, ShakedownSearch
from fretsolve.post.fatigue.stress_cycle import StressCycles
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.cycles import CycleChoice, chosen, cycles_from_text
from fretsolve.post.stress.stress_file import bodies_of
from fretsolve.system.progress import print_warnings


def tell_shakedown_of(
    stresses: Path, choice: CycleChoice, limits: Mapping[int, float], out: Path, *, quiet: bool
) -> None:
    """Print whether elastic shakedown is possible over the chosen cycles in a file of stresses.

    limits: yield stresses of bodies; out: the file that warnings name.
    """
    try:
        search = _searched(stresses, choice, limits)
    except CaseError as error:  # the stresses are there all the same
        print_warnings(out, f"shakedown is not looked at: {error.message}")
    else:
        tell_shakedown(search, out, quiet=quiet)


def tell_shakedown(search: ShakedownSearch, out: Path, *, quiet: bool) -> None:
    """Print whether elastic shakedown is possible, as a warning where it is not; out: the file that warnings name."""
    for path in search:
        if not path.possible:
            print_warnings(out, str(path))
        elif not quiet:
            print(path)


def _searched(stresses: Path, choice: CycleChoice, limits: Mapping[int, float]) -> ShakedownSearch:
    """Return the widest paths over the chosen cycles in a file of stresses; limits: yield stresses of bodies."""
    search = ShakedownSearch(limits)
    with opened_computed(stresses) as file:
        assert file is not None  # it has just been written
        whole = cycles_from_text(file.attributes["cycles"])
        if not whole:
            raise CaseError("increments without fields are among those where a stage of a cycle begins or ends")
        cycles = chosen(whole, choice)
        for number, body in bodies_of(file).items():
            of_body = StressCycles(stresses, body, cycles)
            for depth in range(len(of_body.depths)) if number in limits else ():
                extent = Extent()
                for cycle in cycles:
                    extent.add(of_body.stress(cycle, depth))
                search.add(number, of_body, depth, extent)
    return search
