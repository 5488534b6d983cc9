# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a run says is true: every number with a sigma lies within three of the truth, and nothing is
said of what was not measured.

On the demo, on the evaluation data's dive where that is there, and on small dives of two legs of 2
m: stereo, mono, without a CAD model, without a DVL, from images alone, and without a camera.
"""

import json
import re
import shutil

import numpy as np
import pytest
from datasets import FOLDER
from end_to_end import claims
from end_to_end.sentences import untrue
from end_to_end.shell import COARSE, SAMPLE, SMALL, Shell
from end_to_end.statements import Statement, statements
from end_to_end.true_dive import TrueDive

pytestmark = pytest.mark.slow

WITHOUT = {
    "no CAD model": ("hull",),
    "no DVL": ("dvl",),
    "images alone": ("hull", "dvl", "pressure"),
}
# runs that other files read as well
SHARED = {"demo": ("demo_run", SAMPLE), "dive-a": ("dive_a_run", FOLDER / "dive-a")}
IN_SHIP_FRAME = ("demo", "dive-a", "no DVL", "mono", "no camera")
IN_G = ("no CAD model", "images alone")
WITH_CAMERA = ("demo", "dive-a", "no CAD model", "no DVL", "images alone", "mono")
ALL = (*WITH_CAMERA, "no camera")
WITH_REGIONS = "mono"


def leave_out(package, sensors):
    """Removes the sections and topics of sensors, or of the hull, from dive.toml."""
    path = package / "dive.toml"
    text = path.read_text()
    for name in sensors:
        text = re.sub(rf"(?m)^\[{name}\]\n(?:(?!\[).*\n?)*", "", text)
        text = re.sub(rf"(?m)^{name} = .*\n", "", text)
    path.write_text(text)


@pytest.fixture(scope="module")
def dives(tmp_path_factory, request):
    """A run beside its truth by the dive's name, each made when it is first asked for."""
    shell, made = Shell(tmp_path_factory.mktemp("claims")), {}

    def simulated(cameras):
        package = shell.folder / f"package_{cameras}"
        if not package.exists():
            shell("simulate", package, *SMALL, "--cameras", cameras)
        return package

    def run(name):
        if name in SHARED:
            return request.getfixturevalue(SHARED[name][0]), SHARED[name][1]
        if name == "mono":
            folder = request.getfixturevalue("mono_dive")
            return folder / "out" / "simulated", folder / "package"
        package = simulated("none" if name == "no camera" else "stereo")
        if name in WITHOUT:
            package = shutil.copytree(package, shell.folder / name.replace(" ", "_"))
            leave_out(package, WITHOUT[name])
        shell("run", package, "--runs", package.name + "_out", *COARSE)
        return next((shell.folder / f"{package.name}_out").glob("*/deliver")).parent, package

    def make(name):
        if name not in made:
            made[name] = TrueDive(*run(name))
        return made[name]

    return make


@pytest.fixture
def true(request, dives):
    return dives(request.param)


@pytest.fixture
def dive(true):
    return true.run, true.package


def on(*names):
    return pytest.mark.parametrize("true", names, indirect=True)


@on(*WITH_CAMERA)
def test_object_numbers_lie_within_three_sigmas(true):
    errors = claims.object_errors(true.run, true.hull, true.in_ship_frame)
    assert errors
    for number, by_name in errors.items():
        assert by_name, f"object {number} is none"
        assert {name: error for name, error in by_name.items() if abs(error) > 3} == {}, number


@on("demo", "dive-a", "no DVL", "mono")
def test_offset_tilt_and_form_lie_within_three_of_their_sigmas(true):
    errors = {name: claim.error for name, claim in true.deviation.items()}
    assert abs(errors["offset"]) < 3
    assert np.abs(errors["tilt"]).max() < 3
    assert np.abs(errors["form percentiles"]).max() < 3
    # of thousands of vertices some are beyond: a normal error leaves 0.3 %
    for name in ("deviation", "form"):
        assert np.mean(np.abs(errors[name]) > 3) < 0.02, name


