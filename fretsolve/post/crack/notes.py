"""Say in lines what a crack lacks, what to know of its numbers, and what to be warned of."""

from __future__ import annotations

from collections.abc import Mapping

from fretsolve.post.crack.analysis import Crack
from fretsolve.post.crack.request import CrackRequest
from fretsolve.post.fatigue.stress_cycle import not_closed
from fretsolve.post.stress.cycles import whole_path_note


def missing_of(crack: Crack) -> list[str]:
    """Return a line for each thing that cannot be computed, with the key that is missing."""
    material, growth, found = crack.material, crack.growth, []
    lacking = [name for name in ("threshold_range", "fatigue_range") if getattr(material, name) is None]
    if lacking:
        found.append(f"no verdict: the material lacks {' and '.join(lacking)}")
    if material.paris is None:
        found.append("no propagation and total life: the material lacks paris")
    elif growth.end is None and material.toughness is None:
        found.append("no propagation and total life: toughness of the material, or a final length, is missing")
    elif growth.end is None:
        found.append(
            f"no propagation and total life: K_I stays below the toughness up to b = {crack.lengths[-1]:.4g} mm; a"
            " final length gives an end"
        )
    if crack.missing_curve:
        found.append(f"no initiation and total life: the material lacks {crack.missing_curve}")
    return found


def notes_of(crack: Crack, request: CrackRequest, *, line: bool, worn: bool) -> list[str]:
    """Return what else is to be said of a crack, a line each. line: of a line contact; worn: with wear."""
    found = []
    closed = crack.K[0] <= 0.0
    if closed.any():
        found.append(
            "where K_I <= 0 the crack is closed, and K_II is an upper bound: contact of its faces is not solved"
        )
    decisive = [one for one in (crack.growth.first, crack.growth.arrest) if one]
    if decisive and min(decisive) < crack.cell:
        found.append(
            f"cracks shorter than a cell, {crack.cell:.3g} mm, decide: they see the steps of the tractions, as their"
            " error bars say"
        )
    if not line:
        row = "the row through the place" if request.at == "max" else "the row through the middle of the contact"
        found.append(
            f"the stress is that of {row}: K is an estimate for a crack through the width, and an upper bound for a"
            " thumbnail crack"
        )
    if len(crack.cycles) > 1:
        found.append("the range is the largest of the cycles, K the one of all their increments")
    if crack.growth.life is not None:
        found.append("error bars are those of the cells; the constants of a material scatter by far more")
    if worn:
        found.append("wear: tractions are those of the worn contact, on a half-space that is flat")
    return found


def warnings_of(crack: Crack, request: CrackRequest) -> list[str]:
    """Return warnings about a crack, a line each."""
    whole = crack.cycles[0].number == 0
    notes = whole_path_note(crack.cycles), not_closed(crack.opening, whole_path=whole)
    found = [note for note in notes if note is not None]
    limit = None if request.thickness is None else 0.1 * request.thickness
    reached = _longest_that_matters(crack)
    if limit is not None and reached > limit:
        found.append(
            f"b up to {reached:.4g} mm counts, more than a tenth of the thickness {request.thickness:g} mm: the body is"
            " no half-plane for such a crack, and K is too small"
        )
    return found


def _longest_that_matters(crack: Crack) -> float:
    """Return the length at which life ends or the crack stops, else the longest one (mm)."""
    growth: Mapping[str, float] = crack.values
    if crack.verdict in ("arrests", "no crack"):
        return growth["arrest_length"]
    return growth.get("final_length", float(crack.lengths[-1]))
