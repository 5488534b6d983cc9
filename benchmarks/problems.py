# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Adjustment problems of the field's size [Ozog2016 Table 4.1] on a ship's side, with truth,
started from dead reckoning.

Each landmark is seen from two poses: neighbours on a leg, one in eight from the neighbouring leg (a
loop closure, [Ozog2016 4.4]).

Realistic: the counts; legs of 115 m, 0.25 m apart, on a side with curvature both ways; a start by
the raw log (DVL scale and mounting angle, a gyro's bias and random walk: decimetres between
neighbouring legs, a metre or so in the whole); landmarks triangulated from that start; noise of 1
px; mounts, tray and the place on the CAD model off by what a rig and a registration leave; one
landmark in twenty off the hull. Not realistic: the CAD model is right and the hull scatters by 5 mm
about it, where sigma_1 is 2 cm; matches are all true; each landmark has exactly two views; scale
and mounting angle are calibrated in the odometry's factors ([Ozog2016] has no such unknowns, the
chain solves for them). With 2 cm of scatter the joint maximum over landmarks and scale would shrink
the mono survey by 0.06 %: the scatter's cost falls with the scale by one unit a landmark, and
odometry alone holds against it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.start import SIGMA_ODOMETRY, dead_reckoned, measure, mount_error, triangulate
from benchmarks.survey import (
    BEAMS,
    CAMERA,
    SIZES,
    TOP_FROM_BOTTOM,
    TRAY_FROM_DVL,
    TRAY_FROM_TOP,
    TRAY_ORIGIN,
    Size,
    fly,
    hull_mesh,
    tracks,
)
from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.native import (
    AttitudeTable,
    CadMesh,
    LeverArms,
    MeshIndex,
    MonoTable,
    MotionPrior,
    OdometryTable,
    PosePriors,
    Priors,
    Problem,
    RangeTable,
    StereoTable,
    SurfaceTable,
    TrayTable,
    Unknowns,
)
from hullrecon.typing import Array, Ints, Ints32, Mask

__all__ = ["SIZES", "Size", "Truth", "make", "simulate"]

NOISE_PX, SCATTER_M, OFF_HULL = 1.0, 0.005, 0.05
ACROSS = 0.125
BACKLASH_RAD = np.radians(0.5)


@dataclass(frozen=True)
class Truth:
    """The true values of the unknowns of a problem."""

    nodes: Poses  # (n,) T_g_v
    tray: Array  # (n,) rad
    global_from_hull: Poses
    tray_from_top: Poses
    landmark: Array  # (L, 3) m in g
    off_hull: Mask  # (L,)


def make(size: Size, seed: int = 0) -> Problem:
    """Simulate a problem as `simulate` does, without its truth."""
    return simulate(size, seed)[0]


