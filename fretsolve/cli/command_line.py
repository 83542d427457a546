"""How every command ends, and the arguments and options that several commands have.

A command has an exit code, errors on one line, and an output whose reader may go away. Only click is imported here, as
in `fretsolve.cli.main`.
"""

from __future__ import annotations

import errno
import os
import signal
import stat
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import Any, TextIO, TypeVar, cast

import click
from click.core import ParameterSource

from fretsolve.errors import EXIT_BUG, CaseError, FileError, FretsolveError, printable
from fretsolve.system.files import reason_of, writing
from fretsolve.system.signals import Interrupts, end_by

MORE_FILES = "a higher limit (ulimit -n) is needed"


class _Command(click.Command):
    """A command that all its errors of usage name: click leaves it out of some, as of a value for a flag."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx
            raise


class CommandLine(click.Group):
    """Run the commands of a group: each returns its exit code, and errors are printed on one line."""

    command_class = _Command

    def main(self, *args: Any, **options: Any) -> Any:
        """Run the command line and exit; see `click.Command.main`."""
        with tolerant_streams(), warnings.catch_warnings(), Interrupts() as interrupts:
            if not os.environ.get("FRETSOLVE_DEBUG"):
                warnings.showwarning = lambda *_, **__: None  # warnings of libraries say nothing to a user
            run = partial(super().main, *args, **options | {"standalone_mode": False})
            code = _exit_code(run, interrupts)
        sys.exit(code)


def _exit_code(command: Callable[[], int | None], interrupts: Interrupts) -> int:
    """Run `command` and return its exit code; print the message of the error that ended it, if any.

    An error that follows Ctrl-C ends the process by the signal.
    """
    try:
        code = command() or 0
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        message, code = error.format_message(), error.exit_code
    except click.UsageError as error:
        place = error.ctx.command_path if error.ctx is not None else "fretsolve"
        what = " ".join(_usage_message(error).split())
        message, code = f"{place}: {what} (see {place} --help)", error.exit_code
    except click.Abort:
        end_by(signal.SIGINT)
        message, code = "interrupted", 128 + signal.SIGINT
    except FretsolveError as error:
        message, code = str(error), error.exit_code
    except OSError as error:
        if os.environ.get("FRETSOLVE_DEBUG"):
            raise
        where, why = error.filename or "a file or the working folder", reason_of(error)
        few = error.errno in (errno.EMFILE, errno.ENFILE)
        message = f"{why}: {MORE_FILES}" if few else f"{where}: cannot be used: {why}"
        message, code = printable(message), FileError.exit_code
    except MemoryError:
        message, code = "not enough memory; fewer grid.points are needed", CaseError.exit_code
    except Exception as error:
        if os.environ.get("FRETSOLVE_DEBUG") and not interrupts.came:
            raise
        if "can't start new thread" in str(error):
            print("not enough memory, or too many processes, for another thread", file=sys.stderr)
            return CaseError.exit_code
        if os.strerror(errno.EMFILE) in str(error):  # while a library is loaded, whose error has no number
            print(f"{os.strerror(errno.EMFILE)}: {MORE_FILES}", file=sys.stderr)
            return FileError.exit_code
        what = " ".join(f"{type(error).__name__}: {error}".split())
        message = f"internal error: {what}; please report it, with what it prints under FRETSOLVE_DEBUG=1"
        code = EXIT_BUG
    else:
        return code
    if interrupts.came:
        end_by(signal.SIGINT)
    with suppress(FileError):  # on a full disk, where the code says enough
        print(message, file=sys.stderr)
    return code


def _usage_message(error: click.UsageError) -> str:
    """Return what is wrong with the command line; a value's message begins with where it was given."""
    parameter = error.param if type(error) is click.BadParameter else None
    if isinstance(error, click.NoSuchOption) and error.ctx is not None and not error.possibilities:
        return error.format_message() + _where_it_is(error.option_name, error.ctx.find_root())
    if error.ctx is None or parameter is None:
        return error.format_message()
    if error.ctx.get_parameter_source(parameter.name or "") is ParameterSource.ENVIRONMENT:
        place = str(parameter.envvar)
    elif isinstance(parameter, click.Option):
        place = parameter.opts[-1]
    else:
        place = (parameter.metavar or parameter.name or "").strip("[].").upper()
    return f"{place}: {error.message}"


