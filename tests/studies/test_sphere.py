# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.studies.scenes.sphere import MappedSphere, SphereSurvey, fit_sphere, sphere

RADIUS_M, MIDDLE = 4.0, np.array([4.0, 0.0, 3.0])
ANGLE = np.linspace(0, 4 * np.pi, 400)
WAY = np.column_stack([-np.cos(ANGLE), -np.sin(ANGLE), np.linspace(-0.2, 0.2, 400)])
WAY /= np.linalg.norm(WAY, axis=1, keepdims=True)
TRUTH = MIDDLE + (RADIUS_M + 1.0) * WAY


def mapped(
    off_m: np.ndarray | float, map_radius_m: float = RADIUS_M, sigma_m: float = 0.1
) -> MappedSphere:
    """A path that lies outside the true one by off_m (n,), and a map of its own radius."""
    path = TRUTH + np.broadcast_to(off_m, 400)[:, None] * WAY
    return MappedSphere(path=path, sigma=np.full(400, sigma_m), points=MIDDLE + map_radius_m * WAY)


def survey(planes: dict[float, MappedSphere]) -> SphereSurvey:
    wavy = mapped(0.05 * np.sin(3 * ANGLE), 4.1, sigma_m=0.5)
    return SphereSurvey(radius_m=RADIUS_M, middle=MIDDLE, truth=TRUTH, reckoned=wavy, planes=planes)


@pytest.fixture(scope="module")
def whole() -> SphereSurvey:
    return survey(
        {
            2.0: mapped(0.002 * np.sin(3 * ANGLE)),
            5.0: mapped(0.004 * np.sin(3 * ANGLE)),
            9.0: mapped(0.0, 4.02),
        }
    )


def rows(csv: str) -> list[dict[str, str]]:
    head, *table = [line.split(",") for line in csv.splitlines()]
    return [dict(zip(head, row, strict=True)) for row in table]


def test_a_sphere_is_found_from_a_band_of_it() -> None:
    middle, radius = fit_sphere(TRUTH)
    np.testing.assert_allclose(middle, MIDDLE, atol=1e-9)
    assert radius == pytest.approx(RADIUS_M + 1.0)


def test_what_waves_about_a_sphere_is_as_far_off_it_as_it_waves() -> None:
    off = mapped(0.05 * np.sin(3 * ANGLE)).off_sphere_m()
    assert np.sqrt(np.mean(off**2)) == pytest.approx(0.05 / 2**0.5, rel=0.02)
    assert np.corrcoef(off, np.sin(3 * ANGLE))[0, 1] > 0.99


def test_path_of_other_radius_is_on_its_own_sphere() -> None:
    larger = mapped(0.2)
    np.testing.assert_allclose(larger.error_m(TRUTH), 0.2)
    np.testing.assert_allclose(larger.off_sphere_m(), 0.0, atol=1e-9)


def test_alignment_removes_motion_but_not_scale() -> None:
    moved = replace(mapped(0.0), path=exp([[1.0, -2.0, 0.5, 0.1, 0.2, -0.3]]).apply(TRUTH))
    assert moved.error_m(TRUTH).min() > 1.0
    assert moved.aligned_error_m(TRUTH) < 1e-9
    assert mapped(0.2).aligned_error_m(TRUTH) == pytest.approx(0.2, rel=0.02)


def test_the_planes_nearest_to_the_sphere_are_drawn(whole: SphereSurvey) -> None:
    assert whole.drawn == {"dead reckoning": whole.reckoned, "with planes": whole.planes[5.0]}


def test_table_has_row_for_reckoning_and_each_radius(
    whole: SphereSurvey,
) -> None:
    table = rows(sphere(whole).csv)
    assert [row["path"] for row in table] == ["dead reckoning"] + ["with planes"] * 3
    assert [row["characteristic_radius_m"] for row in table] == ["", "2", "5", "9"]
    assert [float(row["map_radius_m"]) for row in table] == [4.1, 4.0, 4.0, 4.02]
    np.testing.assert_allclose(
        [float(row["off_sphere_rms_m"]) for row in table],
        np.array([0.05, 0.002, 0.004, 0.0]) / 2**0.5,
        rtol=0.02,
        atol=1e-5,
    )
    assert [float(row["end_sigma_m"]) for row in table] == [0.5, 0.1, 0.1, 0.1]
    assert all(float(row["map_off_sphere_rms_m"]) < 1e-6 for row in table)


def test_the_error_of_the_end_is_that_of_the_last_pose() -> None:
    growing = mapped(np.linspace(0.0, 0.3, 400))
    row = rows(sphere(survey({4.0: growing})).csv)[1]
    assert float(row["end_error_m"]) == pytest.approx(0.3, abs=1e-5)
    assert float(row["aligned_rms_m"]) < 0.3


def test_the_caption_says_how_the_paths_lie_and_where_they_end(whole: SphereSurvey) -> None:
    caption = sphere(whole).caption
    assert "Around a sphere of 4 m" in caption
    assert (
        "to 35.0 mm rms by dead reckoning, to 0.0 to 2.8 mm with planes of characteristic radii "
        "of 2 to 9 m" in caption
    )
    assert "the radius of the map is 4.000 to 4.020 m, by dead reckoning 4.100 m" in caption
    assert (
        "(sigma 0.50 m) from the truth by dead reckoning, 0.00 m (sigma 0.10 m) with planes"
        in caption
    )


@pytest.mark.usefixtures("pictures")
def test_the_picture_has_four_panels_and_is_the_same_again(whole: SphereSurvey) -> None:
    figure = sphere(whole)
    picture = cv2.imdecode(np.frombuffer(figure.png, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (1230, 1560, 3)
    assert figure.png == sphere(whole).png
    halves = [
        picture[rows, columns]
        for rows in (slice(0, 615), slice(615, None))
        for columns in (slice(0, 780), slice(780, None))
    ]
    assert all((half < 200).any(axis=2).mean() > 0.005 for half in halves)
