"""The constants of a material and where each of them was given, for messages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.loading import CaseText, read_case, validated
from fretsolve.case.source import CaseSource, parse
from fretsolve.errors import CaseError, KeyPath
from fretsolve.post.fatigue.criteria import require_constants

ALIKE = 1.1
"""Ratio of two Young's moduli of one material, of other tests or tempers, at most."""

ON_COMMAND_LINE = Path("--material")


@dataclass(frozen=True)
class KeysSource(CaseSource):
    """The origin of keys on the command line, which have no lines."""

    def locate(self, key: KeyPath) -> None:
        """Return None."""


@dataclass(frozen=True)
class MaterialSource:
    """A material, and where each of its constants was given; key: of the material in its source."""

    material: Material
    source: CaseSource
    key: KeyPath = ()

    def with_elastic_constants(self, body: dict[str, Any]) -> MaterialSource:
        """Return the material with the elastic constants of a body of an effective case, unless it has its own."""
        names = "young_modulus", "poisson_ratio"
        lacking = {name: float(body[name]) for name in names if getattr(self.material, name) is None and name in body}
        return replace(self, material=self.material.model_copy(update=lacking))

    def mismatch(self, body: dict[str, Any]) -> str | None:
        """Return a warning if Young's modulus is far from the modulus of a body, None if it is not."""
        own, other = self.material.young_modulus, body.get("young_modulus")
        if own is None or other is None or max(own / other, other / own) < ALIKE:
            return None
        return (
            f"young_modulus of the material is {own:g} MPa, of the body {other:g} MPa: lives follow from the first; is"
            " it the material of this body?"
        )

    def require(self, criteria: tuple[str, ...]) -> None:
        """Raise CaseError, with its place, for a constant that a criterion lacks or cannot use."""
        try:
            require_constants(criteria, self.material)
        except CaseError as error:
            raise self.source.problem(error.message, (*self.key, *error.key)) from None


def read_material(text: str) -> MaterialSource:
    """Return the material in a YAML file, or in keys such as ``tension_limit=300 MPa,torsion_limit=190 MPa``.

    Raises CaseError, FileError.
    """
    found = _from_keys(text) if "=" in text else read_case(text, pipe=True)
    found.require_mapping(list(Material.model_fields))
    return MaterialSource(validated(Material, found.data, found.source, found.problems), found.source)


def _from_keys(text: str) -> CaseText:
    pairs = [pair.partition("=") for pair in text.split(",")]
    wrong = next((key for key, equals, value in pairs if not (key.strip() and equals and value.strip())), None)
    if "{" in text or any("." in key for key, _, _ in pairs):
        message = f"{text!r} has constants within constants, as paris has; a YAML file is needed"
        raise CaseError(message, (), ON_COMMAND_LINE)
    if wrong is not None:
        raise CaseError(f"{text!r} is not a list KEY=VALUE,KEY=VALUE of constants", (), ON_COMMAND_LINE)
    with placed(lambda message: CaseError(message, (), ON_COMMAND_LINE)):
        parsed = parse("\n".join(f"{key.strip()}: {value.strip()}" for key, _, value in pairs))
    problems = [CaseError(flaw.message, flaw.key, ON_COMMAND_LINE) for flaw in parsed.flaws]
    return CaseText(parsed.value, KeysSource(ON_COMMAND_LINE, text, parsed.place), tuple(problems))


@contextmanager
def placed(with_place: Callable[[str], CaseError]) -> Iterator[None]:
    """Raise the errors of the block with a place; with_place: from a message to the error."""
    try:
        yield
    except CaseError as error:
        raise with_place(error.message) from None
