# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell which patches of the hull an imaging sonar saw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.hull_patches import Cubes, HullPatches
from hullrecon.detection.views import GRAZING
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import SonarPings
from hullrecon.typing import Array, Ints, Mask

SONAR_GRAZING = 0.25 * GRAZING  # cosine of the flattest incidence that gives a sonar return


@dataclass(frozen=True, kw_only=True)
class SonarSurvey:
    """The pings of an imaging sonar, and its poses at them."""

    pings: SonarPings
    poses: Poses  # result_from_sonar at each ping
    half_elevation_rad: float  # half of the aperture out of the fan


def visible_to_sonar(hull: HullPatches, sonar: SonarSurvey, scene: Scene) -> Mask:
    """Tell which patches (n,) lie in the fan of a ping, face the sonar, and are not occluded.

    The sonar's z axis points along the middle of the fan, x out of its plane (docs/conventions.md).
    Patches seen by an earlier ping, and those that a coarse test rules out, are not tested again.
    """
    pings, result_from_sonar = sonar.pings, sonar.poses
    bearing = np.arctan2(pings.directions[:, 1], pings.directions[:, 2])  # in the fan's plane
    out_of_plane = result_from_sonar.rotation.as_matrix()[:, :, 0]
    seen = np.zeros(len(hull.area), bool)
    for ping in range(len(result_from_sonar)):
        center = result_from_sonar.translation[ping]
        rows = hull.cubes.rows(_meets_fan(hull.cubes, center, out_of_plane[ping], sonar))
        rows = rows[~seen[rows]]
        rows = rows[_near_fan(hull, rows, center, out_of_plane[ping], sonar)]
        # In the fan: by range, elevation out of its plane, and bearing
        local = result_from_sonar[ping].inverse().apply(hull.mesh.vertices[rows])
        distance = np.maximum(np.linalg.norm(local, axis=1), 1e-9)
        at = np.arctan2(local[:, 1], local[:, 2])
        fits = (distance >= pings.range_m[0]) & (
            np.abs(np.arcsin(local[:, 0] / distance)) <= sonar.half_elevation_rad
        )
        rows = rows[fits & (at >= bearing.min()) & (at <= bearing.max())]
        # Facing the sonar, with nothing in between: a hit within 2 cm is the vertex itself
        ray = hull.mesh.vertices[rows] - center
        length = np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
        clear = -np.einsum("ni,ni->n", ray, hull.normal[rows]) / length > SONAR_GRAZING
        clear &= scene.cast(center, ray / length[:, None]) > length - 0.02
        seen[rows[clear]] = True
    return seen


def _meets_fan(cubes: Cubes, center: Array, out_of_plane: Array, sonar: SonarSurvey) -> Mask:
    """Mark the cubes (k,) whose sphere may reach into the sonar's fan at one ping.

    Patches in the others need no test. center: (3,) m of the sonar. out_of_plane: unit vector (3,)
    across its fan.
    """
    # A sphere is in range if its nearest point is. Its part out of the plane is compared with the
    # aperture at its farthest point, where the fan is widest.
    ray = cubes.middle - center
    farthest = np.linalg.norm(ray, axis=1) + cubes.radius
    return np.asarray(
        (farthest - 2 * cubes.radius <= sonar.pings.range_m[-1])
        & (np.abs(ray @ out_of_plane) - cubes.radius <= _elevation_sine(sonar) * farthest)
    )


def _near_fan(
    hull: HullPatches, rows: Ints, center: Array, out_of_plane: Array, sonar: SonarSurvey
) -> Mask:
    """Tell which of some patches may be in a ping's fan: a fast first test.

    Tested are the farthest range, elevation (to rounding) and incidence, without computing angles.
    So a patch that passes may still be too near, or beside the fan.

    Parameters
    ----------
    hull
        Middles and normals of all patches.
    rows
        The patches that are tested.
    center, out_of_plane
        Position (3,) m of the sonar, and its x axis (3,), across the fan's plane.
    sonar
        Gives range and aperture.
    """
    ray = hull.mesh.vertices[rows] - center
    distance = np.linalg.norm(ray, axis=1)
    facing = -np.einsum("ni,ni->n", ray, hull.normal[rows])
    return np.asarray(
        (distance <= sonar.pings.range_m[-1])
        & (np.abs(ray @ out_of_plane) <= _elevation_sine(sonar) * distance)
        & (facing > (SONAR_GRAZING - 1e-9) * distance)
    )


def _elevation_sine(sonar: SonarSurvey) -> float:
    """Compute the sine of half the aperture out of the fan, rounded up."""
    return float(np.sin(min(sonar.half_elevation_rad, np.pi / 2)) + 1e-9)