def simulate(
    size: Size, seed: int = 0, *, scatter_m: float = SCATTER_M, off_hull: float = OFF_HULL
) -> tuple[Problem, Truth]:
    """Simulate a problem, started from dead reckoning, and its truth.

    scatter_m: standard deviation of landmarks about the CAD model. off_hull: share of landmarks
    that stand off the hull.
    """
    rng = np.random.default_rng(seed)
    vertices, faces = hull_mesh(depth_m=size.depth_m)
    hull = MeshIndex(vertices, faces, threads=1)
    in_hull, tray = fly(size)
    global_from_hull = poses.from_rpy([3.0, 20.0, 13.0], np.radians([180.0, 0.3, 40.0]))
    nodes = global_from_hull @ in_hull
    first, second = _pairs(size, rng)
    in_cad_model, off = _landmarks(
        size, hull, in_hull, tray, first, second, rng, scatter_m, off_hull
    )
    landmark = global_from_hull.apply(in_cad_model)
    truth = Truth(nodes, tray, global_from_hull, TRAY_FROM_TOP, landmark, off)
    unknowns, priors = _mounts(global_from_hull, rng)
    attitude = _attitude(nodes, rng)
    tray_table = _tray(tray, rng)
    measured = measure(nodes, rng)
    start = dead_reckoned(nodes, measured, rng)
    pose = np.hstack([start.translation, start.quaternion, tray_table.measured[:, None]])
    ranges = _ranges(hull, in_hull, tray, rng)
    stereo, mono = _images(size, truth, first, second, rng)
    pixel = stereo.pixel[::2] if size.stereo else mono.pixel
    seen_from = stereo.node if size.stereo else mono.node
    mount = poses.pose_from_vector(unknowns.T_s_ct)
    first_landmarks = _start_landmarks(
        size, start, tray_table.measured, mount, ranges, seen_from, pixel
    )
    problem = Problem(
        unknowns=replace(unknowns, pose=pose, landmark=first_landmarks),
        constant=("T_ct_cb", "T_s_d", "intrinsics_bottom", "intrinsics_top", "navigation"),
        cad_mesh=CadMesh(vertices=vertices, faces=faces),
        lever_arms=LeverArms(tray=TRAY_ORIGIN),
        priors=replace(priors, pose=_gauge(pose)),
        attitude=attitude,
        tray=tray_table,
        odometry=_odometry(measured),
        stereo=stereo,
        mono=mono,
        sigma_px=NOISE_PX,
        ranges=ranges,
        surface=SurfaceTable(
            landmark=np.arange(size.landmarks, dtype=np.int32), weight=np.ones(size.landmarks)
        ),
    )
    return problem, truth


def _mounts(global_from_hull: Poses, rng: np.random.Generator) -> tuple[Unknowns, Priors]:
    """Make start values and priors of T_g_M and T_s_ct.

    T_g_M starts where a registration would leave it (0.3 m off along the hull), T_s_ct at the rig's
    CAD model. Both priors have that size.
    """
    guess = poses.pose_vector(
        global_from_hull @ poses.exp(np.r_[0.3, 0.1, 0.05, 0.002, 0.002, 0.005])
    )
    guess_rows = np.diag(1 / np.r_[0.5, 0.2, 0.1, 0.005, 0.005, 0.01])
    camera = poses.pose_vector(TRAY_FROM_TOP @ mount_error(rng, 0.003, 0.004))
    camera_rows = np.diag(1 / np.r_[np.full(3, 0.003), np.full(3, 0.004)])
    unknowns = Unknowns(
        pose=np.zeros((0, 8)),
        T_g_M=guess,
        T_s_ct=camera,
        T_ct_cb=poses.pose_vector(TOP_FROM_BOTTOM),
        T_s_d=poses.pose_vector(TRAY_FROM_DVL),
        intrinsics_top=CAMERA.parameters(),
        intrinsics_bottom=CAMERA.parameters(),
    )
    priors = Priors(
        T_g_M=MotionPrior(value=guess, sqrt_information=guess_rows),
        T_s_ct=MotionPrior(value=camera, sqrt_information=camera_rows),
    )
    return unknowns, priors


def _attitude(nodes: Poses, rng: np.random.Generator) -> AttitudeTable:
    n = len(nodes)
    sigma = np.r_[0.02, np.radians([0.1, 0.1])]
    truth = np.c_[nodes.translation[:, 2], roll_pitch_yaw(nodes.rotation)[:, :2]]
    measured = truth + sigma * rng.standard_normal((n, 3))
    return AttitudeTable(
        node=np.arange(n, dtype=np.int32), measured=measured, sigma=np.tile(sigma, (n, 1))
    )


def _tray(tray: Array, rng: np.random.Generator) -> TrayTable:
    """Make the tray's table: its error is the backlash, by the sense in which it last moved.

    It never hangs between its two sides.
    """
    n = len(tray)
    sense = np.sign(np.diff(tray, prepend=tray[0]))
    moved = np.flatnonzero(sense)
    last = np.maximum(np.searchsorted(moved, np.arange(n), side="right") - 1, 0)
    backlash = BACKLASH_RAD * (sense[moved][last] if len(moved) else np.ones(n))
    measured = tray + backlash + np.radians(0.05) * rng.standard_normal(n)
    node = np.arange(n, dtype=np.int32)
    return TrayTable(
        node=node, measured=measured, direction=np.zeros(n), sigma=np.full(n, BACKLASH_RAD)
    )


