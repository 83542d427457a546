"""Contact at the edge of the grid, where none can be, and grids of every shape."""

from __future__ import annotations

from solving import LOAD

from fretsolve.errors import CaseError, ContactLostError, GridEdgeError, NotConvergedError

from .driving import Family, Parts, Probe, by, led
from .limits import of_hertz, of_mindlin, of_superposition, worst
from .pairs import FLAT_RIGID
from .shapes import SHEARED, SPHERE, plain

AWAY = {"punch": {"radius": 0.1, "center": [5.0, 0.0]}}

AT_THE_EDGE = Family(
    "contact at the edge of the grid",
    "sizes 0.05 to 0.62 mm for 0.602 mm, flat on flat, endless, off the grid",
    "exit 3 with a size that would do, exit 2 where none would",
    (
        *(
            Probe(
                f"size {size:g} mm",
                led(by(2, P=LOAD), points=32, size=size),
                refused=GridEdgeError,
                says=r"size: \[0\.7\d* mm, 0\.7\d* mm\] would do",
                quick=size in (0.05, 0.5),
            )
            for size in (0.05, 0.3, 0.5, 0.6)
        ),
        Probe("size 0.66 mm", {"grid": {"points": 32, "size": 0.66}}, of_hertz, 0.01),
        Probe(
            "flat on flat",
            led(points=24, size=1.0, surface={"punch": {"half_width": 10.0}}),
            refused=GridEdgeError,
            says=r"size: \[2[45][.\d]* mm",
        ),
        Probe(
            "all cells",
            led(points=24, size=1.0, surface={"punch": {"half_width": 0.5}}),
            refused=GridEdgeError,
            says=r"size: \[1\.2",
        ),
        Probe(
            "endless cylinder",
            {"surface": {"cylinder": {"radius": 10.0, "axis": "x"}}},
            refused=CaseError,
            says="a surface that ends",
        ),
        Probe(
            "endless cylinder, size given",
            led(points=24, size=1.0, surface={"cylinder": {"radius": 10.0, "axis": "x"}}),
            refused=GridEdgeError,
            says="no size would hold it",
        ),
        *(
            Probe(
                f"punch off the grid, {name}",
                led(held, points=16, size=1.0, surface=AWAY),
                refused=ContactLostError if name == "P = 0" else None,
                says="nowhere face each other",
            )
            for name, held in (("P = 0", {"P": 0.0}), ("held by delta_z", {"delta_z": 1e-3, "increments": 2}))
        ),
        Probe(
            "concave sphere",
            {"surface": {"sphere": {"radius": -10.0}}},
            refused=CaseError,
            says="surface.sphere.radius: -10 mm is concave",
        ),
        Probe(
            "shear moves the contact to the edge",
            led(by(5, P=LOAD), by(5, Qx=400.0), bodies=FLAT_RIGID, friction=2.0),
            refused=GridEdgeError,
            says=r"try size: \[",
            may_solve=True,
        ),
    ),
)


def on_grid(points: int | tuple[int, int], size: object = "auto") -> Parts:
    """Hertz and Mindlin on so many cells."""
    return led(points=points, size=size, load_path=SHEARED, coupling="none")


GRIDS = Family(
    "grids",
    "1 x 1 to 1 x 1000, primes; cells 1e-3 to 1e3 as long as wide",
    "Hertz, Mindlin, or exit 3",
    (
        *(
            Probe(
                f"{points[0]} x {points[1]}",
                on_grid(points),
                refused=GridEdgeError,
                says="more points",
                quick=points in ((1, 1), (2, 3), (1, 1000)),
            )
            for points in ((1, 1), (1, 2), (2, 2), (2, 3), (3, 2), (3, 3), (1, 1000), (1000, 1), (2, 1000))
        ),
        *(
            Probe(
                f"{points[0]} x {points[1]}",
                on_grid(points),
                worst(of_hertz, of_mindlin),
                allowed,
                quick=points != (127, 131),
            )
            for points, allowed in (((31, 37), 0.01), ((127, 131), 0.002), ((13, 200), 0.04), ((400, 12), 0.04))
        ),
        *(
            Probe(
                f"cells of {ratio:g}",
                plain(SPHERE, grid={"points": 24, "size": [0.75 * max(ratio, 1.0), 0.75 / min(ratio, 1.0)]}),
                of_superposition,
                1e-4,
                quick=ratio in (1e-3, 1e3),
            )
            for ratio in (1e-3, 1e-2, 0.1, 10.0, 1e2, 1e3)
        ),
    ),
)

FAR = Family(
    "contact far from the origin",
    "1 to 1e6 mm for 0.6 mm; P, Qx, Mz about it",
    "Hertz; at 1e6 mm rounding named",
    tuple(
        Probe(
            f"x = {place:g} mm",
            led(
                {"P": LOAD},
                by(2, Qx=20.0),
                by(2, Mz=2.0),
                grid={"points": 24, "size": 0.75, "center": [place, 0.0]},
                surface={"sphere": {"radius": 10.0, "center": [place, 0.0]}},
            ),
            of_hertz,
            0.01,
            refused=NotConvergedError if place == 1e6 else None,
            says="too few digits in double precision; move surface and grid",
            quick=place == 1e6,
        )
        for place in (1.0, 1e3, 1e6)
    ),
)

LARGE = Family(
    "large grid",
    "4096 x 4096; P, then Q = mu P/2 without in-plane coupling",
    "Hertz, Mindlin",
    (
        Probe(
            "24 points", led({"P": LOAD}, by(1, Qx=20.0), points=24, coupling="none"), worst(of_hertz, of_mindlin), 0.01
        ),
        Probe(
            "4096 points",
            led({"P": LOAD}, by(1, Qx=20.0), points=4096, coupling="none"),
            worst(of_hertz, of_mindlin),
            1e-5,
            quick=False,
            seconds=1800.0,
        ),
    ),
)

FAMILIES = (AT_THE_EDGE, GRIDS, FAR, LARGE)
