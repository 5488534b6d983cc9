# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import load_arrays
from hullrecon.dive.config import schema
from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import chart_for_hull, chart_from_arrays
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.steps.surface import STAGE
from hullrecon.surface.options import SurfaceOptions

RADIUS, OFF = 3.0, 0.02  # a cylinder along x about (0, 3), drawn 2 cm too small
TURN = (0.0, 0.0, 0.0, 180.0, 0.0, 0.0)  # T_g_M: z down against z up
DVL_MOUNT = (0, 0, 0, 90, 0, 0)


def _hull() -> Mesh:
    x, angle = np.linspace(0, 10, 21), np.radians(np.linspace(-120, 120, 81))
    vertices = np.array([[a, RADIUS * np.sin(t), 3 - RADIUS * np.cos(t)] for a in x for t in angle])
    i, j = np.meshgrid(np.arange(20), np.arange(80), indexing="ij")
    a = (i * 81 + j).ravel()
    faces = np.concatenate([np.stack([a, a + 81, a + 82], 1), np.stack([a, a + 82, a + 1], 1)])
    center = vertices[faces].mean(axis=1) - [0, 0, 3]
    corner = vertices[faces]
    inward = (
        np.einsum(
            "ni,ni->n",
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) * [0, 1, 1],
            center,
        )
        < 0
    )
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(vertices, faces.astype(np.int32))


def _dive(rng: np.random.Generator) -> tuple[Poses, Returns]:
    """A vehicle at port, y = 4.5 m, moving along x; beams in the dvl frame, whose z looks along -y
    of M.
    """
    n = 60
    x, z = np.tile(np.linspace(3, 7, 20), 3), np.repeat([2.4, 3.0, 3.6], 20)
    hull_from_vehicle = Poses(
        np.tile([0.0, 0, 0, 1], (n, 1)), np.column_stack([x, np.full(n, 4.5), z])
    )
    node, beams = (
        np.repeat(np.arange(n), 4),
        np.tile([[0.3, 0, 1], [-0.3, 0, 1], [0, 0.3, 1], [0, -0.3, 1.0]], (n, 1)),
    )
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    mount = from_mount(DVL_MOUNT)
    direction = mount.rotation.apply(beams)  # in v, which here is turned like M
    start = hull_from_vehicle.translation[node] - [0, 0, 3]
    grown = RADIUS + OFF
    b, a = (start * direction)[:, 1:].sum(1), (direction[:, 1:] ** 2).sum(1)
    reach = (-b - np.sqrt(b**2 - a * ((start[:, 1:] ** 2).sum(1) - grown**2))) / a
    global_from_hull = from_mount(TURN)
    zero = np.zeros(len(node))
    returns = Returns(
        t_ns=node.astype(np.int64),
        node=node,
        quaternion=np.tile([0.0, 0, 0, 1], (len(node), 1)),
        translation=np.zeros((len(node), 3)),
        tray_offset=zero,
        beam=beams,
        range_m=reach + rng.normal(0, 0.005, len(node)),
        flagged=zero > 0,
    )
    return global_from_hull[np.zeros(n, int)] @ hull_from_vehicle, returns


def _solution(global_from_vehicle: Poses, landmarks: np.ndarray) -> Solution:
    n, m = len(global_from_vehicle), len(landmarks)
    return Solution(
        t_ns=np.arange(n),
        image=np.full((n, 2), -1),
        global_from_vehicle=global_from_vehicle,
        tray=np.zeros(n),
        tray_sigma=np.zeros(n),
        pose_covariance=np.tile(1e-6 * np.eye(6), (n, 1, 1)),
        landmarks=Landmarks(
            position=landmarks,
            covariance=np.tile(4e-6 * np.eye(3), (m, 1, 1)),
            label=np.ones(m, np.int64),
            deviation=np.full(m, OFF),
            views=np.full(m, 4),
            color=np.zeros((m, 3), np.uint8),
        ),
        mounts=Mounts(
            tray_from_dvl=from_mount(DVL_MOUNT), tray_from_top=None, top_from_bottom=None
        ),
        navigation_errors=np.zeros(6),
        hull_pose=HullPose(
            global_from_hull=from_mount(TURN),
            covariance=1e-6 * np.eye(6),
            survey_center=np.zeros(3),
        ),
        deviation_field=None,
    )


