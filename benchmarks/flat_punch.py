"""What flat punches dissipate that are pressed against an unlike body, over the law that error bars hold.

    python benchmarks/flat_punch.py            # some minutes on one core

The law is mu beta (w/a) pm^2 a^3/E*, with Dundurs' constant beta, the width w of the slip annulus by Spence, and the
mean pressure pm. Edges are sharp, or rounded by 0.006 of the radius a. On cells larger than w nothing slips.
"""

from __future__ import annotations

import math

import fretsolve
from fretsolve.setup.closed_forms.area_forms import spence_ratio
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.unseen_slip import FLAT_WORK

RADIUS, LOAD = 0.27315, 221.2
POINTS = (24, 48, 96, 192, 384)
BODIES = [{"young_modulus": 3900.0, "poisson_ratio": nu} for nu in (0.13, 0.43)]


def main() -> None:
    """Print the table."""
    print("| edge radius, mm | friction | w/a |", " | ".join(f"{points} points" for points in POINTS), "|")
    print("| --- " * (3 + len(POINTS)) + "|")
    for edge in (0.0, 0.0016):
        punch = {"radius": RADIUS, **({"edge_radius": edge} if edge else {})}
        for friction in (0.15, 0.2, 0.274):
            found = []
            for points in POINTS:
                path = [{"P": LOAD, "increments": 4}]
                parts = {"bodies": BODIES, "surface": {"punch": punch}, "friction": friction, "load_path": path}
                setup = set_up(fretsolve.case_from_dict({**parts, "grid": {"points": points, "size": 0.9}}))
                *_, last = fretsolve.run(setup)
                pair, width = setup.model.compliances, 1.0 - spence_ratio(setup.model)
                mean = LOAD / (math.pi * RADIUS**2)
                law = friction * abs(pair.dundurs_constant) * width * mean**2 * RADIUS**3 / pair.contact_modulus
                found.append(f"{last.summary.work_total / (FLAT_WORK * law):.2f}")
            print(f"| {edge} | {friction} | {width:.3f} |", " | ".join(found), "|", flush=True)


if __name__ == "__main__":
    main()
