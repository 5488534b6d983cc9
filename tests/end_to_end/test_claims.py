# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a run says is true: every number with a sigma lies within three of the truth, and nothing is said of what was not
measured.

On the demo, and on small dives of two legs of 2 m: stereo, mono, without a CAD model, without a DVL, from images alone, and
without a camera.
"""

import json
import re
import shutil

import numpy as np
import pytest
from end_to_end import claims
from end_to_end.shell import SAMPLE, Shell
from end_to_end.true_hull import true_hull

pytestmark = pytest.mark.slow

SMALL = ("--legs", 2, "--leg-length-m", 2, "--marks", 1, "--structures", 2, "--barnacles", 0, "--image-width", 400,
         "--image-height", 320, "--seed", 11)  # fmt: skip
WITHOUT = {"no CAD model": ("hull",), "no DVL": ("dvl",), "images alone": ("hull", "dvl", "pressure")}
SIMULATED = {"mono": "mono", "no camera": "none"}
IN_SHIP_FRAME = ("demo", "no DVL", "mono", "no camera")
WITH_CAMERA = ("demo", "no CAD model", "no DVL", "images alone", "mono")
ALL = (*WITH_CAMERA, "no camera")


def leave_out(package, sensors):
    """Removes the sections and topics of sensors, or of the hull, from dive.toml."""
    path = package / "dive.toml"
    text = path.read_text()
    for name in sensors:
        text = re.sub(rf"(?m)^\[{name}\]\n(?:(?!\[).*\n?)*", "", text)
        text = re.sub(rf"(?m)^{name} = .*\n", "", text)
    path.write_text(text)


@pytest.fixture(scope="module")
def dives(tmp_path_factory, demo_run):
    """Run and package by the dive's name, each made when it is first asked for."""
    shell, made = Shell(tmp_path_factory.mktemp("claims")), {"demo": (demo_run, SAMPLE)}

    def simulated(cameras):
        package = shell.folder / f"package_{cameras}"
        if not package.exists():
            shell("simulate", package, *SMALL, "--cameras", cameras)
        return package

    def make(name):
        if name not in made:
            package = simulated(SIMULATED.get(name, "stereo"))
            if name in WITHOUT:
                package = shutil.copytree(package, shell.folder / name.replace(" ", "_"))
                leave_out(package, WITHOUT[name])
            shell("run", package, "--runs", package.name + "_out", "--jobs", 2)
            made[name] = (next((shell.folder / f"{package.name}_out").glob("*/deliver")).parent, package)
        return made[name]

    return make


@pytest.fixture
def dive(request, dives):
    return dives(request.param)


def on(*names):
    return pytest.mark.parametrize("dive", names, indirect=True)


@on(*WITH_CAMERA)
def test_the_numbers_of_every_object_lie_within_three_of_their_sigmas(dive):
    run, package = dive
    in_ship_frame = claims.document(run, "summary.json")["frame"] == "M"
    errors = claims.object_errors(run, true_hull(run / "deliver", package), in_ship_frame)
    assert errors
    for number, by_name in errors.items():
        assert by_name, f"object {number} is none"
        assert {name: error for name, error in by_name.items() if abs(error) > 3} == {}, number


@on("demo", "no DVL", "mono")
def test_offset_and_form_lie_within_three_of_their_sigmas(dive):
    run, package = dive
    errors = claims.deviation_errors(run, true_hull(run / "deliver", package))
    assert abs(errors["offset"]) < 3
    assert np.abs(errors["form percentiles"]).max() < 3
    for name in ("deviation", "form"):  # of thousands of vertices some are beyond: a normal error leaves 0.3 %
        assert np.mean(np.abs(errors[name]) > 3) < 0.02, name


@on(*IN_SHIP_FRAME)
def test_the_path_lies_within_three_of_its_sigmas(dive):
    assert np.abs(claims.path_errors(*dive)).max() < 3


@on(*IN_SHIP_FRAME)
def test_the_vehicles_depth_lies_within_three_of_its_sigmas(dive):
    errors = claims.depth_errors(*dive, true_hull(dive[0] / "deliver", dive[1]))
    assert len(errors) > 10
    assert np.abs(errors).max() < 3


@on("demo", "no DVL", "mono", "no camera")
def test_the_errors_of_the_sensors_lie_within_three_of_their_sigmas(dive):
    errors = claims.sensor_errors(*dive)
    assert {"Drift of the heading", "Bias of roll", "Bias of pitch", "Bias of the depth"} <= errors.keys()
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
        area = (coverage[sensor] or {}).get("area_m2")
        assert (f"m² by {name}" in text) == bool(area)
        if area:
            assert f"{area:.1f} m² by {name}" in text
            assert f"Hull seen by {name} {area:.1f} m²" in page
    areas = {float(v) for v in re.findall(r"(\d+\.\d) m²", page)}
    assert areas <= {round(float(s["area_m2"]), 1) for s in coverage.values() if isinstance(s, dict)} | {
        round(float(coverage["camera"]["area_twice_m2"]), 1) if coverage["camera"] else 0.0
    }
    if counts.get("objects"):
        assert f"{counts['objects']} object" in text
    if summary["deviation"]:
        said = summary["deviation"]
        side = "outside" if said["offset_m"] > 0 else "inside"
        words = f"{1000 * abs(said['offset_m']):.0f} mm {side} it (one sigma {1000 * said['offset_sigma_m']:.0f} mm"
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
def test_without_a_pressure_sensor_nothing_is_said_of_depth_and_the_water_surface(dive):
    run, _ = dive
    page, summary = claims.page_text(run), claims.document(run, "summary.json")
    for words in ("water surface", "waterline", "Depth below"):
        assert words not in page, words
        assert words not in json.dumps(summary), words
    assert all(found["depth"] is None for found in claims.document(run, "objects.json")["objects"])


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
