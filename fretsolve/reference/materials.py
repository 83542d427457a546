"""Elastic constants of common materials at room temperature, and the yield stress where the name settles it.

Each has its source. A name that leaves grade or temper open has no yield stress, nor has a brittle material.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

ASM = "ASM Aerospace Specification Metals, data sheet (asm.matweb.com)"
KAYE_AND_LABY = "Kaye and Laby, Tables of Physical and Chemical Constants, 16th edition (1995), section 2.2.2"
EN_1993 = "EN 1993-1-1:2005, 3.2.6"
EN_10025 = "EN 10025-2:2004, table 7: least yield stress up to 16 mm thick"
OLIN = "Olin Brass, alloy data C26000 (ASTM B36): nominal yield stress"
SNFA = "SNFA, CHROMEX 40, table of bearing steel and silicon nitride (cantonicuscinetti.com)"


@dataclass(frozen=True)
class LibraryMaterial:
    """An isotropic material. young_modulus and yield_stress in MPa; others: names that stand for the same."""

    name: str
    young_modulus: float
    poisson_ratio: float
    source: str
    yield_stress: float | None = None
    others: tuple[str, ...] = ()

    @property
    def constants(self) -> dict[str, float]:
        """The keys of a body of a case file with their values."""
        given = {"young_modulus": self.young_modulus, "poisson_ratio": self.poisson_ratio}
        return given if self.yield_stress is None else {**given, "yield_stress": self.yield_stress}


LIBRARY = (
    LibraryMaterial("steel", 210e3, 0.3, f"{EN_1993}: structural steel", others=("structural steel",)),
    *(
        LibraryMaterial(f"S{limit}", 210e3, 0.3, f"{EN_1993}; {EN_10025}", float(limit), (f"S{limit}JR", f"S{limit}J2"))
        for limit in (235, 275, 355)
    ),
    LibraryMaterial("100Cr6", 210e3, 0.3, SNFA, others=("52100", "AISI 52100", "bearing steel")),
    LibraryMaterial(
        "Ti-6Al-4V", 113.8e3, 0.342, f"{ASM} MTP641: grade 5, annealed", yield_stress=880.0, others=("Ti64", "TA6V")
    ),
    LibraryMaterial(
        "Ti-6Al-4V STA", 114e3, 0.33, f"{ASM} MTP642: grade 5, solution treated and aged", yield_stress=1100.0
    ),
    LibraryMaterial("Ti-6Al-4V ELI", 113.8e3, 0.342, f"{ASM} MTP643: grade 5, ELI, annealed", yield_stress=790.0),
    LibraryMaterial("Al 6061-T6", 68.9e3, 0.33, f"{ASM} MA6061T6", yield_stress=276.0, others=("6061-T6", "AA6061-T6")),
    LibraryMaterial("Al 7075-T6", 71.7e3, 0.33, f"{ASM} MA7075T6", yield_stress=503.0, others=("7075-T6", "AA7075-T6")),
    LibraryMaterial("Al 2024-T4", 73.1e3, 0.33, f"{ASM} MA2024T4", yield_stress=324.0, others=("2024-T4", "AA2024-T4")),
    LibraryMaterial(
        "Inconel 718",
        200e3,
        0.29,
        "Special Metals, INCONEL alloy 718, publication SMC-045 (2007), table 3, at 70 F: 29.0e6 psi",
        others=("IN718", "Alloy 718"),
    ),
    LibraryMaterial("aluminium", 70.3e3, 0.345, KAYE_AND_LABY, others=("aluminum", "Al")),
    LibraryMaterial("copper", 129.8e3, 0.343, KAYE_AND_LABY, others=("Cu",)),
    LibraryMaterial("brass", 100.6e3, 0.35, f"{KAYE_AND_LABY}: 70 % Cu, 30 % Zn", others=("CuZn30",)),
    *(
        LibraryMaterial(f"brass {temper}", 100.6e3, 0.35, f"{KAYE_AND_LABY}: 70 % Cu, 30 % Zn; {OLIN}", limit, names)
        for temper, limit, names in (
            ("annealed", 145.0, ("C26000 annealed",)),
            ("half hard", 350.0, ("C26000 half hard", "C26000 H02")),
            ("hard", 495.0, ("C26000 hard", "C26000 H04")),
        )
    ),
    LibraryMaterial("silicon nitride", 315e3, 0.26, SNFA, others=("Si3N4",)),
    LibraryMaterial(
        "silicon carbide",
        415e3,
        0.16,
        "Munro, J. Phys. Chem. Ref. Data 26 (1997) 1195-1203: sintered, 98 % dense; NIST SRD 150, doi:10.18434/T42G62",
        others=("SiC",),
    ),
    LibraryMaterial(
        "alumina",
        416e3,
        0.231,
        "Munro, J. Am. Ceram. Soc. 80 (1997) 1919-1928: sintered, 99.5 % pure; NIST SRD 150, doi:10.18434/T42G62",
        others=("Al2O3",),
    ),
    LibraryMaterial("fused silica", 73.1e3, 0.17, KAYE_AND_LABY, others=("fused quartz", "SiO2")),
    LibraryMaterial("N-BK7", 82e3, 0.206, "Schott, data sheet N-BK7", others=("BK7",)),
)
"""The materials, in the order in which they are listed."""

NAMES = tuple(one.name for one in LIBRARY)


def material_named(name: str) -> LibraryMaterial | None:
    """Return the material of a name, None if there is none. Capitals, spaces and dashes do not matter."""
    return next((one for one in LIBRARY if _plain(name) in map(_plain, (one.name, *one.others))), None)


def every_name() -> tuple[str, ...]:
    """Return all names that `material_named` knows."""
    return tuple(name for one in LIBRARY for name in (one.name, *one.others))


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", name).lower()
