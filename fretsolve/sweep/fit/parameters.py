"""The parameters of a fit: keys of the case with a positive number, which the fit moves on a logarithmic scale."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from fretsolve.case.history import COMPONENTS
from fretsolve.case.loading import CaseText, case_model
from fretsolve.case.models import Case
from fretsolve.case.other_names import nearest
from fretsolve.case.quantities import QuantityError, shown, split_quantity
from fretsolve.case.schema import is_key, model_schema
from fretsolve.errors import CaseError, KeyPath, dotted

OF_THE_CONTACT = ("bodies", "surface", "friction", "rig", "interface", "load_path", "reference_depth")
"""The parts of a case whose numbers a loop may tell."""


@dataclass(frozen=True)
class Parameter:
    """A number of the case. name: as `--set` takes it; key: where it stands; start: its value there, in `unit`."""

    name: str
    key: KeyPath
    start: float
    unit: str

    def value(self, coordinate: float) -> float:
        """Return the value at a coordinate of the fit: the logarithm of the value over the start."""
        return self.start * math.exp(coordinate)

    def written(self, value: float, digits: int = 17) -> str:
        """Return a value as it stands in a case file."""
        return f"{value:.{digits}g} {self.unit}".rstrip()


def read_parameters(names: Sequence[str], text: CaseText, case: Case) -> tuple[Parameter, ...]:
    """Return the parameters of these names, as ``rig.stiffness_x``. text, case: the case with the values of `--set`.

    Raises CaseError for a name without a number, which says what the case has.
    """
    found: list[Parameter] = []
    for name in names:
        one = _read(name, text, case)
        if same := next((other for other in found if other.key == one.key), None):
            what = "given twice; once is enough" if same.name == name else f"the same as {same.name}; keep one of them"
            raise CaseError(f"is {what}", (), f"--for {name}")
        found.append(one)
    return tuple(found)


def _read(name: str, text: CaseText, case: Case) -> Parameter:
    origin, effective = f"--for {name}", case.effective()
    probe = text.overridden([f"{name}=1"], "--for")
    key = probe.source.overrides[-1].key if len(probe.source.overrides) > len(text.source.overrides) else ()
    for problem in probe.problems[len(text.problems) :]:  # as for an entry that a list does not have
        if problem.key and problem.key[0] in (*OF_THE_CONTACT, "stage"):
            raise CaseError(problem.message, (), origin)
    value = _at(text.data, key)
    if value is None:
        value = _at(effective, key)  # a default, or the constant of a material
    if key and (value is not None or key[0] in Case.model_fields) and key[0] not in OF_THE_CONTACT:
        raise CaseError(f"is no property of the contact; a number in {', '.join(OF_THE_CONTACT)} is needed", (), origin)
    if key and key[0] == "load_path" and key[-1] in COMPONENTS[3]:
        raise CaseError("is what the record gives; a property of the contact or of the rig is needed", (), origin)
    if value is None or not key:
        if key and is_key(key, model_schema(case_model(text.data))):
            example = f"--set {name}=VALUE with a unit"
            raise CaseError(f"has no value in the case; a value to start from is needed, as {example}", (), origin)
        of_materials = (one for one in _names(effective) if one.startswith("bodies."))
        known = dict.fromkeys([*_names(text.data), *of_materials])
        raise CaseError(f"is no key of the case; {nearest(name, known)}", (), origin)
    if isinstance(value, dict | list):
        inside = ", ".join(dict.fromkeys(f"{name}.{one}" for one in _leaves(value))) or "another key"
        raise CaseError(f"holds several values; {inside} is needed", (), origin)
    try:
        number, unit = split_quantity(value)
    except QuantityError:
        raise CaseError(f"is {shown(value)} in the case; a number is needed", (), origin) from None
    if number <= 0.0:
        message = f"is {shown(value)} in the case; a value above 0 to start from is needed, as --set {name}=VALUE"
        raise CaseError(message, (), origin)
    return Parameter(name, key, number, unit)


def _at(data: Any, key: KeyPath) -> Any:
    """Return the value at a key, None without one."""
    for part in key:
        inside = data if isinstance(data, dict) else dict(enumerate(data)) if isinstance(data, list) else {}
        data = inside.get(part)
    return data if key else None


def _names(data: Any) -> Iterator[str]:
    """Yield the names of the numbers that a fit could find."""
    for part in OF_THE_CONTACT[:-2]:
        if isinstance(data, dict) and part in data:
            yield from (f"{part}.{one}" if one else part for one in _leaves(data[part]))


def _leaves(data: Any) -> Iterator[str]:
    """Yield the names of the numbers in a value, as ``0.young_modulus``."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else None
    if entries is not None:
        for key, value in entries:
            yield from (dotted((key, one)) if one else str(key) for one in _leaves(value))
    elif not isinstance(data, bool):
        try:
            split_quantity(data)
        except QuantityError:
            return
        yield ""
