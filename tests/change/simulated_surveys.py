# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surveys of a simulated hull without cameras: the true surface with smooth errors, placed on the
CAD model somewhat off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.ndimage import gaussian_filter

from hullrecon.geometry.charts.chart import Chart, chart_for_hull
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, exp, identity
from hullrecon.records.change import HullSurvey
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface
from hullrecon.synthetic.built_hull import deviation_m
from hullrecon.synthetic.hull_shapes import ship_form
from hullrecon.synthetic.items import Item, height_of
from hullrecon.synthetic.options import DiveSpec, Ship

ALONG, GIRTH, STEP = (30.0, 34.0), (4.2, 6.0), 0.03
SIGMAS = np.array([0.15, 0.03, 0.02, 0.002, 0.002, 0.003])  # of a hull pose: m, rad
NOISE_M = 0.002
BEFORE = (
    Item("cylinder", 30.6, 4.8, 0.11, (0.16, 0.16)),
    Item("dome", 31.6, 5.4, 0.12, (0.3, 0.3)),
    Item("box", 33.0, 4.8, 0.10, (0.26, 0.2)),
    Item("lump", 33.4, 5.5, 0.14, (0.42, 0.3)),
)


@cache
def cad_model() -> Mesh:
    return ship_form(Ship())


@cache
def chart() -> Chart:
    return chart_for_hull(cad_model())


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Of one dive. pose (6,): of its hull pose, about the survey's middle, in M; seed: of the
    smooth noise.
    """

    pose: np.ndarray
    seed: int
    noise_m: float = NOISE_M


def drawn(seed: int) -> Errors:
    """Errors of a dive, drawn at random."""
    return Errors(pose=SIGMAS * np.random.default_rng([seed, 7]).standard_normal(6), seed=seed)


NONE = Errors(pose=np.zeros(6), seed=0, noise_m=0.0)


def survey(
    items,
    errors=NONE,
    *,
    along=ALONG,
    girth=GIRTH,
    listed=None,
    bulge=None,
    name="dive",
    hull=1,
    step_m=STEP,
):
    """One dive over a window of the chart. listed: items that its detection reports, all if not
    given; bulge: (along, girth, width, height) of bare hull that stands off; step_m: from vertex to
    vertex.
    """
    a, g = np.meshgrid(np.arange(*along, step_m), np.arange(*girth, step_m), indexing="ij")
    points, normals = chart().from_chart(np.column_stack([a.ravel(), g.ravel()]))
    off = deviation_m(DiveSpec(seed=hull), a, g).ravel()
    for item in items:
        off += height_of(item, a.ravel(), g.ravel())
    if bulge is not None:
        off += (
            bulge[3]
            * np.exp(-0.5 * ((a - bulge[0]) ** 2 + (g - bulge[1]) ** 2) / bulge[2] ** 2).ravel()
        )
    off += _noise(a.shape, errors, step_m).ravel()
    center, back = _center(), _about_center(errors.pose)
    found = Surface(
        vertices=back.apply(points + normals * off[:, None]), faces=_faces(a.shape), deviation=off,
        sigma=np.full(len(off), 0.02), support=np.full(len(off), 5),
    )  # fmt: skip
    pose = HullPose(
        global_from_hull=identity(), covariance=np.diag(SIGMAS**2), survey_center=center
    )
    objects = tuple(
        _reported(k + 1, item, back, hull)
        for k, item in enumerate(items if listed is None else listed)
    )
    return HullSurvey(
        name=name,
        chart=chart(),
        as_found=found,
        form_sigma=np.full(len(off), 0.0025),
        hull_pose=pose,
        objects=objects,
    )


def _center() -> np.ndarray:
    middle = [np.mean(ALONG), np.mean(GIRTH)]
    return chart().from_chart(np.array([middle]))[0][0]


def _about_center(pose: np.ndarray) -> Poses:
    turn, center = exp(np.r_[np.zeros(3), pose[3:]]), _center()
    return Poses(turn.quaternion, (center + pose[:3] - turn.apply(center[None])[0])[None])


def _noise(shape: tuple[int, int], errors: Errors, step_m: float) -> np.ndarray:
    """What a hull as found is off by: alike over decimetres."""
    rng, out = np.random.default_rng([errors.seed, 3]), np.zeros(shape)
    for width_m, share in ((0.04, 0.5), (0.16, 0.7), (0.5, 0.5)):
        rough = gaussian_filter(rng.standard_normal(shape), width_m / step_m)
        out += share * errors.noise_m * rough / rough.std()
    return out


def _faces(shape: tuple[int, int]) -> np.ndarray:
    number = np.arange(np.prod(shape)).reshape(shape)
    a, b, c, d = (
        number[r, s].ravel() for r in (np.s_[:-1], np.s_[1:]) for s in (np.s_[:-1], np.s_[1:])
    )
    return np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)


def _reported(number: int, item: Item, back: Poses, hull: int) -> ReportedObject:
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    at = np.array([[item.along_m, item.girth_m]])
    ring = at + 0.5 * np.column_stack(
        [item.size_m[0] * np.cos(turn), item.size_m[1] * np.sin(turn)]
    )
    point, normal = chart().from_chart(at)
    top = item.height_m + deviation_m(DiveSpec(seed=hull), *at.T)[0]
    along, girth = tangents_at(chart(), point)
    assert np.isfinite(along).all()
    assert np.isfinite(girth).all()
    return ReportedObject(
        id=number,
        center=tuple(back.apply(point + top * normal)[0].tolist()),
        height=item.height_m,
        height_sigma=0.008,
        extent=item.size_m,
        outline=tuple(map(tuple, back.apply(chart().from_chart(ring)[0]).tolist())),
        sigma_along=0.15,
        sigma_girth=0.04,
        sigma_normal=0.02,
    )
