"""Keys of a measured map, of heights or of friction: what its file does not say, and how it lies on the contact."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, StrictBool, ValidationInfo, field_validator, model_validator

from fretsolve.case.base import CaseModel, Length, Placed, PositiveLength, Repeated, each_once, refused_at
from fretsolve.case.dimensions import LENGTH, NUMBER
from fretsolve.case.quantities import InUnits, refused, shown

HDF5_SUFFIXES = (".h5", ".hdf5", ".hdf")

Level = Literal["none", "offset", "plane", "sphere", "quadratic"]
Resample = Literal["bilinear", "mean"]
Unit = Annotated[float, InUnits(LENGTH, above=0, bare_unit=True)]


def file_in_case_folder(value: object, info: ValidationInfo, example: str) -> Path:
    """Return the file that a value names relative to the case file; refuse what is no name."""
    if not isinstance(value, str) or not value or "\0" in value:
        raise refused(f"{shown(value)} is not the name of a file; one such as {example!r} is needed")
    folder = info.context if isinstance(info.context, Path) else Path()
    return (folder / value).absolute()


class MapKeys(CaseModel):
    """Keys that a map's file leaves to the case, and keys by which the map lies on the contact."""

    dataset: str | None = Field(
        default=None,
        description="name of the dataset in an HDF5 or .npz file, or of the channel in a file of an instrument",
        examples=["z"],
    )
    spacing: Annotated[tuple[PositiveLength, PositiveLength] | None, Repeated(2)] = Field(
        default=None,
        description="[dx, dy] of the map, or one value for both, unless the file gives it",
        examples=["5 um"],
    )
    xy_unit: Unit | None = Field(
        default=None, description="length unit of x and y in the file, unless it gives one; default as for the values"
    )
    override: StrictBool | None = Field(
        default=None, description="whether unit and spacing hold where the file says others", examples=[True]
    )
    transpose: StrictBool | None = Field(
        default=None, description="whether x and y of the file change places", examples=[True]
    )
    flip: Annotated[tuple[Literal["x", "y"], ...] | None, Repeated(1), AfterValidator(each_once)] = Field(
        default=None, description="directions in which the map is mirrored, after transpose", examples=["y", ["x", "y"]]
    )


class HeightsFile(CaseModel):
    """The file of a map, and what its values are."""

    file: Path = Field(description="file of the map, relative to the case file", examples=["heights.npy"])
    unit: Unit | None = Field(
        default=None,
        description="length unit of the values in the file, unless it gives one; default mm",
        examples=["um"],
    )
    lost: Annotated[float, InUnits(NUMBER)] | None = Field(
        default=None, description="value in the file that stands for lost points", examples=[-32768]
    )
    height_range: PositiveLength | None = Field(
        default=None, description="largest less smallest value, as a check of the unit", examples=["12 um"]
    )
    invert: StrictBool = Field(default=False, description="whether the file holds heights instead of separations")

    @field_validator("file", mode="before")
    @classmethod
    def _from_case_folder(cls, value: object, info: ValidationInfo) -> object:
        return file_in_case_folder(value, info, "heights.npy")


class HeightsSurface(Placed, MapKeys, HeightsFile):
    """A measured map: the separation itself, or with `invert` heights of body 1, whose negative it is."""

    kind: ClassVar[Literal["heights"]] = "heights"
    of_line: ClassVar[bool] = False
    crop: tuple[Length, ...] | None = Field(
        default=None,
        description="[x0, y0, x1, y1], the part that is kept, from the lower left point of the map",
        examples=[["0.2 mm", "0.2 mm", "0.8 mm", "0.8 mm"]],
    )
    spikes: Annotated[float, InUnits(NUMBER, above=0)] | None = Field(
        default=None,
        description="points this many standard deviations off the median around them count as lost",
        examples=[5],
    )
    fill: Annotated[float, InUnits(NUMBER, above=0, most=1)] | None = Field(
        default=None,
        description="fill holes smoothly, but refuse a map of which more is lost than this share",
        examples=["2 %"],
    )
    level: Level | None = Field(
        default=None, description="form that is taken off: its least-squares fit", examples=["plane"]
    )
    short_cutoff: PositiveLength | None = Field(
        default=None, description="Gaussian filter (ISO 16610): shorter waves are taken off", examples=["5 um"]
    )
    long_cutoff: PositiveLength | None = Field(
        default=None, description="Gaussian filter (ISO 16610): longer waves are taken off", examples=["0.8 mm"]
    )
    resample: Resample = Field(
        default="bilinear", description="height of a cell: at its centre, between points, or its mean"
    )

    @model_validator(mode="after")
    def _keys_fit(self) -> Self:
        if self.crop is not None:
            half, wanted = (
                (1, "[x0, x1] with x0 < x1") if self.of_line else (2, "[x0, y0, x1, y1] with x0 < x1, y0 < y1")
            )
            if len(self.crop) != 2 * half or any(a >= b for a, b in zip(self.crop, self.crop[half:], strict=False)):
                refused_at([(("crop",), f"{list(self.crop)} mm is no part of a map; {wanted} is needed")])
        if self.of_line and "y" in (self.flip or ()):
            refused_at([(("flip",), "a profile has no y; x is needed")])
        if (self.short_cutoff or 0.0) >= (self.long_cutoff or math.inf):
            message = f"{self.short_cutoff:g} mm is not shorter than long_cutoff ({self.long_cutoff:g} mm)"
            refused_at([(("short_cutoff",), f"{message}; a shorter one is needed")])
        return self
