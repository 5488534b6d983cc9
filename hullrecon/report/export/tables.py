# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables that are delivered, as CSV with metadata: objects and trajectory."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from io import StringIO
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.charts.address import is_hull_chart, side_of
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.report.survey import Survey
from hullrecon.typing import Array

QUDT = "http://qudt.org/vocab/unit/"
WORDS = ("side", "address")  # columns of words
UNITS = {"m": "M", "rad": "RAD", "s": "SEC", "m2": "M2", "m3": "M3"}  # names of QUDT


Cells = tuple[str, str, str, Sequence[object]]  # name, unit, meaning and values of a column
# name, unit and meaning of a column of objects.csv, and what gives an object's value
ObjectColumn = tuple[str, str, str, Callable[[ReportedObject], object]]


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table."""

    name: str  # without its unit
    unit: str  # "" for words and for numbers without a unit
    meaning: str
    values: Sequence[object]
    words: bool = False  # whether its cells are words

    @property
    def heading(self) -> str:
        """Heading in the first row: the name and, if there is one, the unit."""
        return f"{self.name}_{self.unit}" if self.unit else self.name


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table that is delivered as a file."""

    file: str  # name below deliver/
    title: str  # what a row is
    columns: Sequence[Column]

    @property
    def csv(self) -> str:
        """The table as CSV."""
        return csv_text({column.heading: column.values for column in self.columns})


def csv_metadata(tables: Sequence[Table]) -> Mapping[str, object]:
    """Build csv-metadata.json: name, unit, meaning and type of the columns of tables."""
    return {
        "@context": "http://www.w3.org/ns/csvw",
        "tables": [
            {
                "url": table.file,
                "dc:title": table.title,
                "tableSchema": {"columns": [_entry(c) for c in table.columns]},
            }
            for table in tables
        ],
    }


def _entry(column: Column) -> dict[str, str]:
    """Describe a column in the terms of CSV on the Web."""
    entry = {
        "name": column.heading,
        "titles": column.heading,
        "datatype": "string" if column.words else "number",
        "dc:description": column.meaning,
    }
    if column.unit:
        entry |= {"unit": column.unit, "qudt:hasUnit": QUDT + UNITS[column.unit]}
    return entry


def seconds(t_ns: NDArray[np.int64]) -> list[str]:
    """Write times as seconds since 1970 with all nine decimals, which a float64 does not hold."""
    return [f"{t // 10**9}.{t % 10**9:09d}" for t in np.asarray(t_ns, np.int64).tolist()]


def numbers(values: NDArray[np.float64], form: str = ".9f") -> list[str]:
    """Format values as cells. A value that is not finite gives an empty cell."""
    return [format(v, form) if np.isfinite(v) else "" for v in np.asarray(values, float).tolist()]