class EarlierSteps:
    """Artifacts of the earlier steps in folders, to be spoilt by a test before `run`."""

    def __init__(self, root: Path) -> None:
        rng = np.random.default_rng(8)
        self.root, self.hull = root, _hull()
        self.global_from_vehicle, self.returns = _dive(rng)
        angle, x = np.radians(rng.uniform(75, 105, 600)), rng.uniform(3, 7, 600)
        grown = RADIUS + OFF
        marks = np.column_stack([x, grown * np.sin(angle), 3 - grown * np.cos(angle)])
        self.solution = _solution(self.global_from_vehicle, from_mount(TURN).apply(marks))
        self.sections = {
            "tray": schema.Tray(),
            "dvl": schema.Dvl(mount=DVL_MOUNT),
            "hull": schema.Hull(mesh="hull.stl", pose=TURN),
        }

    def without_cad_model(self) -> None:
        self.sections["hull"] = None
        self.solution = replace(self.solution, hull_pose=None)

    def run(self, adjusted: bool = True, dvl: bool = True, **options: object) -> Path:
        ingest, navigate, adjust = (self._folder(name) for name in ("ingest", "navigate", "adjust"))
        if self.sections["hull"] is not None:
            np.savez(ingest / "hull.npz", vertices=self.hull.vertices, faces=self.hull.faces)
            np.savez(adjust / "chart.npz", **chart_for_hull(self.hull).to_arrays())
        if dvl:
            np.savez(navigate / "returns.npz", **to_arrays(self.returns))
        n = len(self.global_from_vehicle)
        track = Trajectory(
            t_ns=np.arange(n), quaternion=self.global_from_vehicle.quaternion, translation=self.global_from_vehicle.translation,
            covariance=np.tile(1e-4 * np.eye(6), (n, 1, 1)), tray=np.zeros(n),
            image=np.full((n, 2), -1),
        )  # fmt: skip
        np.savez(navigate / "trajectory.npz", **to_arrays(track))
        np.savez(adjust / "solution.npz", **to_arrays(self.solution))
        inputs = {"ingest": ingest, "navigate": navigate} | ({"adjust": adjust} if adjusted else {})
        return run_stage(
            STAGE,
            {**self.sections, "surface": SurfaceOptions(**options)},
            inputs,
            self.root / "surface",
        )

    def _folder(self, name: str) -> Path:
        path = self.root / name
        path.mkdir()
        return path


@pytest.fixture
def earlier(tmp_path: Path) -> EarlierSteps:
    return EarlierSteps(tmp_path)


def _read(out: Path) -> tuple[Surface, dict[str, object]]:
    return from_arrays(Surface, load_arrays(out / "surface.npz")), json.loads(
        (out / "surface.json").read_text()
    )


def _radius(surface: Surface) -> np.ndarray:
    return np.hypot(surface.vertices[:, 1], surface.vertices[:, 2] - 3)


def test_the_surface_lies_where_the_returns_were_and_knows_its_deviation(
    earlier: EarlierSteps,
) -> None:
    surface, facts = _read(earlier.run())
    assert np.sqrt(np.mean((_radius(surface) - RADIUS - OFF) ** 2)) < 0.004
    assert np.median(surface.deviation) == pytest.approx(OFF, abs=0.004)
    assert facts["poses"] == "adjusted"
    assert facts["returns"] == 240
    assert facts["used"] + facts["outliers"] + facts["flagged"] == 240


def test_the_chart_of_the_adjustment_is_passed_on(earlier: EarlierSteps) -> None:
    out = earlier.run()
    at = np.array([[5.0, 3.0, 3.0]])
    assert np.allclose(
        chart_from_arrays(load_arrays(out / "chart.npz")).to_chart(at),
        chart_for_hull(earlier.hull).to_chart(at),
    )


def test_without_an_adjustment_the_first_guess_places_the_dive(earlier: EarlierSteps) -> None:
    surface, facts = _read(earlier.run(adjusted=False))
    assert np.sqrt(np.mean((_radius(surface) - RADIUS - OFF) ** 2)) < 0.004
    assert surface.sigma.min() > 0.5  # hull.pose_sigma: 1 m
    assert "hull.pose" in str(facts["poses"])


def test_without_an_adjustment_the_chart_has_the_bow_and_the_stations_of_dive_toml(
    earlier: EarlierSteps,
) -> None:
    earlier.sections["hull"] = schema.Hull(
        mesh="hull.stl", pose=TURN, bow="-x", aft_perpendicular=11.0
    )
    chart = chart_from_arrays(load_arrays(earlier.run(adjusted=False) / "chart.npz"))
    at, plain = np.array([[5.0, 2.9, 3.0]]), chart_for_hull(earlier.hull)
    along, girth, _ = chart.to_chart(at)[0]
    assert along == pytest.approx(6.0)
    assert girth == pytest.approx(-plain.to_chart(at)[0, 1], abs=0.01)


def test_without_a_cad_model_the_surface_is_in_g_and_has_no_deviation(
    earlier: EarlierSteps,
) -> None:
    earlier.without_cad_model()
    surface, _ = _read(earlier.run())
    y, z = surface.vertices[:, 1], -surface.vertices[:, 2]
    assert np.abs(np.hypot(y, z - 3) - RADIUS - OFF).max() < 0.05
    assert np.isnan(surface.deviation).all()


def test_flagged_returns_are_left_out_and_counted(earlier: EarlierSteps) -> None:
    flagged = np.arange(240) % 10 == 0
    earlier.returns = replace(
        earlier.returns, flagged=flagged, range_m=earlier.returns.range_m + 0.8 * flagged
    )
    surface, facts = _read(earlier.run())
    assert facts["flagged"] == 24
    assert np.abs(_radius(surface) - RADIUS - OFF).max() < 0.03


