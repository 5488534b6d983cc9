# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A small dive over a flat plate, adjusted and dead reckoned."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.typing import NDArray

from hullrecon.dive.config.schema import Dive, Hull
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_rpy, identity
from hullrecon.records.deliverables import Coverage, CoverageHole, ReportedObject, SensorCoverage
from hullrecon.records.sensors import DvlPings, ImageIndex
from hullrecon.records.solution import HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.trajectory import Trajectory
from hullrecon.report.content import page_context
from hullrecon.report.figures import map_pictures, plan_view, plots
from hullrecon.report.survey import (
    AdjustedDive,
    AdjustSummary,
    DiveFacts,
    Findings,
    NavigationFacts,
    Provenance,
    StepRun,
    Surfaces,
    Survey,
)
from hullrecon.rig import Rig

NODES = 5
START = 1_777_887_000_468_241_234
# T_g_M: moved, and turned by 180 degrees about x
TURNED = from_rpy([10.0, 20.0, 3.0], [np.pi, 0.0, 0.0])
CAMERA = CameraModel(width=400, height=320, fx=500.0, fy=500.0, cx=199.5, cy=159.5)


@dataclass(frozen=True)
class FlatChart:
    """along is x, girth is y, outward is -z: with along to the right and girth up it is seen from
    inside.
    """

    ship_axes = np.eye(3)

    def to_chart(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(points, float) * [1, 1, -1]

    def from_chart(
        self, along_girth: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        at = np.asarray(along_girth, float)
        return np.column_stack([at, np.zeros(len(at))]), np.tile([0.0, 0.0, -1.0], (len(at), 1))

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        return {"kind": np.array("cylinder")}


PICTURES = {
    page_context: ("ship_svg",),
    plan_view: ("ground_png",),
    map_pictures: ("field_layer", "form_png"),
    plots: ("convergence", "labels", "residuals", "sigmas", "deviation_histogram"),
}


@pytest.fixture(scope="session", autouse=True)
def pictures_drawn() -> Iterator[dict[bytes, object]]:
    """Draw each picture of the page once a session: they are most of the time, and pure functions.
    The map of the form, the dearest, is that of the first survey on all pages: tests of what it
    shows call it themselves.

    Yields what was drawn, by function and arguments; a test of equal bytes clears it between runs.
    """
    drawn: dict[bytes, object] = {}

    def once(function: Callable[..., object]) -> Callable[..., object]:
        def draw(*args: object, **kwargs: object) -> object:
            of = () if function.__name__ == "form_png" else (args, kwargs)
            key = pickle.dumps((function.__name__, *of))
            if key not in drawn:
                drawn[key] = function(*args, **kwargs)
            return drawn[key]

        return draw

    with pytest.MonkeyPatch.context() as patch:
        for module, names in PICTURES.items():
            for name in names:
                patch.setattr(module, name, once(getattr(module, name)))
        yield drawn


@pytest.fixture
def trajectory() -> Trajectory:
    """Half a metre a second along x of g, 2 m deep; sigmas grow."""
    covariance = np.stack(
        [np.diag([0.1, 0.1, 0.02, 0.001, 0.001, 0.01]) ** 2 * (1 + k) for k in range(NODES)]
    )
    return Trajectory(
        t_ns=START + np.arange(NODES) * 10**9,
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (NODES, 1)),
        translation=np.array([[10 + 0.5 * k, 21.0, 2.0] for k in range(NODES)]),
        covariance=covariance,
        tray=np.full(NODES, 0.1),
        image=np.column_stack([np.arange(NODES), np.full(NODES, -1)]),
    )


@pytest.fixture
def solution(trajectory: Trajectory) -> Solution:
    return Solution(
        t_ns=trajectory.t_ns,
        image=trajectory.image,
        global_from_vehicle=trajectory.poses(),
        tray=trajectory.tray,
        tray_sigma=np.full(NODES, 0.001),
        pose_covariance=np.tile(
            np.diag([0.5, 0.02, 0.01, 0.001, 0.001, 0.002]) ** 2, (NODES, 1, 1)
        ),
        landmarks=Landmarks(
            position=np.array([[10.0, 21.0, 3.0], [11.0, 21.5, 2.9], [12.0, 20.5, 3.0]]),
            covariance=np.tile(np.diag([0.001, 0.002, 0.002]) ** 2, (3, 1, 1)),
            label=np.array([1, 0, 1]),
            deviation=np.array([0.0, 0.1, -0.004]),
            views=np.array([4, 6, 2]),
            color=np.array([[10, 20, 30], [40, 50, 60], [70, 80, 90]], np.uint8),
        ),
        mounts=Mounts(tray_from_dvl=identity(), tray_from_top=identity(), top_from_bottom=None),
        navigation_errors=np.zeros(6),
        hull_pose=HullPose(
            global_from_hull=TURNED,
            covariance=np.diag([0.25, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6]),
            survey_center=np.array([1.0, -1.0, 0.0]),
        ),
        deviation_field=None,
    )


@pytest.fixture
def plate() -> Surface:
    """The plate z = 0 of M from (-1, -2) to (3, 0), 1 m squares, half seen, raised by 6 mm."""
    x, y = np.meshgrid(np.arange(-1.0, 4.0), np.arange(-2.0, 1.0))
    index = np.arange(15).reshape(3, 5)
    a, b, c, d = (
        index[:-1, :-1].ravel(),
        index[:-1, 1:].ravel(),
        index[1:, :-1].ravel(),
        index[1:, 1:].ravel(),
    )
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)]).astype(np.int32)
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(15)])
    return Surface(
        vertices=vertices,
        faces=faces,
        deviation=np.full(15, 0.006),
        sigma=np.full(15, 0.002),
        support=np.where(x.ravel() < 2, 5, 0),
    )


