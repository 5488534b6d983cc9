# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
import zipfile
from dataclasses import asdict, fields, replace
from pathlib import Path

import numpy as np
import pytest
from end_to_end.json_schema import violations
from scipy.spatial.transform import Rotation

from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import load_arrays
from hullrecon.detection.options import DetectOptions
from hullrecon.dive.config import schema
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.poses import Poses, from_mount, identity
from hullrecon.records.sensors import DvlPings, ImageIndex, JointSamples, PressureSamples
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.steps.chain import stage

STAGE = stage("detect")

OFF, HEIGHT = -0.010, 0.09  # the wall is 1 cm behind its CAD model and carries a disc 9 cm high
SCHEMA = (
    Path(__file__).resolve().parents[2]
    / "hullrecon"
    / "report"
    / "schemas"
    / "coverage.schema.json"
)
global_from_hull = from_mount([5, 7, 3, 180, 0, 0])
CHART = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))


def _wall() -> Mesh:
    corner = np.array([[0.0, 2, 0], [0, 2, 2], [4, 2, 2], [4, 2, 0]])
    return refine(Mesh(corner, np.array([[0, 1, 2], [0, 2, 3]], np.int32)), 0.6)[0]


def _landmarks(rng: np.random.Generator) -> np.ndarray:
    x, z = rng.uniform(0.4, 3.6, 7000), rng.uniform(0.5, 1.5, 7000)
    disc = np.hypot(x - 2, z - 1) < 0.12
    return np.column_stack([x, 2 + OFF + HEIGHT * disc + rng.normal(0, 0.002, 7000), z])


def _solution(landmarks: np.ndarray) -> Solution:
    x = np.arange(0.5, 3.6, 0.25)
    n, m = len(x), len(landmarks)
    toward = Rotation.from_matrix(np.array([[-1.0, 0, 0], [0, 0, -1], [0, -1, 0]]).T)
    hull_from_vehicle = Poses(
        np.tile(toward.as_quat(), (n, 1)), np.column_stack([x, np.full(n, 3.3), np.ones(n)])
    )
    global_from_vehicle = global_from_hull[np.zeros(n, int)] @ hull_from_vehicle
    grid = np.full((9, 5), OFF)
    return Solution(
        t_ns=1000 + np.arange(n),
        image=np.column_stack([np.arange(n), np.full(n, -1)]),
        global_from_vehicle=global_from_vehicle,
        tray=np.zeros(n),
        tray_sigma=np.zeros(n),
        pose_covariance=np.zeros((n, 6, 6)),
        landmarks=Landmarks(
            position=global_from_hull.apply(landmarks),
            covariance=np.tile(np.diag([0.1, 0.01, 0.01]) ** 2, (m, 1, 1)),
            label=np.ones(m, np.int64),
            deviation=landmarks[:, 1] - 2,
            views=np.full(m, 6),
            color=np.zeros((m, 3), np.uint8),
        ),
        mounts=Mounts(tray_from_dvl=identity(), tray_from_top=identity(), top_from_bottom=None),
        navigation_errors=np.zeros(6),
        hull_pose=HullPose(
            global_from_hull=global_from_hull, covariance=np.eye(6), survey_center=np.zeros(3)
        ),
        deviation_field=DeviationField(
            origin=np.zeros(2), step=np.full(2, 0.5), value=grid, sigma=np.abs(grid)
        ),
    )


def _dvl_surface() -> Surface:
    x, z = np.meshgrid(np.arange(0.4, 3.61, 0.1), np.arange(0.5, 1.51, 0.1), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        number[:-1, :-1].ravel(),
        number[1:, :-1].ravel(),
        number[1:, 1:].ravel(),
        number[:-1, 1:].ravel(),
    )
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int32)
    n = x.size
    vertices = np.column_stack([x.ravel(), np.full(n, 2 + OFF), z.ravel()])
    return Surface(
        vertices=vertices,
        faces=faces,
        deviation=np.full(n, OFF),
        sigma=np.full(n, 0.005),
        support=np.full(n, 3),
    )


