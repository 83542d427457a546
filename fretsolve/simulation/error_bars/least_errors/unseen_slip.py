"""Slip that no cell shows: within roundings, at sharp edges, and in annuli of unlike bodies pressed together."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.edges import Edge
from fretsolve.model.required_terms import Model
from fretsolve.result.state import State
from fretsolve.setup.closed_forms import spence_ratio
from fretsolve.simulation.error_bars.shear_path import UNSHEARED, ShearPath
from fretsolve.system.arrays import DoubleArray

HIDDEN_SLIP = 0.56
"""Energy that slip within the cells at a sharp edge dissipates, over A h / E* times the sum of (mu p)^2 times what the
shear goes beyond it, with the area A and the shorter side h of a cell."""

ANNULUS, ANNULUS_WORK, ANNULUS_CELLS = 1.3, 10.0, 1.5
"""A slip annulus of dissimilar bodies pressed together that is thinner than ANNULUS_CELLS cells is not resolved: more
increments only make it vanish. Its width w is ANNULUS times that of a sphere (Spence), and the energy that it
dissipates while the contact grows is ANNULUS_WORK mu beta (w/a)^2.5 p0^2 a^3/E*, with Dundurs' constant beta: slip of
the order beta w^2/R under a pressure of the order p0 (w/a)^(1/2) in all of the area. The factors hold for spheres and
flat punches, where the order of magnitude alone is 3 too large and 3 too small."""

SHEARED_CELLS, SHEARED_CELLS_LINE, SHEARED_ORDER = 0.28, 1.0, 1.5
"""Width in cells up to which cells may see nothing of an annulus that shear makes; that in line contact, both of whose
edges may lie alike in their cells. Of the energy of a wider annulus they miss a part at most that falls with this power
of the width. Spheres and cylinders missed up to nearly all of that."""

FLAT_WORK = 1.0
"""What a flat punch dissipates that is pressed against an unlike body, over mu beta (w/a) pm^2 a^3/E*, with the mean
pressure pm: near its edge, a distance s from it, the pressure goes with pm (a/s)^(1/2), and slip with beta (pm/E*)
(a s)^(1/2). It is 0.77, 0.82 and 0.89 at w/a = 0.16, 0.06 and 0.016."""

BEYOND_DEPTH, SLIP_BEYOND, WORK_BEYOND = 1.5, 3.0, 3.0
"""Slip of unlike bodies goes beyond a rounding if without slip the shear traction would reach the friction limit
BEYOND_DEPTH times as far from the edge as the rounding is in contact. It has SLIP_BEYOND times that distance as its
width w. A shear dissipates WORK_BEYOND mu beta w K^2/E* per length of the edge, less what pressing has dissipated, and
at most twice that in a reversal, with the pressure K/s^(1/2). A punch in plane strain on a rounding of 4e-3 of its
width, sheared to 0.15 and 0.25 of the friction limit, has 3.1 and 3.0 for the width, 1.9 and 2.0 for the energy, and
once that in a reversal. Coarse cells show less of the pressure that K follows from. Around a round contact the shear
acts along the edge, too: the mean of exp(x (cos t - 1)) over its angles t counts."""


@dataclass(frozen=True)
class UnseenSlip:
    """The slip of a problem that its cells do not show; its fields are those of `LeastErrors`.

    holes: whether the last of the edges is that of holes of a height map, where the body ends sharply.
    """

    model: Model
    side: float
    slender: float
    ends: bool
    edges: tuple[Edge, ...]
    flat: float | None = None
    holes: bool = False

    def at_roundings(self, state: State, share: float) -> float:
        """Return what slip within roundings that the cells do not see dissipates (mJ), per length of the path.

        share: largest part of the friction limit to which the path has sheared.
        """
        friction, modulus = self.model.friction, self.model.compliances.contact_modulus
        if not share:
            return 0.0
        energies = (edge.hidden_energy(state.fields.pressure, self.side, modulus, friction) for edge in self.edges)
        total: float = share**2 * sum(energies)
        return total

    def beyond_roundings(self, state: State, pressed: float, path: ShearPath) -> DoubleArray:
        """Return what slip of unlike bodies beyond unseen roundings dissipates (mJ), in the last increment and in all.

        pressed: part of the friction limit to which pressing alone shears a cell from the edge.
        """
        friction, mismatch = self.model.friction, abs(self.model.compliances.dundurs_constant)
        nothing: DoubleArray = np.zeros(2)
        if not (self.edges and self.model.coupled and friction and path.farthest > UNSHEARED):
            return nothing
        # By so much the share of the limit grows with the logarithm of the distance from the edge.
        slope = mismatch / (math.pi * friction)
        limited = math.exp((min(pressed + path.farthest, 1.0) - 1.0) / slope) * self.side
        width = SLIP_BEYOND * limited
        if not 0.0 < width < ANNULUS_CELLS * self.side:
            return nothing
        modulus = self.model.compliances.contact_modulus
        roundings = (edge.hidden_singularity(state.fields.pressure, self.side, modulus) for edge in self.edges)
        squares = sum(square for square, depth in roundings if BEYOND_DEPTH * depth < limited)
        if not squares:
            return nothing
        rise = path.farthest / slope
        around = 1.0 if self.model.line else _mean_around(rise)
        missed = math.pow(min(SHEARED_CELLS * self.side / width, 1.0), SHEARED_ORDER)
        # Pressing alone has dissipated its part before.
        once = -math.expm1(-rise) * missed * around * WORK_BEYOND * friction * mismatch * width * squares / modulus
        last, whole = (way / path.farthest for way in path.ways_under_load)
        return np.array([once * last, once * max(whole, 1.0) if whole else 0.0])

    def at_sharp_edges(self, state: State, share: float) -> float:
        """Return what slip within the cells at sharp edges dissipates (mJ), per length of the path; share: as above."""
        if not ((self.ends or self.holes) and share and any(edge.radius == 0.0 for edge in self.edges)):
            return 0.0
        modulus, mismatch = self.model.compliances.contact_modulus, abs(self.model.compliances.dundurs_constant)
        limit = self.model.friction * state.fields.pressure.astype(np.float64)
        shear = np.hypot(*state.fields.shear.astype(np.float64))
        unlike = mismatch * math.log(4.0) / (math.pi * self.model.friction) if self.model.coupled else 0.0
        stresses = sum(edge.hidden_stress(limit, shear, share, unlike) for edge in self.edges)
        size = self.side**2 if self.model.line else self.side**3 / self.slender**2
        return HIDDEN_SLIP * stresses * size / modulus

    def annulus(self, summary: Summary) -> float:
        """Return the width (mm) of a slip annulus that is too thin for the cells, 0 of others."""
        width = ANNULUS * (1.0 - spence_ratio(self.model)) * summary.contact_radius
        return width if width < ANNULUS_CELLS * self.side else 0.0

    def sheared_annulus(self, summary: Summary, share: float) -> float:
        """Return the width (mm) of a slip annulus that shear makes and that is too thin for the cells, 0 of others.

        share: part f of the load by which that on the stick zone is smaller. That of a rounded punch goes beyond its
        flat part with the power 2/3 of the load where this is long, and up to that of round bodies where it is short.
        Other bodies with ends slip otherwise.
        """
        reach = self._reach_of_annuli(summary)
        width = (1.0 - self.stick_share(share)) * reach
        if width >= ANNULUS_CELLS * self.side:
            return 0.0
        on_rounding = reach < summary.contact_radius
        return (1.0 - (1.0 - min(share, 1.0)) ** (2.0 / 3.0)) * reach if on_rounding else width

    def _reach_of_annuli(self, summary: Summary) -> float:
        """Return how far (mm) from the edge of the contact shear may slip first, 0 of bodies that slip otherwise."""
        radius = summary.contact_radius
        if not self.ends:
            return radius
        if self.flat is None:
            return 0.0
        if self.flat >= radius:  # the edge of the punch is out of reach
            return radius
        rounding = radius - self.flat
        # `at_roundings` knows of a shorter one
        return rounding if rounding >= ANNULUS_CELLS * self.side else 0.0

    def stick_share(self, share: float) -> float:
        """Return the radius of the stick zone over that of the contact; share: as above."""
        return float((1.0 - min(share, 1.0)) ** (1.0 / 2.0 if self.model.line else 1.0 / 3.0))

    def energies_of_shear(self, summary: Summary, share: float, ways: DoubleArray) -> DoubleArray:
        """Return what cells miss at most (mJ) of slip in such an annulus, in the last increment and in all.

        ways: lengths of the path in the last increment and of all. Rounded punches dissipate less.

        A shear to the small part f of the friction limit mu P dissipates mu^2 P^2 S f^3/144a of a round contact with
        the tangential compliance S (Johnson, section 7.4), and mu^2 P^2 f^3/6 pi E* of a line contact, per length. A
        larger one dissipates more, by 1/(1 - 2f/3).
        """
        width = self.sheared_annulus(summary, share)
        if not width:
            return np.zeros_like(ways)
        pair, limit, line = self.model.compliances, self.model.friction * summary.P, self.model.line
        compliance = pair.A / (12.0 * math.pi) if line else pair.tangential / (144.0 * summary.contact_radius)
        unseen = (SHEARED_CELLS_LINE if line else SHEARED_CELLS) * self.side
        missed = min((unseen / width) ** SHEARED_ORDER, 1.0)
        found: DoubleArray = missed * limit**2 * compliance * share**2 / (1.0 - 2.0 * share / 3.0) * ways
        return found

    def energies_of_annulus(self, summary: Summary, before: Summary | None) -> DoubleArray:
        """Return what it has dissipated (mJ) in the last increment and in all, (2,).

        before: of the increment of the largest P before. Unloading does not take back what pressing has dissipated.
        """
        now, then = (0.0 if one is None else self._energy_of_annulus(one) for one in (summary, before))
        return np.array([max(now - then, 0.0), max(now, then)])

    def _energy_of_annulus(self, summary: Summary) -> float:
        width, radius, pair = self.annulus(summary), summary.contact_radius, self.model.compliances
        if not width:
            return 0.0
        mismatch = self.model.friction * abs(pair.dundurs_constant) * (width / radius) ** 2.5
        size = radius**2 if self.model.line else radius**3
        energy: float = ANNULUS_WORK * mismatch * summary.max_pressure**2 * size / pair.contact_modulus
        if self.flat is None:
            return energy
        slip = self.model.friction * abs(pair.dundurs_constant) * width / (ANNULUS * radius)
        mean = summary.P / (2.0 * radius if self.model.line else math.pi * radius**2)
        return max(energy, FLAT_WORK * slip * mean**2 * size / pair.contact_modulus)


def _mean_around(rise: float) -> float:
    """Return the mean of exp(`rise` (cos t - 1)) over all angles t."""
    from scipy.special import i0e  # slow to import, and few cases need it

    return float(i0e(rise))