def _where_it_is(option: str, root: click.Context) -> str:
    """Return which commands have an option that another one does not have, as the end of a message."""
    commands = [(name, one) for group in _groups(root.command) for name, one in group.items()]
    owners = [name for name, one in commands if any(option in parameter.opts for parameter in one.params)]
    return f" It is an option of {', '.join(owners)}." if owners else ""


def _groups(command: click.Command, path: str = "") -> Iterator[dict[str, click.Command]]:
    """Yield the commands of a group and of the groups in it by their full names."""
    inside = command.commands if isinstance(command, click.Group) else {}
    yield {f"{path}{name}": one for name, one in inside.items()}
    for name, one in inside.items():
        yield from _groups(one, f"{path}{name} ")


class TolerantStream:
    """Write to `stream`, control characters escaped, and drop what is written once its reader has gone.

    name: for messages; kept: control characters that are written as they are, None for all. Raises FileError for other
    reasons, such as a full disk.
    """

    def __init__(self, stream: TextIO, name: str, kept: str | None = "\n\t"):
        self._stream = stream
        self._name = name
        self._kept = kept

    @property
    def unescaped(self) -> TolerantStream:
        """A stream for a library that moves the cursor, and escapes the texts that it is given."""
        return TolerantStream(self._stream, self._name, None)

    def write(self, text: str) -> int:
        with self._tolerance():
            self._stream.write(text if self._kept is None else printable(text, self._kept))
        return len(text)

    def flush(self) -> None:
        with self._tolerance():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextmanager
    def _tolerance(self) -> Iterator[None]:
        with writing(self._name):
            try:
                yield
            except OSError as error:
                gone = isinstance(error, BrokenPipeError) or self._is_closed_terminal(error)
                # the null device takes the buffer and all later output, so that the interpreter can flush at its exit
                with suppress(OSError), Path(os.devnull).open("w") as nowhere:
                    os.dup2(nowhere.fileno(), self._stream.fileno())
                if not gone:
                    raise

    def _is_closed_terminal(self, error: OSError) -> bool:
        with suppress(OSError):
            return error.errno == errno.EIO and stat.S_ISCHR(os.fstat(self._stream.fileno()).st_mode)
        return False


@contextmanager
def tolerant_streams() -> Iterator[None]:
    """Make standard output and standard error tolerant within the block."""
    _fill_closed_descriptors()
    with Path(os.devnull).open("w") as nowhere:
        output = cast(TextIO, TolerantStream(sys.stdout or nowhere, "standard output"))
        messages = cast(TextIO, TolerantStream(sys.stderr or nowhere, "standard error"))
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # what the locale cannot write
        with redirect_stdout(output), redirect_stderr(messages):
            yield


def _fill_closed_descriptors() -> None:
    """Open closed standard streams on the null device; else the next file would take their number and their output."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


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


def names_of_list(context: click.Context, parameter: click.Parameter, value: str) -> tuple[str, ...]:
    """Read names from a text such as ``friction,rig.stiffness_x``; the callback of an option."""
    names = tuple(name.strip() for name in value.split(","))
    if not all(names):
        raise click.BadParameter(f"{value!r} is not a list of names; one such as friction,rig.stiffness_x is needed")
    return names


def pair_of_list(context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[str, str] | None:
    """Read two headings from a text such as ``Force (N),Stroke (um)``; the callback of an option."""
    if value is None:
        return None
    first, _, second = (part.strip() for part in value.partition(","))
    if not first or not second or "," in second:
        raise click.BadParameter(f"{value!r} is not two headings; a pair such as 'Force (N),Stroke (um)' is needed")
    return first, second


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
