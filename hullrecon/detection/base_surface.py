# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surface that structures stand on, and positions on it with their sigmas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.charts.address import AddressSigma, address, is_hull_chart, side_of
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import Point
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface
from hullrecon.typing import Array

# Sigma of an object's middle, as a share of its size, due to where its edge is drawn (measured: 5
# to 12 mm of 0.25 m)
MIDDLE_SHARE = 0.05


@dataclass(frozen=True, kw_only=True)
class HullError:
    """A hypothetical error of the hull pose, which moves all of the dive in M.

    With it results are computed again as if the hull pose were wrong, to propagate its covariance.
    """

    hull_pose: HullPose
    error: Array  # (6,) as in the covariance of the hull pose

    def points(self, points: Array) -> Array:
        """Move points (n, 3) of the dive in M as the error of the hull pose does."""
        # If the hull lies off by the error, the dive lies off in M by its opposite: the translation
        # (in g) and the turn about the survey's centre are undone
        center = self.hull_pose.survey_center
        shift = self.hull_pose.global_from_hull.rotation.inv().apply(self.error[:3]).reshape(3)
        return np.asarray(self._turn().apply(points - center - shift) + center)

    def poses(self, poses: Poses) -> Poses:
        """Move poses (n,) of the dive in M as the error of the hull pose does."""
        return Poses((self._turn() * poses.rotation).as_quat(), self.points(poses.translation))

    def _turn(self) -> Rotation:
        return Rotation.from_rotvec(-self.error[3:])


def area_sigma(area_if: Callable[[HullError], float], hull_pose: HullPose) -> float:
    """Compute the sigma, m2, of an area due to the hull pose, by central differences.

    The area is computed again with the hull pose off by one sigma, both ways along each of the six
    axes of its covariance. area_if: gives the area, m2, under such an error.
    """
    variance, axes = np.linalg.eigh(hull_pose.covariance)
    changes = []
    for error in (axes * np.sqrt(np.maximum(variance, 0.0))).T:
        more, less = (area_if(HullError(hull_pose=hull_pose, error=way * error)) for way in (1, -1))
        changes.append((more - less) / 2)
    return round(float(np.linalg.norm(changes)), 4)


@dataclass(frozen=True, kw_only=True)
class HullPosition:
    """Position of an object or a hole on the hull, with sigmas."""

    center: Array  # (3,) m in the frame of the results
    covariance: Array  # (3, 3) m2 of the centre, that of the hull pose included
    sigma: Array  # (3,) m along the hull, in girth, along the normal
    along_girth: Array  # (2,) m on the chart
    depth: float | None  # m, None where none was measured
    depth_sigma: float | None  # m

    @property
    def address_sigma(self) -> AddressSigma:
        """Sigmas that limit how fine an address in words may be."""
        return AddressSigma(
            along=float(self.sigma[0]), girth=float(self.sigma[1]), depth=self.depth_sigma or 0.0
        )

    def members(self, base: BaseSurface) -> dict[str, Any]:
        """Collect the fields of `PositionMembers`, as in objects.json and in coverage.json.

        Those that are unknown are None: along and girth off the chart, side and frame where the
        base is not a ship, the depth where it was not measured.
        """
        known = bool(np.isfinite(self.along_girth).all())
        along, girth = (round(float(v), 5) for v in self.along_girth) if known else (None, None)
        on_ship = known and is_hull_chart(base.chart)
        return {
            "position_covariance": [[float(f"{v:.6g}") for v in row] for row in self.covariance],
            "position_sigma": list(rounded(np.sqrt(np.diag(self.covariance)))),
            "sigma_along": round(float(self.sigma[0]), 5),
            "sigma_girth": round(float(self.sigma[1]), 5),
            "sigma_normal": round(float(self.sigma[2]), 5),
            "along": along,
            "girth": girth,
            "side": side_of(girth or 0.0, float(self.sigma[1])) if on_ship else None,
            "frame": round(along / base.frame_spacing_m, 2)
            if on_ship and along is not None and base.frame_spacing_m
            else None,
            "depth": None if self.depth is None else round(self.depth, 4),
            "depth_sigma": None if self.depth_sigma is None else round(self.depth_sigma, 4),
            "address": base.address_of(self.center, self.address_sigma),
        }


