"""What work handed out to threads loses: hand-outs, and parts that two threads cannot share equally.

    python benchmarks/hand_outs.py 512 [--increments 4]

Mode I.3 (B towards C) with numba on one thread. The time of each part is measured there and given to the first of two
threads that is free. So the gain that the parts allow is known on a busy machine, too.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

CASE = Path(__file__).resolve().parent.parent / "cases" / "mode1_dissimilar.yaml"
FIRST, THREADS = 21, 2
"""Increments before those that count, and threads to which the parts are given."""

HAND_OUT = 20e-6
"""Processor time (s) of handing out a task to a second thread."""


def shared(parts: Sequence[float]) -> float:
    """Return the time until the last thread has done its parts, each of which goes to the first that is free."""
    busy = [0.0] * THREADS
    for part in parts:
        busy[busy.index(min(busy))] += part
    return max(busy)


def main() -> None:
    """Print the gain that the parts of some increments allow."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", type=int)
    parser.add_argument("--increments", type=int, default=4)
    options = parser.parse_args()
    os.environ["FRETSOLVE_NUMBA"] = "1"

    import fretsolve
    from fretsolve.elastic.thread_team import ThreadTeam

    tasks: list[list[float]] = []

    def share(team: ThreadTeam, work: Callable[[int, Any], None], parts: Sequence[Any]) -> None:
        """Do all parts, one after another, and note how long each takes."""
        times = [time.thread_time()]
        for part in parts:
            work(0, part)
            times.append(time.thread_time())
        tasks.append([after - before for before, after in pairwise(times)])

    ThreadTeam.share = share  # type: ignore[method-assign]
    case = fretsolve.load_case(CASE, ["expect=[]", f"grid.points={options.points}", "grid.size=0.9"])
    states = fretsolve.run(case)
    for _ in islice(states, FIRST):
        tasks.clear()
    began = time.thread_time()
    for _ in islice(states, options.increments):
        pass
    whole = time.thread_time() - began
    inside = sum(map(sum, tasks))
    by_two = whole - inside + sum(map(shared, tasks))
    handed_out = sum(len(parts) > 1 for parts in tasks)
    print(f"inside the team: {inside / whole:.0%}, gain of two threads by that: {whole / (whole - inside / 2):.2f}")
    print(
        f"with parts as they are: {whole / by_two:.2f}, also handed out: {whole / (by_two + HAND_OUT * handed_out):.2f}"
    )
    print(f"hand-outs in an increment: {handed_out / options.increments:.0f}")


if __name__ == "__main__":
    main()