@on(*ALL)
def test_the_path_lies_within_three_of_its_sigmas(true):
    """Position and attitude. In g the first pose is where the path begins: it has neither error nor
    sigma to speak of.
    """
    first = 0 if true.in_ship_frame else 1
    assert np.abs(true.path.error[first:] / true.path.sigma[first:]).max() < 3


@on(*IN_SHIP_FRAME)
def test_the_hulls_pose_lies_within_three_of_its_sigmas(true):
    assert np.abs(claims.hull_pose_errors(true.run, true.package)).max() < 3


@on(*IN_SHIP_FRAME)
def test_the_vehicles_depth_lies_within_three_of_its_sigmas(true):
    errors = claims.depth_errors(true.run, true.package, true.hull)
    assert len(errors) > 10
    assert np.abs(errors).max() < 3


@on(*IN_SHIP_FRAME)
def test_error_along_weak_directions_is_within_three_sigmas(true):
    weak = claims.weak_direction_errors(true.run, true.package)
    assert {
        name: error / sigma for name, (error, sigma) in weak.items() if abs(error) > 3 * sigma
    } == {}


@on(*ALL)
@pytest.mark.parametrize("name", ["surface.ply", "landmarks.ply", "as_found.ply"])
def test_surface_errors_are_distributed_as_their_sigmas_say(true, name):
    if not (true.run / "deliver" / name).exists():
        assert name in true.summary["absent"]
        return
    errors = claims.surface_errors(true.run, true.hull, name)
    shares = [np.mean(errors < most) for most in (1, 2, 3)]
    # of normal errors 0.683, 0.954, 0.997
    assert (np.array(shares) > (0.65, 0.93, 0.98)).all(), shares


@on(*ALL)
def test_every_number_of_page_and_summary_is_true(true):
    said = statements(true.page) + [
        Statement(line, "summary", None) for line in true.summary["summary"]
    ]
    complaints = {complaint for found in said for complaint in untrue(true, found)}
    assert complaints == set()


def test_region_share_off_by_more_than_three_sigmas_is_untrue(dives):
    said = (
        "after part | 30 to 32.6 m | 4.5 to 8 m | 9.1 m² | {} ± 0.7 m² ({} ± 7 %) | not "
        "carried | not carried"
    )
    true = dives(WITH_REGIONS)
    area = true.seen_area("camera", on := true.within((30, 32.6), (4.5, 8)))
    share = 100 * area / true.views.steel.area[on].sum()
    for off, wrong in ((0.0, set()), (3.0, {"area", "share"})):
        words = said.format(f"{area + off:.1f}", f"{share + 10 * off:.0f}")
        found = {
            complaint.split(" of a region")[0]
            for complaint in untrue(true, Statement(words, "coverage", None))
        }
        assert found == wrong | {"sonar was carried", "DVL was carried"}


def test_a_number_that_no_pattern_covers_is_no_truth(dives):
    assert untrue(dives("demo"), Statement("The vessel was cleaned 3 times.", "summary", None))


@on("demo", "dive-a", "no DVL", "mono", "no camera")
def test_sensor_errors_lie_within_three_sigmas(dive):
    errors = claims.sensor_errors(*dive)
    named = {"Drift of the heading", "Bias of roll", "Bias of pitch", "Bias of the depth"}
    if (dive[0] / "ingest" / "dvl.npz").exists():
        named.add("Scale error of the DVL's velocities")
    assert errors.keys() == named
    assert {name: error for name, error in errors.items() if abs(error) > 3} == {}


@on("demo", "no DVL")
def test_the_form_is_known_much_better_than_the_offset(dive):
    said = claims.document(dive[0], "summary.json")["deviation"]
    assert said["form_sigma_m"] < 0.006 < 0.012 < said["offset_sigma_m"]


