"""Pictures beside the figures of Gallego, Nelias & Deyber, Wear 2009, whose numbers they have."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from gallery_results import (
    DUNDURS,
    FRICTION,
    MODE_1,
    TORQUE,
    along_x,
    base_compliances,
    end_of_stage,
    hertz,
    panels,
    shipped,
)
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretsolve import plots
from fretsolve.plots.labels import CLOSED_FORM, marks
from fretsolve.reference.tangential import cattaneo_mindlin, lubkin, spence_stick_ratio
from fretsolve.result import Result

MODE_3 = {"III.1": "mode3_similar_uncoupled", "III.2": "mode3_similar", "III.3": "mode3_dissimilar"}
MODE_2_FRICTION = (0.01, 0.05, 0.1, 0.15, 0.2, 0.25)


def mode_2(friction: float, increments: int = 10) -> Result:
    """Return mode II with another coefficient of friction."""
    sets = f"friction={friction}", f"load_path.0.increments={increments}", "expect=[]"
    return shipped("mode2_dissimilar", *sets)


def figure_9() -> Figure:
    """Draw the angle of the slip in case I.2 at A."""
    result = shipped(MODE_1["I.2"])
    return plots.slip_angle(result, step=end_of_stage(result, 2))


def figures_10_and_11(name: str) -> Callable[[], Figure]:
    """Draw pressure, shear traction and slip at A and B."""

    def draw() -> Figure:
        result = shipped(MODE_1[name])
        return plots.profiles(result, steps=[end_of_stage(result, stage) for stage in (2, 3)])

    return draw


def figure_12() -> Figure:
    """Draw streamlines of the shear traction at A."""
    return _streamlines(MODE_1)


def figure_13() -> Figure:
    """Draw the fretting loops of mode I, with that of Mindlin."""
    figure, (axes,) = panels(1, 1, (5.6, 4.2))
    _mindlin_loop(axes)
    finer = [f"load_path.{stage}.increments=10" for stage in range(1, 6)]
    for mark, (name, case) in zip(marks(3), MODE_1.items(), strict=True):
        result = shipped(case, "expect=[]", *finer)
        shown = slice(end_of_stage(result, 1), None)
        displacement = 1e3 * result.history["delta_x"][shown]
        axes.plot(displacement, result.history["Qx"][shown], label=name, **mark.options(len(displacement)))
    axes.set(xlabel=r"rigid displacement $\delta_x$ (µm)", ylabel=r"tangential force $Q_x$ (N)")
    axes.legend()
    return figure


def _mindlin_loop(axes: Axes) -> None:
    force = np.linspace(0.0, 36.0, 60)
    contact, compliance = hertz(), base_compliances().tangential
    loading = np.array([cattaneo_mindlin(contact, FRICTION, q, compliance).delta_x for q in force])
    back = np.linspace(36.0, -36.0, 120)
    half = np.array([cattaneo_mindlin(contact, FRICTION, 0.5 * (36.0 - q), compliance).delta_x for q in back])
    unloading = loading[-1] - 2.0 * half
    displacement = np.concatenate([loading, unloading, -unloading])
    label = "Mindlin (closed form)"
    axes.plot(1e3 * displacement, np.concatenate([force, back, -back]), label=label, **CLOSED_FORM)


def figure_14() -> Figure:
    """Draw c/a over P in mode II."""
    figure, (axes,) = panels(1, 1, (5.6, 4.0))
    for mark, friction in zip(marks(len(MODE_2_FRICTION)), MODE_2_FRICTION, strict=True):
        history = mode_2(friction).history
        ratio = history["stick_radius"] / history["contact_radius"]
        axes.axhline(spence_stick_ratio(friction, DUNDURS), **CLOSED_FORM)
        axes.plot(history["P"], ratio, label=f"friction {friction:g}", **mark.options(len(ratio)))
    axes.plot([], [], label="Spence (closed form)", **CLOSED_FORM)
    axes.set(xlabel="normal force $P$ (N)", ylabel="c/a", ylim=(-0.03, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_15() -> Figure:
    """Draw c/a over friction in mode II at the last load."""
    figure, (axes,) = panels(1, 1, (4.6, 3.6))
    friction = np.linspace(0.0, 0.26, 100)
    spence = [spence_stick_ratio(value, DUNDURS) for value in friction]
    axes.plot(friction, spence, label="Spence (closed form)", **CLOSED_FORM)
    for mark, increments in zip(marks(2), (10, 40), strict=True):
        found = [_final_ratio(mode_2(value, increments)) for value in MODE_2_FRICTION]
        axes.plot(MODE_2_FRICTION, found, label=f"{increments} increments", **mark.options(len(found)))
    axes.set(xlabel="coefficient of friction", ylabel="c/a")
    axes.legend()
    return figure


def _final_ratio(result: Result) -> float:
    return float(result.history["stick_radius"][-1] / result.history["contact_radius"][-1])


def figure_16() -> Figure:
    """Draw pressure and shear traction of mode II at the last load, and the largest pressure over friction."""
    figure, (profile, largest) = panels(1, 2, (4.8, 3.8))
    p0 = hertz().max_pressure
    for mark, friction in zip(marks(len(MODE_2_FRICTION)), MODE_2_FRICTION, strict=True):
        result = mode_2(friction)
        step = result.increments - 1
        for name, scale in (("pressure", p0), ("shear", friction * p0)):
            x, values = along_x(result, name, step)
            options = mark.options(len(x)) | {"linestyle": "--"} if name == "shear" else {"color": mark.color}
            label = f"friction {friction:g}" if name == "shear" else None
            profile.plot(x, values / scale, label=label, linewidth=1.0, **options)
    profile.set(xlabel="x/a", ylabel="p/p0, and dashed with markers |q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    ratio = [mode_2(friction).history["max_pressure"][-1] / p0 for friction in MODE_2_FRICTION]
    largest.plot(MODE_2_FRICTION, ratio, **marks(1)[0].options(len(ratio)))
    largest.set(xlabel="coefficient of friction", ylabel="largest pressure over Hertz's p0")
    return figure


def figure_17() -> Figure:
    """Draw the shear traction of mode II pressed in one, ten and forty increments."""
    figure, (axes,) = panels(1, 1, (5.8, 3.8))
    for mark, increments in zip(marks(3), (1, 10, 40), strict=True):
        result = mode_2(FRICTION, increments)
        x, shear = along_x(result, "shear", result.increments - 1)
        label = f"{increments} increment{'s' if increments > 1 else ''}"
        axes.plot(x, shear / (FRICTION * hertz().max_pressure), label=label, **mark.options(len(x)))
    axes.set(xlabel="x/a", ylabel="|q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_18() -> Figure:
    """Draw pressure and shear traction of mode II as the load rises."""
    figure, axes = panels(2, 3, (3.3, 2.5), sharex=True)
    p0 = hertz().max_pressure
    for column, friction in enumerate((0.01, 0.1, 0.25)):
        result = mode_2(friction)
        for mark, step in zip(marks(result.increments), range(result.increments), strict=True):
            for row, (name, scale) in enumerate((("pressure", p0), ("shear", friction * p0))):
                x, values = along_x(result, name, step)
                panel = axes[3 * row + column]
                panel.plot(x, values / scale, color=mark.color, linewidth=1.0, label=f"{result.history['P'][step]:g} N")
        axes[column].set_title(f"friction {friction:g}")
        axes[3 + column].set_xlabel("x/a")
    for step, away in ((0, -9.0), (-1, 2.0)):  # the curves between are in the order of the loads
        load, peak = result.history["P"][step], result.history["max_pressure"][step] / p0
        axes[2].annotate(f"{load:g} N", (0.0, peak), (0.0, away), textcoords="offset points", ha="center", fontsize=6.5)
    axes[2].margins(y=0.12)
    axes[0].set(ylabel="p/p0", xlim=(-1.05, 1.05))
    axes[3].set_ylabel("|q|/μ p0")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, title="P")
    return figure


def figure_19() -> Figure:
    """Draw streamlines of mode II."""
    return plots.streamlines(mode_2(FRICTION))


def figure_20() -> Figure:
    """Draw the shear traction of mode III along x."""
    figure, (axes,) = panels(1, 1, (6.2, 3.8))
    contact = hertz()
    scale = FRICTION * contact.max_pressure
    form = lubkin(contact, FRICTION, TORQUE, base_compliances().torsional)
    x = np.linspace(-1.0, 1.0, 401)
    shear = np.abs(form.shear(np.abs(x) * contact.contact_radius)) / scale
    axes.plot(x, shear, label="Lubkin (closed form)", **CLOSED_FORM)
    for mark, (name, case) in zip(marks(3), MODE_3.items(), strict=True):
        result = shipped(case)
        at, found = along_x(result, "shear", result.increments - 1)
        axes.plot(at, found / scale, label=name, **mark.options(len(at)))
    axes.set(xlabel="x/a", ylabel="|q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_21() -> Figure:
    """Draw the radial share of the shear traction in mode III between equal bodies."""
    figure, axes = panels(1, 2, (3.6, 3.1))
    for panel, name in zip(axes, ("III.1", "III.2"), strict=True):
        result = shipped(MODE_3[name])
        shear = result.field("shear")
        x, y = np.meshgrid(result.x, result.y, indexing="ij")
        length = np.hypot(x, y) * np.hypot(*shear)
        touching = result.field("pressure") > 0.0
        share = np.divide(x * shear[0] + y * shear[1], length, out=np.full_like(x, np.nan), where=touching)
        edges = np.array([result.x[0], result.x[-1], result.y[0], result.y[-1]]) / hertz().contact_radius
        image = panel.imshow(share.T, origin="lower", extent=tuple(edges), cmap="RdBu_r", vmin=-0.05, vmax=0.05)
        panel.set(xlabel="x/a", ylabel="y/a", title=f"{name}: at most {np.nanmax(np.abs(share)):.2g}")
        panel.grid(False)
    figure.colorbar(image, ax=axes, label="radial part of the shear traction")
    return figure


def figure_22() -> Figure:
    """Draw streamlines of the shear traction of mode III."""
    return _streamlines(MODE_3)


def _streamlines(cases: dict[str, str]) -> Figure:
    figure, axes = panels(1, len(cases), (3.9, 3.4))
    for panel, (name, case) in zip(axes, cases.items(), strict=True):
        result = shipped(case)
        plots.streamlines(result, panel, step=end_of_stage(result, 2))
        panel.set_title(f"{name}: shear traction (MPa)")
        handles = panel.get_legend().legend_handles
        panel.get_legend().remove()
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


PAPER_FIGURES: dict[str, Callable[[], Figure]] = {
    "figure_09": figure_9,
    "figure_10_11_I1": figures_10_and_11("I.1"),
    "figure_10_11_I2": figures_10_and_11("I.2"),
    "figure_10_11_I3": figures_10_and_11("I.3"),
    "figure_12": figure_12,
    "figure_13": figure_13,
    "figure_14": figure_14,
    "figure_15": figure_15,
    "figure_16": figure_16,
    "figure_17": figure_17,
    "figure_18": figure_18,
    "figure_19": figure_19,
    "figure_20": figure_20,
    "figure_21": figure_21,
    "figure_22": figure_22,
}