@pytest.fixture
def split(plate: Surface) -> DeviationSplit:
    """The plate stands 6 mm off its CAD model, known to 20 mm; its form to 2 mm."""
    seen = plate.support > 0
    return DeviationSplit(
        offset=np.asarray(0.006),
        offset_sigma=np.asarray(0.02),
        tilt=np.array([0.001, -0.002]),
        tilt_sigma=np.array([0.004, 0.005]),
        form=np.where(seen, 0.003 * np.sign(plate.vertices[:, 1] + 1), np.nan),
        form_sigma=np.where(seen, 0.002, np.nan),
    )


@pytest.fixture
def found() -> ReportedObject:
    ring = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    outline = np.column_stack([1 + 0.1 * np.cos(ring), -1.2 + 0.08 * np.sin(ring), 0 * ring])
    return ReportedObject(
        id=1,
        center=(1.0, -1.2, -0.1),
        normal=(0.0, 0.0, -1.0),
        height=0.1,
        height_sigma=0.004,
        deviation=0.104,
        deviation_sigma=0.021,
        extent_sigma=(0.01, 0.01),
        area_sigma=0.002,
        volume_sigma=0.0002,
        open_edge=0.0,
        position_covariance=((0.09, 0.0, 0.0), (0.0, 0.0004, 0.0), (0.0, 0.0, 0.0025)),
        position_sigma=(0.3, 0.02, 0.05),
        sigma_along=0.3,
        sigma_girth=0.02,
        sigma_normal=0.05,
        along=1.0,
        girth=-1.2,
        side="starboard",
        frame=1.67,
        depth=2.9,
        depth_sigma=0.05,
        extent=(0.2, 0.16),
        area=0.025,
        volume=0.0019,
        views=6,
        p_value=1e-9,
        address="frame 3 + 0.2 m, port",
        images=(f"camera_top/{START + 2 * 10**9}.jpg",),
        outline=tuple((x, y, z) for x, y, z in outline.tolist()),
    )


@dataclass(frozen=True)
class Pictures:
    """The same picture at every row."""

    index: ImageIndex

    def read(self, row: int) -> NDArray[np.uint8]:
        v, u = np.mgrid[0:320, 0:400]
        return np.stack([u % 256, v % 256, (u + v) % 256], axis=2).astype(np.uint8)


@pytest.fixture
def pictures() -> Pictures:
    return Pictures(
        ImageIndex(
            t_ns=START + np.arange(NODES) * 10**9,
            file=np.full(NODES, ""),
            offset=np.zeros(NODES, np.int64),
            size=np.ones(NODES, np.int64),
            usable=np.ones(NODES, bool),
        )
    )


@pytest.fixture
def rig() -> Rig:
    """The camera looks along z of the vehicle, which is outward of the plate seen from above; the
    tray does not turn it.
    """
    return Rig(
        tray_origin=np.zeros(3),
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(),
        tray_from_top=identity(),
        camera_models={Camera.TOP: CAMERA},
    )