def csv_text(table: Mapping[str, Sequence[object]]) -> str:
    """Write columns as CSV. Cells with a comma, a quote or a line end are quoted (RFC 4180)."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*table.values(), strict=True))
    return text.getvalue()


def _table(file: str, title: str, cells: Iterable[Cells]) -> Table:
    """Make a table of columns that are given as tuples."""
    columns = [
        Column(name=name, unit=unit, meaning=meaning, values=values, words=name in WORDS)
        for name, unit, meaning, values in cells
    ]
    return Table(file=file, title=title, columns=columns)


def objects_table(objects: Sequence[ReportedObject]) -> Table:
    """Make objects.csv (docs/deliverables.md): one row per object, as in objects.json."""
    cells = (
        (name, unit, meaning, [_object_cell(value(found)) for found in objects])
        for name, unit, meaning, value in _OBJECT_COLUMNS
    )
    return _table("objects.csv", "structures on the hull", cells)


def _object_cell(value: object) -> object:
    """Write a value with six significant digits if it is a number with decimals."""
    return f"{value:.6g}" if isinstance(value, float) else value


def _parts(field: str, names: Mapping[str, str], unit: str) -> list[ObjectColumn]:
    """Make a column for each part of a field, empty where an object lacks the field.

    names: the meaning of each column by its name, in the order of the parts.
    """

    def part(k: int, found: ReportedObject) -> object:
        parts = getattr(found, field)
        return None if parts is None else parts[k]

    return [
        (name, unit, meaning, partial(part, k)) for k, (name, meaning) in enumerate(names.items())
    ]


def _fields(*columns: tuple[str, str, str]) -> list[ObjectColumn]:
    """Make columns of fields of an object: name, unit, meaning."""
    return [(name, unit, meaning, attrgetter(name)) for name, unit, meaning in columns]


_OBJECT_COLUMNS = (  # in the order of the file, to which new ones are added at the end
    *_fields(("id", "", "number, as in objects.json")),
    *_parts("center", {f"center_{a}": "on the visible surface" for a in "xyz"}, "m"),
    *_parts("normal", {f"normal_{a}": "outward unit normal of the hull" for a in "xyz"}, ""),
    *_parts(
        "extent",
        {
            "extent_1": "size along the hull of the part above a quarter of the height",
            "extent_2": "size over the girth of the part above a quarter of the height",
        },
        "m",
    ),
    *_fields(
        ("height", "m", "above the hull around it, negative for a recess"),
        ("height_sigma", "m", "one sigma of the height"),
        ("deviation", "m", "largest signed distance to the CAD model"),
        ("area", "m2", "of the part above a quarter of the height"),
        ("volume", "m3", "of the same part, negative for a recess"),
        ("views", "", "images that show more than half of its top"),
        ("p_value", "", "probability that bare hull looks so anywhere in the survey"),
        ("address", "", "place in words"),
    ),
    ("image_count", "", "images that objects.json lists", lambda found: len(found.images)),
    *_parts("extent_sigma", {f"extent_{k}_sigma": "one sigma of the extent" for k in (1, 2)}, "m"),
    *_parts(
        "position_sigma",
        {f"position_sigma_{a}": f"one sigma of the center along {a}" for a in "xyz"},
        "m",
    ),
    *_fields(
        ("deviation_sigma", "m", "one sigma of the deviation, the hull's position included"),
        ("area_sigma", "m2", "one sigma of the area"),
        ("volume_sigma", "m3", "one sigma of the volume"),
        ("open_edge", "", "share of the outline beyond which nothing was measured"),
        ("sigma_along", "m", "one sigma of the center along the hull"),
        ("sigma_girth", "m", "one sigma of the center in girth"),
        ("sigma_normal", "m", "one sigma of the center along the normal"),
        ("along", "m", "along the hull"),
        ("girth", "m", "girth from the keel, port positive"),
        ("side", "", "port, starboard or keel"),
        ("frame", "", "number of the ship's frame"),
        ("depth", "m", "of the center below the water surface"),
        ("depth_sigma", "m", "one sigma of the depth"),
    ),
)


@dataclass(frozen=True, kw_only=True)
class ChartCoordinates:
    """Where n points lie on the ship."""

    along: Array  # (n,) m, NaN off the chart
    girth: Array
    side: list[str]  # "" off the ship
    frame: Array  # (n,) number of the ship's frame, NaN without a spacing


def chart_coordinates(survey: Survey, points: Array) -> ChartCoordinates:
    """Project points (n, 3) in the results' frame onto the chart. All are NaN without a chart."""
    chart, hull = survey.surfaces.chart, survey.facts.hull
    lost = np.full(len(points), np.nan)
    if chart is None or not len(points):
        return ChartCoordinates(along=lost, girth=lost, side=[""] * len(points), frame=lost)
    along, girth = chart.to_chart(points)[:, :2].T
    on_ship = is_hull_chart(chart)
    spacing = hull.frame_spacing if hull is not None and on_ship else None
    return ChartCoordinates(
        along=along,
        girth=girth,
        side=[side_of(float(g)) if on_ship and np.isfinite(g) else "" for g in girth],
        frame=along / spacing if spacing else lost,
    )