def test_landmarks_sharpen_the_surface_when_asked(earlier: EarlierSteps) -> None:
    earlier.returns = replace(
        earlier.returns,
        range_m=earlier.returns.range_m + np.random.default_rng(0).normal(0, 0.02, 240),
    )
    surface, facts = _read(earlier.run(landmarks=True))
    assert int(str(facts["observations"])) > 240
    middle = np.abs(surface.vertices[:, 2] - 3) < 0.7
    assert np.sqrt(np.mean((_radius(surface)[middle] - RADIUS - OFF) ** 2)) < 0.004


def test_without_a_dvl_the_landmarks_make_the_surface(earlier: EarlierSteps) -> None:
    surface, facts = _read(earlier.run(dvl=False))
    assert facts["returns"] == 0
    assert np.sqrt(np.mean((_radius(surface) - RADIUS - OFF) ** 2)) < 0.003


def test_with_neither_returns_nor_landmarks_the_error_says_so(earlier: EarlierSteps) -> None:
    with pytest.raises(StageError, match="neither DVL returns nor landmarks"):
        earlier.run(adjusted=False, dvl=False)


def test_three_returns_are_too_few(earlier: EarlierSteps) -> None:
    earlier.returns = replace(earlier.returns, flagged=np.arange(240) > 2)
    with pytest.raises(StageError, match="fewer than four returns"):
        earlier.run()


def test_linear_interpolation_runs_on_the_same_input(earlier: EarlierSteps) -> None:
    surface, facts = _read(earlier.run(method="linear"))
    assert facts["method"] == "linear"
    assert np.sqrt(np.mean((_radius(surface) - RADIUS - OFF) ** 2)) < 0.008


def test_two_runs_give_the_same_bytes(earlier: EarlierSteps, tmp_path: Path) -> None:
    (tmp_path / "again").mkdir()
    first, second = earlier.run(), EarlierSteps(tmp_path / "again").run()
    assert (first / "surface.npz").read_bytes() == (second / "surface.npz").read_bytes()


def test_with_a_cad_model_the_record_says_that_the_comparison_is_partly_circular(
    earlier: EarlierSteps,
) -> None:
    _, facts = _read(earlier.run())
    assert facts["reference"] == "cad"
    assert "partly circular" in str(facts["comparison"])
    assert "poses that place the returns were adjusted" in str(facts["comparison"])


def test_without_a_cad_model_there_is_nothing_to_compare(earlier: EarlierSteps) -> None:
    earlier.without_cad_model()
    _, facts = _read(earlier.run())
    assert facts["reference"] == "plane"
    assert facts["comparison"] is None


@pytest.mark.parametrize("reference", ["cad", "plane", "none"])
def test_a_bump_that_the_cad_model_lacks_is_found_with_every_reference(
    earlier: EarlierSteps, reference: str
) -> None:
    beam_end = _ends(earlier)
    bump = 0.08 * np.exp(-0.5 * ((beam_end[:, 0] - 5) ** 2 + (beam_end[:, 2] - 3) ** 2) / 0.5**2)
    earlier.returns = replace(earlier.returns, range_m=earlier.returns.range_m - bump)
    surface, facts = _read(earlier.run(reference=reference, outlier_sigmas=3.0))
    x, z = surface.vertices[:, 0], surface.vertices[:, 2]
    top = np.hypot(x - 5, z - 3) < 0.15
    aside = (np.hypot(x - 5, z - 3) > 1.3) & (np.abs(x - 5) < 1.8) & (np.abs(z - 3) < 0.6)
    assert facts["reference"] == reference
    assert ("circular" in str(facts["comparison"])) == (reference == "cad")
    assert np.median(surface.deviation[top]) == pytest.approx(OFF + 0.08, abs=0.012)
    assert np.median(surface.deviation[aside]) == pytest.approx(OFF, abs=0.006)


def _ends(earlier: EarlierSteps) -> np.ndarray:
    hull_from_vehicle = (
        from_mount(TURN).inverse()[np.zeros(240, int)]
        @ earlier.global_from_vehicle[earlier.returns.node]
    )
    beam = hull_from_vehicle @ from_mount(DVL_MOUNT)
    return beam.apply(earlier.returns.beam * earlier.returns.range_m[:, None])


def test_a_hull_that_bends_around_is_no_plane(earlier: EarlierSteps) -> None:
    # landmarks all around the bilge: no plane faces them all
    angle = np.radians(np.linspace(-100, 100, 400))
    x = np.tile(np.linspace(3, 7, 20), 20)
    marks = np.column_stack([x, RADIUS * np.sin(angle), 3 - RADIUS * np.cos(angle)])
    earlier.solution = _solution(earlier.global_from_vehicle, from_mount(TURN).apply(marks))
    with pytest.raises(StageError, match="bends too far"):
        earlier.run(dvl=False, reference="plane")