def _odometry(measured: Poses) -> OdometryTable:
    m = len(measured)
    return OdometryTable(
        first=np.arange(m, dtype=np.int32),
        second=np.arange(1, m + 1, dtype=np.int32),
        measured=np.hstack([measured.translation, measured.quaternion]),
        sqrt_information=np.tile(np.diag(1 / SIGMA_ODOMETRY), (m, 1, 1)),
        by_navigation=np.zeros((m, 6, 2)),
        by_mount=np.zeros((m, 6, 3)),
        by_tray=np.zeros((m, 6)),
        tray=np.zeros(m),
        mount=poses.pose_vector(TRAY_FROM_DVL),
    )


def _gauge(pose: Array) -> PosePriors:
    """Make the prior of the first pose, which fixes g as the frame of dead reckoning."""
    rows = np.diag(1 / np.r_[0.001, 0.001, 0.02, 0.002, 0.002, 0.001])[None]
    return PosePriors(node=np.zeros(1, np.int32), value=pose[:1, :7].copy(), sqrt_information=rows)


def _ranges(hull: MeshIndex, in_hull: Poses, tray: Array, rng: np.random.Generator) -> RangeTable:
    n = len(in_hull)
    dvl = in_hull @ poses.tray_poses(TRAY_ORIGIN, tray) @ TRAY_FROM_DVL
    node, beam = np.repeat(np.arange(n, dtype=np.int32), 4), np.tile(BEAMS, (n, 1))
    hits = hull.cast(dvl.translation[node], dvl.rotation[node].apply(beam))
    if not np.isfinite(hits.range).all():
        raise ValueError("a beam misses the hull: the legs leave it")
    return RangeTable(
        node=node,
        offset=np.tile([0, 0, 0, 0, 0, 0, 1.0], (4 * n, 1)),
        tray_offset=np.zeros(4 * n),
        beam=beam,
        measured=hits.range + 0.01 * rng.standard_normal(4 * n),
        sigma=np.full(4 * n, 0.01),
    )