def trajectory_table(survey: Survey) -> Table:
    """Make trajectory.csv (docs/deliverables.md): one row per node."""
    track, frame = survey.track, survey.track.frame
    where, turn = f"position of the vehicle in {frame}", f"rotation of the vehicle in {frame}"
    cells: list[Cells] = [("t", "s", "since 1970 (UTC)", seconds(track.t_ns))]
    for name, values in zip("xyz", track.poses.translation.T, strict=True):
        cells.append((name, "m", where, numbers(values)))
    for name, values in zip(("qx", "qy", "qz", "qw"), track.poses.quaternion.T, strict=True):
        cells.append((name, "", f"{turn}, unit quaternion", numbers(values)))
    for (name, unit, what), values in zip(_SIGMAS, track.sigma[:, :6].T, strict=True):
        cells.append((f"sigma_{name}", unit, f"one sigma of {what}", numbers(values, ".6g")))
    cells.append(("tray", "rad", "angle of the tray", numbers(track.tray)))
    cells += _ship_cells(survey)
    return _table("trajectory.csv", "the vehicle at every node", cells)


_SIGMAS = (
    ("x", "m", "the position along x"),
    ("y", "m", "the position along y"),
    ("z", "m", "the position along z"),
    ("roll", "rad", "a small rotation about the vehicle's x"),
    ("pitch", "rad", "a small rotation about its y"),
    ("yaw", "rad", "a small rotation about its z"),
)


def _ship_cells(survey: Survey) -> list[Cells]:
    """Make the cells of the vehicle's chart coordinates, depth and their sigmas."""
    track = survey.track
    at = chart_coordinates(survey, track.poses.translation)
    along_sigma, girth_sigma = chart_sigmas(survey)
    depth = depth_sigma = np.full(len(at.along), np.nan)
    if survey.facts.has_depth:
        depth, depth_sigma = vehicle_depth(survey), vehicle_depth_sigma(survey)
    below = "along the hull, of the point below the vehicle"
    return [
        ("along", "m", below, numbers(at.along, ".4f")),
        ("girth", "m", "girth from the keel, port positive", numbers(at.girth, ".4f")),
        ("side", "", "port, starboard or keel", at.side),
        ("frame", "", "number of the ship's frame", numbers(at.frame, ".3f")),
        ("depth", "m", "below the water surface", numbers(depth, ".4f")),
        ("sigma_along", "m", "one sigma along the hull", numbers(along_sigma, ".6g")),
        ("sigma_girth", "m", "one sigma in girth", numbers(girth_sigma, ".6g")),
        ("depth_sigma", "m", "one sigma of the depth", numbers(depth_sigma, ".6g")),
    ]


def chart_sigmas(survey: Survey) -> tuple[Array, Array]:
    """Compute one sigma (n,) m of the vehicle along the hull and in girth, NaN off the chart."""
    track, chart = survey.track, survey.surfaces.chart
    if chart is None:
        return np.full(len(track.t_ns), np.nan), np.full(len(track.t_ns), np.nan)
    along, girth = map(track.sigma_towards, tangents_at(chart, track.poses.translation))
    return along, girth


def vehicle_depth(survey: Survey) -> Array:
    """Select the vehicle's depth (n,) m at the nodes: adjusted, else dead reckoned."""
    if survey.adjusted is not None:
        return survey.adjusted.solution.global_from_vehicle.translation[:, 2]
    return survey.trajectory.translation[:, 2]


def vehicle_depth_sigma(survey: Survey) -> Array:
    """Compute one sigma (n,) m of the depth at the nodes.

    In g it is that of the position. In M the covariance is relative to the hull, not to the water:
    there it is that of the pressure sensor's bias and noise, if that is known.
    """
    adjusted, nodes = survey.adjusted, len(survey.track.t_ns)
    if adjusted is None:
        return np.asarray(np.sqrt(survey.trajectory.covariance[:, 2, 2]))
    known = adjusted.depth_sigma_m
    if not survey.is_in_hull_frame or known is None:
        down = adjusted.solution.result_from_global().rotation.as_matrix()[:, :, 2]
        return survey.track.sigma_towards(np.broadcast_to(down, (nodes, 3)))
    return np.full(nodes, known)


def trajectory_tum(track: VehicleTrack) -> str:
    """Write the poses in the format of TUM: lines of `t x y z qx qy qz qw`, seconds and metres."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
