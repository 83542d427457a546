"""States made up from the state before, cheaply and reproducibly: all depends on all that a restart holds."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.history import BULK, OF_RIG, OF_WEAR, SPOTS
from fretsolve.result import HistoryWriter, RunHeader
from fretsolve.result.layout import ERRORS
from fretsolve.result.state import Fields, State, Summary, SummaryErrors, WearState

ALL_FIELDS = ("pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap")
COUNTS = (
    "contact_cells",
    "stick_cells",
    "step",
    "stage",
    "iterations_normal",
    "iterations_tangential",
    "alternations",
    "operator_applications",
)


def fake_header(
    shape: tuple[int, int] = (6, 5),
    stored: tuple[str, ...] = ALL_FIELDS,
    every: int = 1,
    increments: int = 6,
    title: str = "made up",
    errors: bool = False,
    **solver: Any,
) -> RunHeader:
    case = {
        "title": title,
        "grid": {"points": list(shape)},
        "load_path": [{"P": 400.0, "increments": increments}],
        "solver": {"tolerance": 1e-6, "max_iterations": 2000, **solver},
        "output": {"fields": list(stored), "every": every},
    }
    return RunHeader(
        case_yaml=f"title: {title}\n",
        effective_case=json.dumps(case),
        coupling="tangential",
        provenance=json.dumps({"threads": 1}),
        x=0.1 * np.arange(shape[0]) - 0.25,
        y=0.1 * np.arange(shape[1]) - 0.2,
        fields=stored,
        every=every,
        errors=errors,
    )


def some_errors(step: int) -> SummaryErrors:
    return SummaryErrors(*(0.1 * step + index for index in range(len(ERRORS))))


def next_state(
    previous: State | None, shape: tuple[int, int] = (6, 5), dtype: str = "float64", errors: bool = False
) -> State:
    """The state after `previous`: a chaotic map, where the last bit of any number soon changes all digits."""
    step = 0 if previous is None else previous.summary.step + 1
    seed = np.random.default_rng(1).uniform(0.1, 0.9, shape)
    carried = seed if previous is None else _digest(previous)
    pressure = np.where(seed > 0.4, 3.9 * carried * (1 - carried), 0.0)
    shear = np.stack([0.1 * pressure * np.cos(carried), -0.1 * pressure * np.sin(carried)])
    slip = np.stack([carried - 0.5, 0.5 - carried]) * 1e-3
    zone = np.where(pressure == 0, 0, np.where(carried > 0.5, 2, 1)).astype(np.uint8)
    gap = np.where(pressure == 0, carried, 0.0)
    gap[0, 0] = np.inf
    arrays = {
        "pressure": pressure,
        "shear": shear,
        "slip": slip,
        "slip_path": np.hypot(*slip),
        "work_density": pressure * np.hypot(*slip),
        "gap": gap,
    }
    state_fields = Fields(**{name: values.astype(dtype) for name, values in arrays.items()}, zone=zone)
    displacement = (np.stack([carried, seed]) * 1e-2).astype(dtype)
    state = State(_summary(step, pressure, previous), state_fields, displacement)
    return replace(state, errors=some_errors(step)) if errors else state


def fake_states(count: int, previous: State | None = None, **options: Any) -> Iterator[State]:
    """States up to increment `count` - 1, from the start or from `previous`."""
    step = -1 if previous is None else previous.summary.step
    while step + 1 < count:
        previous = next_state(previous, **options)
        step = previous.summary.step
        yield previous


def write_increments(
    out: Path, header: RunHeader | None = None, stop_after: int | None = None, count: int = 6, **options: bool
) -> list[str]:
    """Write `count` made-up increments, and return the notes; stop_after: increments after which it is left."""
    with HistoryWriter.open(out, header or fake_header(), **options) as writer:
        shape, errors = writer.header.shape, writer.header.errors
        for state in fake_states(count, writer.last_state, shape=shape, errors=errors):
            writer.append(state)
            if state.summary.step + 1 == stop_after:
                return writer.notes
        writer.finish("complete")
    return writer.notes


def write_fake(out: Path, end: str = "complete", count: int = 4, **options: Any) -> Path:
    """Write a result of made-up states that ends as `end` says: complete, failed, or stopped."""
    with HistoryWriter.open(out, fake_header(**options)) as writer:
        for state in fake_states(count, shape=writer.header.shape, errors=writer.header.errors):
            writer.append(state)
        if end != "stopped":
            writer.finish(end, "sliding" if end == "failed" else "")
    return out


def assert_same_state(one: State, other: State) -> None:
    """Equal in every bit, and of the same precision."""
    assert (one.summary, one.errors) == (other.summary, other.errors)
    for field in fields(Fields):
        np.testing.assert_array_equal(getattr(one.fields, field.name), getattr(other.fields, field.name), strict=True)
    np.testing.assert_array_equal(one.displacement, other.displacement, strict=True)
    assert (one.wear is None) == (other.wear is None)
    for field in () if one.wear is None else fields(WearState):
        np.testing.assert_array_equal(getattr(one.wear, field.name), getattr(other.wear, field.name), strict=True)


def _digest(state: State) -> np.ndarray:
    kept = [getattr(state.fields, field.name) for field in fields(Fields)]
    arrays = [array.astype(float) for array in kept if array is not None]
    total = sum((k + 1) * np.where(np.isfinite(a), a, 1.0) for k, a in enumerate(_planes(*arrays, state.displacement)))
    return 0.1 + 0.8 * np.abs(np.sin(50.0 * total + state.summary.work_total))


def _planes(*arrays: np.ndarray) -> Iterator[np.ndarray]:
    for array in arrays:
        yield from array if array.ndim == 3 else (array,)


def _summary(step: int, pressure: np.ndarray, previous: State | None) -> Summary:
    load = float(pressure.sum())
    values: dict[str, Any] = {
        field.name: 1 + step if field.name in COUNTS else load / (1 + index)
        for index, field in enumerate(fields(Summary))
    }
    before = previous.summary.work_total if previous else 0.0
    values.update(P=load, step=step, stage=1 + step // 3, wall_time=0.25, work_total=before + values["work"])
    values.update(residual_gap=1e-9, residual_stick=3e-7, residual_slip=0.0, residual_bound=0.0, residual_load=1e-8)
    values.update(Mx=0.0, My=1e-14 * load, Qy=0.0, Mz=0.0, delta_y=0.0, phi_x=0.0, phi_y=0.0, phi_z=0.0)
    values |= dict.fromkeys((*BULK[1], *BULK[2], *OF_WEAR, *OF_RIG), 0.0) | dict.fromkeys(SPOTS, -1)
    for zone in ("contact", "stick"):  # circles about the origin
        radius = values[f"{zone}_radius"]
        values |= {f"{zone}_half_width_x": radius, f"{zone}_half_width_y": radius}
        values |= {f"{zone}_center_x": 0.0, f"{zone}_center_y": 0.0}
    return Summary(**values)
