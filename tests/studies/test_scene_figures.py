# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the sources' figures show of scenes that need no dive, read from their tables."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from hullrecon.studies.scenes.scene_figures import PEAKS_M, POSE_SIGMAS, peaks

PUBLISHED, CAPPED = "as published", "outliers capped (the software)"


@pytest.fixture(scope="module")
def tables(scene_figures) -> dict[str, list[dict[str, str]]]:
    return {figure.name: list(csv.DictReader(io.StringIO(figure.csv))) for figure in scene_figures}


def columns(table: list[dict[str, str]], key: str, value: str, *names: str) -> np.ndarray:
    """The named columns (names, n) of the rows whose key has that value."""
    return np.array([[float(row[name]) for row in table if row[key] == value] for name in names])


def crossings_m(
    peak_m: np.ndarray, homography: np.ndarray, essential: np.ndarray
) -> list[tuple[float, float]]:
    """Between which heights the two change places."""
    ahead = homography < essential
    return [(peak_m[k], peak_m[k + 1]) for k in np.flatnonzero(ahead[:-1] != ahead[1:])]


def test_every_figure_is_there(tables) -> None:
    assert list(tables) == ["gic_by_relief", "search_ellipses", "sphere"]


def test_peaks_is_matlabs_surface() -> None:
    x, y = np.meshgrid(np.linspace(-3, 3, 301), np.linspace(-3, 3, 301))
    height = peaks(x, y)
    top, bottom = (
        np.unravel_index(found, height.shape) for found in (height.argmax(), height.argmin())
    )
    assert height.max() == pytest.approx(1.0, abs=1e-3)
    assert height.min() == pytest.approx(-6.551 / 8.106, abs=1e-3)
    np.testing.assert_allclose([x[top], y[top]], [-0.01, 1.58], atol=0.02)
    np.testing.assert_allclose([x[bottom], y[bottom]], [0.23, -1.63], atol=0.02)


def test_published_criteria_cross_once_between_2_and_10_cm(tables) -> None:
    names = ("peak_m", "homography_mean", "essential_mean", "share_homography")
    peak_m, homography, essential, share = columns(
        tables["gic_by_relief"], "scoring", PUBLISHED, *names
    )
    np.testing.assert_allclose(peak_m, PEAKS_M)
    ((low, high),) = crossings_m(peak_m, homography, essential)
    assert 0.02 <= low < high <= 0.1
    assert share[0] >= 0.9
    assert share[peak_m >= 0.1].max() <= 0.1
    assert np.ptp(essential) < 0.05 * essential.mean()
    assert (np.diff(homography[peak_m >= 0.01]) > 0).all()


def test_capped_outliers_favour_the_homography(tables) -> None:
    names = ("peak_m", "homography_mean", "essential_mean", "share_homography")
    peak_m, homography, essential, share = columns(
        tables["gic_by_relief"], "scoring", CAPPED, *names
    )
    ((low, high),) = crossings_m(peak_m, homography, essential)
    assert 0.1 <= low < high <= 0.4
    assert share[0] == 1.0
    assert share[-1] <= 0.2
    assert np.ptp(essential) < 0.02 * essential.mean()
    assert (np.diff(homography) > 0).all()


def test_transfer_is_gaussian_unless_the_pose_is_hardly_known(tables) -> None:
    small, medium, large = (
        columns(tables["search_ellipses"], "size", name, "share_within_99")[0]
        for name in POSE_SIGMAS
    )
    assert len(small) == len(large) == 16
    for share in (small, medium):
        assert share.min() > 0.98
        assert np.median(share) == pytest.approx(0.99, abs=0.003)
    assert 0.95 < large.min() < np.median(large) < np.median(small)


def test_ellipses_grow_with_the_sigmas_of_the_pose(tables) -> None:
    long = [
        columns(tables["search_ellipses"], "size", name, "semi_axis_long_px")[0]
        for name in POSE_SIGMAS
    ]
    # 1200 px x (0.5 deg and 1 cm and 5 cm of depth in 1.5 m), three sigma
    assert 30 < np.median(long[0]) < 70
    assert (long[1] > 3 * long[0]).all()
    assert (long[2] > 2.5 * long[1]).all()


def test_planes_put_path_on_sphere_for_any_radius(tables) -> None:
    names = ("characteristic_radius_m", "off_sphere_rms_m", "map_off_sphere_rms_m", "map_radius_m")
    radius, path, of_map, found = columns(tables["sphere"], "path", "with planes", *names)
    before = columns(
        tables["sphere"], "path", "dead reckoning", "off_sphere_rms_m", "map_off_sphere_rms_m"
    )
    assert (radius.min(), radius.max()) == (4.0, 20.0)
    assert path.max() < 0.2 * before[0, 0]
    assert of_map.max() < 0.5 * before[1, 0]
    assert np.ptp(path) < 0.001
    assert np.ptp(found) < 0.03
    assert np.abs(found - 10.0).max() < 0.15


def test_they_do_not_tell_where_on_the_sphere_the_vehicle_is(tables) -> None:
    errors = [
        columns(tables["sphere"], "path", name, "end_error_m")[0]
        for name in ("dead reckoning", "with planes")
    ]
    assert errors[1].min() > 0.5 * errors[0][0]


def test_the_sigma_of_planes_is_too_small_along_closed_turns(tables, scene_figures) -> None:
    """A limit that is said: in the caption, and in docs/methods.md 18."""
    error, sigma = columns(tables["sphere"], "path", "with planes", "end_error_m", "end_sigma_m")
    assert (error > 3 * sigma).all()
    before = columns(tables["sphere"], "path", "dead reckoning", "end_error_m", "end_sigma_m")
    assert (before[0] < 2 * before[1]).all()
    caption = next(figure.caption for figure in scene_figures if figure.name == "sphere")
    assert "along closed turns their sigma is too small" in caption