class EarlierSteps:
    """Artifacts of the earlier steps, to be spoilt by a test before `run`.

    max_edge_m: of the hull as found, the option of that name.
    """

    def __init__(self, root: Path, max_edge_m: float = 0.03) -> None:
        self.root, self.max_edge_m = root, max_edge_m
        self.landmarks = _landmarks(np.random.default_rng(3))
        self.solution, self.surface = _solution(self.landmarks), _dvl_surface()
        self.hull, self.camera, self.sonar, self.dvl, self.pressure = True, True, False, True, True
        self.regions: tuple[schema.HullRegion, ...] | None = None
        self.returns = 300

    def without_cad_model(self) -> None:
        self.hull = False
        unknown = np.full(len(self.surface.sigma), np.nan)
        self.surface = replace(
            self.surface, vertices=global_from_hull.apply(self.surface.vertices), deviation=unknown
        )
        self.solution = replace(self.solution, hull_pose=None, deviation_field=None)

    def without_camera(self) -> None:
        self.camera = False
        s = self.solution
        none = Landmarks(**{f.name: getattr(s.landmarks, f.name)[:0] for f in fields(Landmarks)})
        mounts = replace(s.mounts, tray_from_top=None)
        self.solution = replace(s, image=np.full_like(s.image, -1), landmarks=none, mounts=mounts)

    def run(self, **options: object) -> Path:
        ingest, adjust, surface = (self._folder(name) for name in ("ingest", "adjust", "surface"))
        sections: dict[str, object] = {"tray": schema.Tray(), "hull": None, "sonar": None}
        if self.hull:
            mesh = _wall()
            np.savez(ingest / "hull.npz", vertices=mesh.vertices, faces=mesh.faces)
        if self.hull or self.regions:
            sections["hull"] = schema.Hull(mesh="hull.stl", frame_spacing=0.5, region=self.regions)
        if self.camera:
            (ingest / "cameras.json").write_text(
                json.dumps({"top": asdict(CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5))})
            )
            n = len(self.solution.t_ns)
            index = ImageIndex(
                t_ns=5000 + np.arange(n),
                file=np.full(n, ""),
                offset=np.zeros(n, np.int64),
                size=np.ones(n, np.int64),
                usable=np.ones(n, bool),
            )
            _write(ingest / "images_camera_top.npz", to_arrays(index))
        if self.sonar:
            self._carry_sonar(ingest)
            sections["sonar"] = schema.Sonar(mount=(0, 0, 0, 0, 0, 90), elevation_deg=20)
        none = np.zeros(0)
        if self.dvl:
            dvl = DvlPings(t_ns=none, velocity=none, velocity_sigma=none, ranges=none, beams=none)
            np.savez(ingest / "dvl.npz", **to_arrays(dvl))
        if self.pressure:
            np.savez(ingest / "pressure.npz", **to_arrays(PressureSamples(t_ns=none, depth=none)))
        np.savez(adjust / "solution.npz", **to_arrays(self.solution))
        np.savez(surface / "surface.npz", **to_arrays(self.surface))
        (surface / "surface.json").write_text(json.dumps({"returns": self.returns}))
        origin, axes = (
            (CHART.origin, CHART.axes)
            if self.hull
            else (
                global_from_hull.apply(CHART.origin)[0],
                CHART.axes @ global_from_hull.rotation.as_matrix()[0].T,
            )
        )
        np.savez(surface / "chart.npz", **PlaneChart(origin, axes).to_arrays())
        inputs = {"ingest": ingest, "adjust": adjust, "surface": surface}
        detect = DetectOptions(**{"max_edge_m": self.max_edge_m, **options})
        return run_stage(STAGE, {**sections, "detect": detect}, inputs, self.root / "detect")

    def _carry_sonar(self, ingest: Path) -> None:
        bearing = np.linspace(-0.4, 0.4, 9)
        beams = np.column_stack([np.zeros(9), np.sin(bearing), np.cos(bearing)])
        np.savez(
            ingest / "sonar.npz",
            t_ns=np.array([1002, 1008]),
            directions=beams,
            range_m=np.linspace(0.5, 3, 4),
        )
        np.save(ingest / "sonar_image.npy", np.zeros((2, 9, 4), np.uint8))
        np.savez(
            ingest / "sonar_tray.npz",
            **to_arrays(JointSamples(t_ns=np.array([0, 2000]), angle=np.zeros(2))),
        )

    def _folder(self, name: str) -> Path:
        path = self.root / name
        path.mkdir(exist_ok=True)
        return path