def hull_position(
    center: Array,
    normal: Array,
    measured: Array,
    height_sigma: float,
    middle_sigma: float,
    base: BaseSurface,
) -> HullPosition:
    """Compute an object's position on the hull with its sigmas.

    Errors of the landmarks of one object are nearly all common to them, so the mean of their
    covariances is taken for the object, without division by their number. The uncertainties of its
    height and of the middle of its outline are added. The sigma of its depth is that of the
    vertical in this covariance. Covariances in M hold the error of the hull pose, which changes no
    depth. There (`base.depth_sigma_m`) it comes from height, outline and water surface instead.

    Parameters
    ----------
    center, normal
        Centre (3,) m and outward normal (3,).
    measured
        Covariances (k, 3, 3) m2 of the object's landmarks, in the frame of the results. k >= 1.
    height_sigma
        Sigma of the height of its top above the hull, m: added along the normal.
    middle_sigma
        Sigma of the middle of its outline, m: added along the surface.
    base
        Gives the chart, and how points in the frame of the results lie below the water.
    """
    # Projects onto the surface: what is left of a vector without its part along the normal
    flat = np.eye(3) - np.outer(normal, normal)
    shape = height_sigma**2 * np.outer(normal, normal) + middle_sigma**2 * flat
    covariance = measured.mean(axis=0) + shape
    axes = np.array([*_tangents(center, normal, base), normal])
    depth = base.depth_of(center)
    # z of g points down
    down = base.result_from_global.rotation.as_matrix()[0][:, 2]
    own, surface = (covariance, 0.0) if base.depth_sigma_m is None else (shape, base.depth_sigma_m)
    return HullPosition(
        center=center,
        covariance=covariance,
        sigma=np.sqrt(np.einsum("ki,ij,kj->k", axes, covariance, axes)),
        along_girth=base.chart.to_chart(center[None])[0, :2],
        depth=depth,
        depth_sigma=None if depth is None else float(np.sqrt(down @ own @ down + surface**2)),
    )


def _tangents(center: Array, normal: Array, base: BaseSurface) -> tuple[Array, Array]:
    """Make unit vectors (3,) along the hull and in girth at a point, perpendicular to the normal.

    center, normal: (3,) m, and unit vector. Where the chart has no direction (beyond its ends),
    along is any axis that is not the normal.
    """
    along = tangents_at(base.chart, center[None])[0][0]
    along = along if np.isfinite(along).all() else np.eye(3)[int(np.argmin(np.abs(normal)))]
    along = along - normal * (along @ normal)
    along /= np.linalg.norm(along)
    # Charts are left-handed: along x girth = -normal
    return along, np.cross(along, normal)


def rounded(point: Array) -> Point:
    """Round the coordinates of a point (3,) to 0.01 mm, for JSON."""
    x, y, z = (round(float(v), 5) for v in point)
    return x, y, z


@dataclass(frozen=True, kw_only=True)
class BaseSurface:
    """The hull without structures, in the frame of the results (M, or g without a CAD model)."""

    cad_model: Mesh | None  # None where there is none, or it was refused
    surveyed: Surface  # the surface of the step surface, the base where there is no CAD model
    chart: Chart
    result_from_global: Poses  # a batch of one; the identity without a CAD model
    frame_spacing_m: float | None  # between the ship's frames, None where it is not known
    hull_pose: HullPose | None = None  # None without a CAD model
    # Whether z = 0 of g is the water surface, as with a pressure sensor
    depth_known: bool = True
    from_dvl: bool = True  # whether the surveyed surface is from DVL returns, not from landmarks
    position_sigma: AddressSigma | None = None  # of the survey as a whole
    # Sigma of the height of the water surface in g, which covariances in M do not contain. None in
    # g, or where it is not known
    depth_sigma_m: float | None = None

    @property
    def mesh(self) -> Mesh:
        """The CAD model, or the surveyed surface without one."""
        return self.surveyed.mesh() if self.cad_model is None else self.cad_model

    @property
    def frame(self) -> Frame:
        """The frame of all points: M, or g without a CAD model."""
        return Frame.GLOBAL if self.cad_model is None else Frame.HULL

    @property
    def description(self) -> str:
        """The surface from which heights are counted, in words."""
        return "the surface step's own surface" if self.cad_model is None else "the CAD model"

    def address_of(self, point: Array, sigma: AddressSigma | None = None) -> str:
        """Write the address of a point (3,) on the hull in words, no finer than its sigma.

        `sigma`: of the point. None: that of the survey as a whole.
        """
        depth = self.depth_of(point)
        depths = None if depth is None else [depth]
        return address(
            self.chart, point[None], self.frame_spacing_m, depths, sigma or self.position_sigma
        )[0]

    def depth_of(self, point: Array) -> float | None:
        """Compute the depth of a point (3,) below the water, m. None if not measured."""
        return (
            float(self.result_from_global.inverse().apply(point[None])[0, 2])
            if self.depth_known
            else None
        )
