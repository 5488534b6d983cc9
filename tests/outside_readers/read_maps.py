# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GeoTIFFs and layers by rasterio, rio-cogeo, GDAL's own programs and pyogrio: without a warning,
in metres, in one place.
"""

import json
import re
import subprocess

import numpy as np
import pyogrio
import pyproj
import pytest
import rasterio
from rio_cogeo.cogeo import cog_validate

OF_SURFACE = ("deviation", "deviation_sigma", "form", "form_sigma", "support")
RASTERS = (
    *OF_SURFACE,
    *(
        f"{what}_{sensor}"
        for what in ("ortho", "variance", "views")
        for sensor in ("optical", "sonar")
    ),
)


def say(program, *arguments):
    """What a program of GDAL prints; it must print nothing on standard error, and no warning."""
    done = subprocess.run(
        [program, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "warning" not in done.stdout.lower()
    return done.stdout


@pytest.mark.parametrize("name", RASTERS)
def test_a_raster_is_a_valid_cloud_optimised_geotiff(deliver, name):
    is_valid, errors, warnings = cog_validate(deliver / f"{name}.tif", strict=True, quiet=True)
    assert (is_valid, errors, warnings) == (True, [], [])


@pytest.mark.parametrize("name", RASTERS)
def test_gdalinfo_reads_every_pixel_and_says_metres(deliver, name):
    text = say(
        "gdalinfo",
        "-checksum",
        "-stats",
        "--config",
        "GDAL_PAM_ENABLED",
        "NO",
        deliver / f"{name}.tif",
    )
    assert "ENGCRS" in text
    assert 'LENGTHUNIT["metre",1' in text
    assert (
        "Overviews:" in text
        or max(map(int, re.findall(r"\d+", text.split("Size is")[1])[:2])) <= 512
    )
    assert "Checksum=" in text


def test_rasterio_says_what_each_band_is(deliver):
    with rasterio.open(deliver / "ortho_optical.tif") as raster:
        assert raster.descriptions == ("red", "green", "blue", "alpha")
        assert raster.read(4).any()
    with rasterio.open(deliver / "deviation.tif") as raster:
        assert (raster.descriptions, raster.units) == (("deviation",), ("m",))
        values = raster.read(1, masked=True)
        assert 0.005 < float(values.std()) < 0.1
        # objects of 0.1 to 0.13 m on a hull that is centimetres off
        assert 0.08 < float(np.abs(values).max()) < 0.2


def test_ogrinfo_reads_every_feature(deliver):
    assert "Feature Count: 4" in say("ogrinfo", "-al", "-so", deliver / "objects.gpkg")
    assert "POLYGON ((" in say("ogrinfo", "-al", deliver / "objects.geojson")


def test_both_layers_and_the_rasters_share_one_system_and_one_place(deliver):
    with rasterio.open(deliver / "ortho_optical.tif") as raster:
        bounds, name = raster.bounds, pyproj.CRS(raster.crs.to_wkt()).name
    for file, layer in (
        ("objects.gpkg", "objects"),
        ("objects.gpkg", "object_centers"),
        ("objects.geojson", "objects"),
    ):
        found = pyogrio.read_info(deliver / file, layer=layer, force_total_bounds=True)
        assert pyproj.CRS(found["crs"]).name == name
        low_x, low_y, high_x, high_y = found["total_bounds"]
        assert bounds.left < low_x < high_x < bounds.right
        assert bounds.bottom < low_y < high_y < bounds.top


def test_pyogrio_reads_the_outlines_that_the_geojson_has(deliver):
    _, _, shapes, fields = pyogrio.raw.read(
        deliver / "objects.gpkg", layer="objects", columns=["id"]
    )
    features = json.loads((deliver / "objects.geojson").read_text())["features"]
    for blob, number, feature in zip(shapes, fields[0], features, strict=True):
        ring = np.frombuffer(blob, "<f8", offset=13).reshape(-1, 2)
        assert number == feature["properties"]["id"]
        np.testing.assert_allclose(ring, feature["geometry"]["coordinates"][0], atol=1e-5)