@pytest.fixture
def dvl() -> DvlPings:
    beams = np.array(
        [[0.5, 0, 0.75**0.5], [-0.5, 0, 0.75**0.5], [0, 0.5, 0.75**0.5], [0, -0.5, 0.75**0.5]]
    )
    ranges = np.full((3, 4), 1.2 / 0.75**0.5)
    ranges[1, 2:] = np.nan
    ranges[2] = np.nan
    return DvlPings(
        t_ns=START + np.arange(3) * 10**9,
        velocity=np.zeros((3, 3)),
        velocity_sigma=np.full(3, 0.003),
        ranges=ranges,
        beams=beams,
    )


WEAK = {
    "direction": [1.0, 0, 0],
    "sigma": 0.5,
    "sentence": "The position along the hull is uncertain by 0.50 m.",
}


@pytest.fixture
def survey(
    trajectory: Trajectory, solution: Solution, plate: Surface, split: DeviationSplit,
    found: ReportedObject, pictures: Pictures, rig: Rig,
    dvl: DvlPings,
) -> Survey:  # fmt: skip
    """With everything but mosaics."""
    coverage = Coverage(
        camera=SensorCoverage(area_m2=4.0, gsd_m={"p05": 0.0018, "p50": 0.002, "p95": 0.0025}),
        holes=(CoverageHole(address="frame 4", area_m2=0.2),),
    )
    return Survey(
        facts=DiveFacts(
            dive=Dive(
                name="plate-1", vessel="MV Plate", date=datetime(2026, 5, 4, 9, 30, tzinfo=UTC)
            ),
            hull=Hull(mesh="hull.stl", frame_spacing=0.6),
            dvl=dvl,
            rig=rig,
            images={Camera.TOP: pictures},
            navigation=NavigationFacts(
                start_ns=1_777_887_000_000_000_000, outages_s=((31.0, 34.2),)
            ),
        ),
        track=solution.track(),
        trajectory=trajectory,
        adjusted=AdjustedDive(
            solution=solution,
            summary=AdjustSummary(method="maxmix", observations=98, observations_left_out=2),
            weak_directions=(WEAK,),
            iterations={
                "cost": np.array([100.0, 10.0, 9.0]),
                "on_surface": np.array([1, 2, 2]),
                "label_changes": np.array([0, 1, 0]),
            },
        ),
        surfaces=Surfaces(
            chart=FlatChart(),
            outside=OutsideMap(x_sign=-1, y_sign=1, frame="M"),
            surveyed=plate,
            as_found=plate,
            deviation=split,
            comparison="The comparison is partly circular.",
        ),
        findings=Findings(objects=(found,), coverage=coverage),
        provenance=Provenance(
            steps=(
                StepRun(
                    name="adjust",
                    version=2,
                    settings={"adjust": {"rounds": 3, "method": "maxmix"}},
                    inputs={"navigate": "ab12"},
                    warnings=("two rays missed",),
                    run={"started": 0.0, "seconds": 7.5},
                ),
            )
        ),
    )


@pytest.fixture
def bare(trajectory: Trajectory) -> Survey:
    """Dead reckoning alone: no camera, no CAD model, no sonar."""
    reasons = {"objects.json": "no camera was carried", "alignment.json": "no CAD model was given"}
    rig = Rig(tray_origin=np.zeros(3), pressure_origin=np.zeros(3), tray_from_dvl=identity())
    return Survey(
        facts=DiveFacts(dive=Dive(name="bare"), rig=rig),
        track=trajectory.track(),
        trajectory=trajectory,
        provenance=Provenance(missing=reasons),
    )


@pytest.fixture
def ply_reader() -> Callable[[bytes], tuple[np.ndarray, np.ndarray | None]]:
    """An independent little reader: vertices as a structured array, faces (m, 3)."""
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}

    def read(data: bytes) -> tuple[np.ndarray, np.ndarray | None]:
        head, body = data.split(b"end_header\n", 1)
        lines = [line.split() for line in head.decode().splitlines()]
        count = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
        dtype = [
            (line[2], kinds[line[1]])
            for line in lines
            if line[0] == "property" and line[1] != "list"
        ]
        vertices = np.frombuffer(body, dtype, count["vertex"])
        rest = body[vertices.nbytes :]
        faces = np.frombuffer(rest, [("n", "u1"), ("v", "<i4", 3)]) if "face" in count else None
        return vertices, None if faces is None else faces["v"]

    return read
