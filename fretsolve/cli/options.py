"""Arguments and options that several commands have. Only click is imported, as in `fretsolve.cli.main`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

FILE = click.Path(readable=False, path_type=Path)
"""A file or folder, whose errors the command reports."""

flag = partial(click.option, is_flag=True)


class Number(click.FloatRange):
    """A number between bounds; `FloatRange` with a message in plain words."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or refuse the value."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter:
            self.fail(f"{value!r} is not a number from {self.min:g} to {self.max:g}", param, ctx)


class WholeNumber(click.IntRange):
    """A whole number between bounds; `IntRange` with a message in plain words."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or refuse the value."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter:
            bounds = f"from {self.min} on" if self.max is None else f"from {self.min} to {self.max}"
            self.fail(f"{value!r} is not a whole number {bounds}", param, ctx)


class StepRange(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.3
    """An increment N, or increments N:M, as (first, last)."""

    name = "step"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """Return the first and the last increment, which are equal for one."""
        if isinstance(value, tuple):
            return value
        first, colon, last = str(value).partition(":")
        try:
            return int(first), int(last if colon else first)
        except ValueError:
            self.fail(f"{value!r} is neither an increment such as 21 nor a range such as 21:60", param, ctx)


def picture_options(command: Command) -> Command:
    """Add the options of the look of pictures, which are the fields of `fretsolve.post.plots.Sheet`."""
    of_width = "Width of the picture in mm; by default 90 or 190, a column of a journal or two, as the picture needs."
    of_dpi = "Dots per inch of PNG; films have a third of them."
    width = click.option("--width", type=Number(80.0, 1000.0), metavar="MM", help=of_width)
    title = click.option("--title/--no-title", default=True, help="With a title, or without one for a caption.")
    dpi = click.option("--dpi", type=WholeNumber(20, 1200), metavar="N", default=300, show_default=True, help=of_dpi)
    return width(title(dpi(command)))


def output_option(help_text: str, metavar: str = "OUT", name: str = "out") -> Callable[[Command], Command]:
    """Return the option `-o`, whose value goes to the parameter `name`."""
    return click.option("-o", "--output", name, type=FILE, metavar=metavar, help=help_text)


def repeatable_option(
    switch: str, name: str, metavar: str, help_text: str, **more: Any
) -> Callable[[Command], Command]:
    """Return an option that may be given several times; their values go to the parameter `name`."""
    return click.option(switch, name, multiple=True, metavar=metavar, help=f"{help_text} May be repeated.", **more)


def threads_option(help_text: str, **more: Any) -> Callable[[Command], Command]:
    """Return the option `--threads`."""
    kind = WholeNumber(1)
    return click.option("--threads", type=kind, metavar="N", default=1, show_default=True, help=help_text, **more)


def overwrite_option(what: str) -> Callable[[Command], Command]:
    """Return the option `--overwrite`; what: the thing that it replaces."""
    return flag("--overwrite", help=f"Replace {what}.")


def error_bars_option(help_text: str) -> Callable[[Command], Command]:
    """Return the option `--error-bars`, which `with_error_bars` puts among the overrides."""
    return flag("--error-bars", help=help_text)


def with_error_bars(overrides: tuple[str, ...], error_bars: bool) -> tuple[str, ...]:
    """Return the overrides of --set, and --error-bars as the last override, so that it holds."""
    return (*overrides, "solver.error_bars=true") if error_bars else overrides


overrides_option = repeatable_option(
    "--set",
    "overrides",
    "KEY=VALUE",
    "Replace a value of the case, such as grid.points=64, stage.2.increments=20 or 'stage.*.increments=20'.",
)
result_argument = click.argument("out", type=FILE)
quiet_option = flag("-q", "--quiet", help="Print only errors and warnings.")