def _pairs(size: Size, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Choose the two poses of each landmark.

    The second is the next image, or for one landmark in eight the nearest image at the same place
    of the next leg.
    """
    images = size.images()
    number = np.sort(rng.integers(0, size.imaged - 1, size.landmarks))
    first, second = images[number], images[number + 1]
    leg, place = first // size.per_leg, first % size.per_leg
    facing = (leg + 1) * size.per_leg + size.per_leg - 1 - place
    after = np.clip(np.searchsorted(images, facing), 1, size.imaged - 1)
    before, after = images[after - 1], images[after]
    nearest = np.where(facing - before <= after - facing, before, after)
    across = (rng.random(size.landmarks) < ACROSS) & (facing <= images[-1]) & (nearest > first)
    return first, np.where(across, nearest, second)


def _landmarks(
    size: Size,
    hull: MeshIndex,
    in_hull: Poses,
    tray: Array,
    first: Ints,
    second: Ints,
    rng: np.random.Generator,
    scatter_m: float,
    off_hull: float,
) -> tuple[Array, Mask]:
    """Draw landmarks (L, 3) in M that both of their poses see, and tell which are off the hull.

    A share of `off_hull` lies 0.1 to 0.3 m off the hull [Ozog2016 Fig. 4.15], the others scatter
    about it.
    """
    x, z = tracks(size)
    points = np.empty((size.landmarks, 3))
    off = rng.random(size.landmarks) < off_hull
    height = np.where(
        off, rng.uniform(0.1, 0.3, size.landmarks), scatter_m * rng.standard_normal(size.landmarks)
    )
    wanted, spread = np.arange(size.landmarks), 1.0
    while len(wanted):
        a, b = first[wanted], second[wanted]
        shift = spread * rng.uniform([-0.3, -0.2], [0.3, 0.2], (len(wanted), 2))
        origin = np.stack(
            [
                0.5 * (x[a] + x[b]) + shift[:, 0],
                np.full(len(a), 30.0),
                0.5 * (z[a] + z[b]) + shift[:, 1],
            ],
            1,
        )
        hits = hull.cast(origin, np.tile([0.0, -1.0, 0.0], (len(a), 1)))
        points[wanted] = (
            origin
            - np.c_[np.zeros(len(a)), hits.range, np.zeros(len(a))]
            + height[wanted, None] * hits.normal
        )
        seen = _seen(in_hull, tray, a, points[wanted], size.stereo) & _seen(
            in_hull, tray, b, points[wanted], size.stereo
        )
        wanted, spread = wanted[~seen], 0.9 * spread
        height[wanted] *= 0.9
    return points, off


def _seen(in_hull: Poses, tray: Array, node: Ints, points: Array, stereo: bool) -> Mask:
    return within(project(in_hull[node], tray[node], points, TRAY_FROM_TOP, stereo))


def within(pixels: Array) -> Mask:
    """Tell whether pixels (m, 2) or (m, 4) lie well inside their images."""
    images = pixels.shape[1] // 2
    inside = (pixels > 5) & (pixels < np.tile([CAMERA.width - 5, CAMERA.height - 5], images))
    return np.asarray(inside.all(1))


def project(nodes: Poses, tray: Array, points: Array, tray_from_top: Poses, stereo: bool) -> Array:
    """Project points (m, 3), each from its own node, to pixels (m, 2) or (m, 4)."""
    top = nodes @ poses.tray_poses(TRAY_ORIGIN, tray) @ tray_from_top
    in_top = top.inverse().apply(points)
    pixels = [CAMERA.project(in_top)]
    if stereo:
        pixels.append(CAMERA.project(TOP_FROM_BOTTOM.inverse().apply(in_top)))
    return np.hstack(pixels)


def _images(
    size: Size, truth: Truth, first: Ints, second: Ints, rng: np.random.Generator
) -> tuple[StereoTable, MonoTable]:
    node, landmark = (
        np.stack([first, second], 1).ravel(),
        np.repeat(np.arange(size.landmarks).astype(np.int32), 2),
    )
    pixels = project(
        truth.nodes[node], truth.tray[node], truth.landmark[landmark], TRAY_FROM_TOP, size.stereo
    )
    pixels += NOISE_PX * rng.standard_normal(pixels.shape)
    seen_from = node.astype(np.int32)
    if size.stereo:
        return StereoTable(node=seen_from, landmark=landmark, pixel=pixels), MonoTable()
    top = np.zeros(len(node), np.int32)
    return StereoTable(), MonoTable(node=seen_from, landmark=landmark, camera=top, pixel=pixels)


def _start_landmarks(
    size: Size,
    start: Poses,
    tray: Array,
    mount: Poses,
    ranges: RangeTable,
    seen_from: Ints32,
    pixel: Array,
) -> Array:
    """Triangulate the landmarks' start values as a front end does.

    With stereo they come from the first pair, with one camera from both images.
    """
    node = seen_from.reshape(-1, 2)
    pixel = pixel.reshape(size.landmarks, 2, 2)
    range_m = ranges.measured.reshape(-1, 4).mean(1)[node[:, 0]]
    origins, rays = np.empty((size.landmarks, 2, 3)), np.empty((size.landmarks, 2, 3))
    for k in range(2):
        at = node[:, 0 if size.stereo else k]
        camera = start[at] @ poses.tray_poses(TRAY_ORIGIN, tray[at]) @ mount
        camera = camera @ TOP_FROM_BOTTOM if size.stereo and k == 1 else camera
        origins[:, k], rays[:, k] = (
            camera.translation,
            camera.rotation.apply(CAMERA.rays(pixel[:, k])),
        )
    return triangulate(origins, rays, range_m)