def _write(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """As np.savez, which cannot hold a member named `file`."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.asarray(values))


@pytest.fixture
def earlier(tmp_path: Path) -> EarlierSteps:
    """A hull as found of twice the step, which takes half of the time."""
    return EarlierSteps(tmp_path, max_edge_m=0.06)


@pytest.fixture(scope="module")
def detected(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The step's artifact of the dive as it is: a camera, a DVL and a CAD model."""
    return EarlierSteps(tmp_path_factory.mktemp("detected")).run()


@pytest.fixture(scope="module")
def without_cad_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    earlier = EarlierSteps(tmp_path_factory.mktemp("without_cad_model"))
    earlier.without_cad_model()
    return earlier.run()


@pytest.fixture(scope="module")
def with_sonar_and_regions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    earlier = EarlierSteps(tmp_path_factory.mktemp("regions"))
    earlier.sonar = True
    earlier.regions = (
        schema.HullRegion(name="whole", along=(0.0, 4.0), girth=(0.0, 2.0)),
        schema.HullRegion(name="middle", along=(1.5, 2.5), girth=(0.8, 1.2)),
        schema.HullRegion(name="above", girth=(1.8, 2.0)),
    )
    return earlier.run()


def _json(out: Path, name: str) -> dict:
    return json.loads((out / name).read_text())


def test_the_one_structure_is_reported_with_its_place_and_images(detected: Path) -> None:
    (item,) = _json(detected, "objects.json")["objects"]
    assert item["id"] == 1
    assert item["height"] == pytest.approx(HEIGHT, abs=0.004)
    assert item["deviation"] == pytest.approx(HEIGHT + OFF, abs=0.004)
    assert np.allclose(item["center"], [2.0, 2 + OFF + HEIGHT, 1.0], atol=0.02)
    assert item["images"][0] == "camera_top/5006.jpg"  # the image's own stamp; at x = 2
    assert "below waterline" in item["address"]


def test_the_hull_as_found_lies_where_it_was_seen(detected: Path) -> None:
    found = from_arrays(Surface, load_arrays(detected / "as_found.npz"))
    x, y, z = found.vertices.T
    rim = np.abs(np.hypot(x - 2, z - 1) - 0.12) < 0.02
    truth = 2 + OFF + HEIGHT * (np.hypot(x - 2, z - 1) < 0.12)
    seen = (found.support >= 2) & ~rim
    assert seen.sum() > 1000
    assert np.sqrt(np.mean((y - truth)[seen] ** 2)) < 0.002
    assert (found.support[z > 1.7] == 0).all()
    # every landmark shares a centimetre of doubt about the dive's place
    assert found.sigma[seen].min() > 0.009


def test_coverage_tells_each_sensors_area(with_sonar_and_regions: Path) -> None:
    facts = _json(with_sonar_and_regions, "coverage.json")
    assert facts["frame"] == "M"
    assert facts["camera"]["area_m2"] == pytest.approx((3.0 + 1.3 - 0.3) * 1.04, rel=0.1)
    assert facts["camera"]["gsd_m"]["p50"] == pytest.approx(1.3 / 640, rel=0.1)
    assert facts["dvl"]["area_m2"] == pytest.approx(3.2 * 1.0, rel=0.25)
    assert facts["sonar"]["pings"] == 2
    assert facts["sonar"]["area_m2"] > 0
    assert facts["holes"] == []


@pytest.mark.parametrize("dvl", [False, True])
def test_without_returns_of_a_dvl_nothing_was_seen_by_one(earlier: EarlierSteps, dvl: bool) -> None:
    earlier.dvl, earlier.returns = dvl, 0
    facts = _json(earlier.run(), "coverage.json")
    assert facts["dvl"] is None
    assert facts["camera"]["area_m2"] > 1


def test_without_a_pressure_sensor_no_depth_is_told(earlier: EarlierSteps) -> None:
    earlier.pressure = False
    (item,) = _json(earlier.run(), "objects.json")["objects"]
    assert item["depth"] is None
    assert "waterline" not in item["address"]


def test_the_deviation_is_parted_into_offset_and_form(detected: Path) -> None:
    split = from_arrays(DeviationSplit, load_arrays(detected / "deviation.npz"))
    assert float(split.offset) == pytest.approx(OFF, abs=0.003)
    assert np.nanmax(split.form) == pytest.approx(HEIGHT, abs=0.006)
    assert float(split.offset_sigma) > 10 * np.nanmedian(split.form_sigma)


def test_without_a_cad_model_there_is_nothing_to_deviate_from(without_cad_model: Path) -> None:
    out = without_cad_model
    assert not (out / "deviation.npz").exists()
    assert np.isnan(from_arrays(Surface, load_arrays(out / "as_found.npz")).deviation).all()
    assert _json(out, "objects.json")["objects"][0]["deviation_sigma"] is None


def test_without_a_sonar_coverage_says_null(detected: Path) -> None:
    assert _json(detected, "coverage.json")["sonar"] is None


def test_without_cad_model_structures_come_from_own_surface(without_cad_model: Path) -> None:
    out = without_cad_model
    (item,) = _json(out, "objects.json")["objects"]
    assert item["height"] == pytest.approx(HEIGHT, abs=0.004)
    assert item["deviation"] is None
    assert np.allclose(
        item["center"], global_from_hull.apply([[2.0, 2 + OFF + HEIGHT, 1.0]])[0], atol=0.02
    )
    assert _json(out, "coverage.json")["frame"] == "g"
    assert "own surface" in _json(out, "detect.json")["reference"]


def test_without_a_field_running_medians_stand_in(earlier: EarlierSteps) -> None:
    earlier.solution = replace(earlier.solution, deviation_field=None)
    (item,) = _json(earlier.run(), "objects.json")["objects"]
    assert item["height"] == pytest.approx(HEIGHT, abs=0.004)


def test_without_camera_cad_model_is_moved_to_dvl_surface(earlier: EarlierSteps) -> None:
    earlier.without_camera()
    out = earlier.run()
    found = from_arrays(Surface, load_arrays(out / "as_found.npz"))
    covered = found.support > 0
    assert np.allclose(found.vertices[covered, 1], 2 + OFF)
    assert _json(out, "objects.json") == {"objects": []}
    assert "camera" in _json(out, "detect.json")["objects"]
    assert _json(out, "coverage.json")["camera"] is None


def test_without_camera_and_cad_model_as_found_is_absent(
    earlier: EarlierSteps,
) -> None:
    earlier.without_cad_model()
    earlier.without_camera()
    out = earlier.run()
    assert not (out / "as_found.npz").exists()
    assert "no CAD model" in _json(out, "detect.json")["as_found"]


def test_what_was_not_reported_is_named_with_its_reason(earlier: EarlierSteps) -> None:
    out = earlier.run(min_height_m=0.2)
    assert _json(out, "objects.json")["objects"] == []
    rejected = _json(out, "detect.json")["not_reported"]
    assert any("0.09" in row["reason"] for row in rejected)
    for row in rejected:
        assert row["height_sigma"] > 0
        assert all(sigma > 0 for sigma in row["position_sigma"])
        assert float(row["address"].split()[0]) == pytest.approx(row["along"], abs=0.05)


def test_a_depth_is_known_as_well_as_the_water_surface_is(earlier: EarlierSteps) -> None:
    (earlier.root / "adjust").mkdir()
    known = {"navigation_sigma": {"depth_bias_m": 0.4}, "sigmas": {"depth_m": 0.3}}
    (earlier.root / "adjust" / "adjust.json").write_text(json.dumps(known))
    (found,) = _json(earlier.run(), "objects.json")["objects"]
    assert 0.5 <= found["depth_sigma"] < 0.51
    assert "below waterline" in found["address"]


def test_two_runs_give_the_same_bytes(detected: Path, earlier: EarlierSteps) -> None:
    first, second = detected, earlier.run(max_edge_m=0.03)
    for name in ("as_found.npz", "objects.json", "coverage.json", "detect.json"):
        assert (first / name).read_bytes() == (second / name).read_bytes()


def test_coverage_is_counted_against_the_regions_of_dive_toml(with_sonar_and_regions: Path) -> None:
    facts = _json(with_sonar_and_regions, "coverage.json")
    found = {region["name"]: region for region in facts["regions"]}
    assert list(found) == ["whole", "middle", "above"]
    assert found["middle"]["along"] == [1.5, 2.5]
    assert found["above"]["along"] is None
    # rims: half a cell or none
    assert [r["area_m2"] for r in found.values()] == pytest.approx([8.0, 0.4, 0.8], rel=0.06)
    for sensor in ("camera", "dvl", "sonar"):
        seen = found["whole"][sensor]
        # whose patches are wider
        assert seen["area_m2"] == pytest.approx(facts[sensor]["area_m2"], rel=0.15)
        assert seen["share"] == pytest.approx(seen["area_m2"] / 8, abs=1e-4)
    assert (found["middle"]["camera"]["share"], found["above"]["camera"]["share"]) == (1.0, 0.0)


def test_region_share_sigma_follows_from_its_limits_on_survey(
    earlier: EarlierSteps,
) -> None:
    """The DVL's surface is a strip a metre high, and 8 cm more above and below: a decimetre along
    is a tenth of that.
    """
    earlier.sonar = True
    earlier.regions = (
        schema.HullRegion(name="all", along=(-1.0, 5.0)),
        schema.HullRegion(name="half", along=(0.0, 2.0)),
    )
    hull_pose = earlier.solution.hull_pose
    assert hull_pose is not None
    sigma = np.append(np.full(3, 0.1), np.full(3, 1e-4))
    earlier.solution = replace(
        earlier.solution, hull_pose=replace(hull_pose, covariance=np.diag(sigma**2))
    )
    facts = _json(earlier.run(), "coverage.json")
    found = {region["name"]: region for region in facts["regions"]}
    assert found["half"]["dvl"]["area_sigma_m2"] == pytest.approx(0.116, rel=0.15)
    # cells of 5 cm, of which the rim holds one more or less
    assert found["all"]["dvl"]["area_sigma_m2"] < 0.02
    for sensor in ("camera", "dvl", "sonar"):
        half = found["half"][sensor]
        assert half["area_sigma_m2"] > 0.05
        assert half["share_sigma"] == pytest.approx(
            half["area_sigma_m2"] / found["half"]["area_m2"], abs=1e-4
        )
    assert (
        violations(facts["regions"], json.loads(SCHEMA.read_text())["properties"]["regions"]) == []
    )


def test_sensors_that_were_not_carried_saw_no_share_of_a_region(earlier: EarlierSteps) -> None:
    earlier.without_camera()
    earlier.regions = (schema.HullRegion(name="all", along=(0.0, 4.0)),)
    (region,) = _json(earlier.run(), "coverage.json")["regions"]
    assert (region["camera"], region["sonar"]) == (None, None)
    assert region["dvl"]["share"] > 0.3


def test_regions_are_not_counted_with_refused_cad_model(earlier: EarlierSteps) -> None:
    earlier.without_cad_model()
    earlier.hull, earlier.regions = False, (schema.HullRegion(name="all", along=(0.0, 4.0)),)
    out = earlier.run()
    assert "regions" not in _json(out, "coverage.json")
    assert any("hull.region" in line for line in _json(out, "manifest.json")["warnings"])


def test_without_regions_coverage_says_nothing_of_them(detected: Path) -> None:
    assert "regions" not in _json(detected, "coverage.json")