@on(*ALL)
def test_the_sentences_say_what_the_files_say(dive):
    run, _ = dive
    summary = claims.document(run, "summary.json")
    text, counts = " ".join(summary["summary"]), summary["counts"]
    assert f"{counts['poses']} poses" in text
    assert f"{counts['path_m']:.2f} m of path" in text
    images = sum(counts["images"].values())
    assert (f"{images} images" in text) == (images > 0)
    coverage = claims.document(run, "coverage.json")
    page = claims.page_text(run)
    for sensor, name in (("camera", "camera"), ("sonar", "sonar"), ("dvl", "DVL")):
        seen = coverage[sensor] or {}
        area, sigma = seen.get("area_m2"), seen.get("area_sigma_m2")
        assert (f"m² by {name}" in text) == bool(area)
        if area:
            # it is the hull's position's
            assert (sigma is not None) == (sensor == "sonar" and summary["frame"] == "M")
            words = f"{area:.1f} m²" if sigma is None else f"{area:.1f} ± {max(sigma, 0.1):.1f} m²"
            assert f"{words} by {name}" in text
            assert f"seen by {name} {words}" in page
    if counts.get("objects"):
        assert f"{counts['objects']} object" in text
    if summary["deviation"]:
        said = summary["deviation"]
        offset = f"{1000 * abs(said['offset_m']):.0f} mm"
        side = "from" if offset == "0 mm" else "outside" if said["offset_m"] > 0 else "inside"
        words = f"{offset} {side} it (one sigma {1000 * said['offset_sigma_m']:.0f} mm"
        assert words in text
        assert f"{words}" in page


@on("no CAD model", "images alone")
def test_without_a_cad_model_nothing_deviates(dive):
    run, _ = dive
    page, summary = claims.page_text(run), claims.document(run, "summary.json")
    for word in ("Deviation", "deviation_histogram", "outside it", "girth from", "frame M"):
        assert word not in page, word
    assert summary["deviation"] is None
    assert summary["frame"] == "g"
    assert not (run / "deliver" / "deviation.tif").exists()
    assert np.isnan(claims.read_ply(run / "deliver" / "as_found.ply")[0]["deviation"]).all()
    for found in claims.document(run, "objects.json")["objects"]:
        assert found["deviation"] is None
        assert found["frame"] is found["side"] is None


@on("no DVL", "images alone")
def test_without_a_dvl_nothing_was_seen_by_one(dive):
    run, _ = dive
    assert claims.document(run, "coverage.json")["dvl"] is None
    assert "by DVL" not in claims.page_text(run)
    assert "dvl_pings" not in claims.document(run, "summary.json")["counts"]


@on("images alone")
def test_without_pressure_sensor_no_depth_is_stated(dive):
    run, _ = dive
    page, summary = claims.page_text(run), claims.document(run, "summary.json")
    for words in ("water surface", "waterline", "Depth below"):
        assert words not in page, words
        assert words not in json.dumps(summary), words
    assert all(found["depth"] is None for found in claims.document(run, "objects.json")["objects"])


@on("no camera")
def test_without_camera_surface_and_sonar_mosaic_are_delivered(dive):
    run, _ = dive
    names = {path.name for path in (run / "deliver").iterdir()}
    assert {"trajectory.csv", "surface.ply", "ortho_sonar.tif", "mosaic_sonar.glb"} <= names
    assert not any("optical" in name for name in names)
    assert "no camera was carried" in json.dumps(claims.document(run, "summary.json"))


@on("no camera")
def test_without_a_camera_no_object_was_looked_for(dive):
    run, _ = dive
    summary = claims.document(run, "summary.json")
    assert not any("bject" in line for line in summary["summary"])
    assert "objects.json" in summary["absent"]


@on(*WITH_CAMERA)
def test_no_address_is_finer_than_its_sigma(dive):
    run, _ = dive
    for found in claims.document(run, "objects.json")["objects"]:
        numbers = re.findall(r"(\d+(?:\.(\d+))?) ± (\d+(?:\.\d+)?) m", found["address"])
        assert len(numbers) >= 2, found["address"]
        for _, digits, sigma in numbers:
            assert 10 ** -len(digits) <= 1.0001 * float(sigma) + 1e-9
        frames = re.match(r"frames (\d+) to (\d+)", found["address"])
        if found["frame"] is not None and found["sigma_along"] > 0.15:
            assert frames is not None
            assert int(frames[1]) - 0.5 <= found["frame"] <= int(frames[2]) + 0.5
