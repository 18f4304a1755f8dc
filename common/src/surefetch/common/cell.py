"""The cell file: everything physical about one cell, and its information actions, as data."""

import tomllib
from importlib import resources
from pathlib import Path
from typing import Literal

import msgspec

from surefetch.common.errors import BadInput

Vector = tuple[float, float, float]


class CellValue(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A frozen part of a cell file; unknown and missing keys are errors."""


class Camera(CellValue, frozen=True):
    """The wrist camera and where it hangs on the flange."""

    width: int
    height: int
    vertical_fov_deg: float
    T_flange_camera_position_m: Vector
    T_flange_camera_rotvec_deg: Vector


class Home(CellValue, frozen=True):
    """Joints at rest."""

    q_deg: tuple[float, float, float, float, float, float]


class Speeds(CellValue, frozen=True):
    """Limits that the executor keeps."""

    joint_fraction: float
    """Of the maker's joint speeds"""
    joint_acceleration_rad_s2: float
    tcp_free_m_s: float
    tcp_near_m_s: float
    tcp_last_30mm_m_s: float
    grip_force_n: float


class LidPlace(CellValue, frozen=True):
    """Where a removed lid is set down."""

    position_m: Vector
    yaw_deg: float


class Delivery(CellValue, frozen=True):
    """Where a fetched object is put down."""

    name: str
    position_m: Vector


class View(CellValue, frozen=True):
    """A camera pose on a sphere about `look_at_m`. Azimuth 0: the robot's side, positive to -y."""

    name: str
    elevation_deg: float
    azimuth_deg: float
    distance_m: float


class InformRow(CellValue, frozen=True):
    """An information action."""

    name: str
    kind: Literal["view", "remove_cover"]
    view: str
    cost: float
    requires: Literal["open", "covered"]
    q: str


class Cell(CellValue, frozen=True):
    """One cell. The order of `informs` is the order that breaks ties."""

    name: str
    workspace_min_m: Vector
    workspace_max_m: Vector
    look_at_m: Vector
    camera: Camera
    home: Home
    speeds: Speeds
    lid_place: LidPlace
    delivery: Delivery
    views: tuple[View, ...]
    informs: tuple[InformRow, ...]
    covered_views: tuple[InformRow, ...] = ()
    """Views to look from while the container is covered; only some profiles take them."""

    def rows(self, *, views_while_covered: bool) -> tuple[InformRow, ...]:
        """Information actions in tie order, with or without those that look at a covered one."""
        return self.informs + (self.covered_views if views_while_covered else ())

    def view(self, name: str) -> View:
        """The view of this name. Raises BadInput that lists the names there are."""
        for row in self.views:
            if row.name == name:
                return row
        known = ", ".join(row.name for row in self.views)
        raise BadInput(f'cell "{self.name}" has no view "{name}".\n  Views: {known}')

    def inform(self, name: str) -> InformRow:
        """The information action of this name. Raises BadInput that lists the names there are."""
        rows = self.rows(views_while_covered=True)
        for row in rows:
            if row.name == name:
                return row
        known = ", ".join(row.name for row in rows)
        raise BadInput(f'cell "{self.name}" has no action "{name}".\n  Actions: {known}')


def read_cell(path: Path) -> Cell:
    """Read and check a cell file. Raises BadInput naming the file and the key."""
    try:
        return parse_cell(path.read_text(encoding="utf-8"), str(path))
    except OSError as error:
        raise BadInput(f"cell file {path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise BadInput(f"cell file {path} is no text: {error}") from None


def simulated_cell() -> Cell:
    """The cell file that ships with surefetch."""
    text = resources.files("surefetch.common").joinpath("cells/sim.toml").read_text("utf-8")
    return parse_cell(text, "cells/sim.toml")


def parse_cell(text: str, origin: str) -> Cell:
    """A checked cell from TOML text; `origin` names it in errors."""
    try:
        cell = msgspec.convert(tomllib.loads(text), Cell)
    except (tomllib.TOMLDecodeError, msgspec.ValidationError) as error:
        raise BadInput(f"cell file {origin}: {error}") from None
    for row in cell.rows(views_while_covered=True):
        cell.view(row.view)
    return cell
