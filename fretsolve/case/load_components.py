"""The load components: force or moment of each rigid mode, and the displacement or rotation that it works on."""

from __future__ import annotations

PAIRS = (("P", "delta_z"), ("Mx", "phi_x"), ("My", "phi_y"), ("Qx", "delta_x"), ("Qy", "delta_y"), ("Mz", "phi_z"))
"""Normal modes first; one of each pair is imposed at a time."""

TANGENTIAL = frozenset(name for pair in PAIRS[3:] for name in pair)
