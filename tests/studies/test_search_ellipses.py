# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.studies.scenes.search_ellipses import (
    GATE_CHI2,
    TransferredPoints,
    search_ellipses,
)

IMAGE_PX = (320, 240)
COVARIANCE = np.array([[[25.0, 12.0], [12.0, 16.0]], [[4.0, 0.0], [0.0, 100.0]]])


@pytest.fixture(scope="module")
def gaussian() -> TransferredPoints:
    """Samples of the very covariances that are predicted."""
    rng = np.random.default_rng(0)
    mean = np.array([[100.0, 80.0], [200.0, 150.0]])
    samples = [rng.multivariate_normal(m, c, 20000) for m, c in zip(mean, COVARIANCE, strict=True)]
    return TransferredPoints(mean=mean, covariance=COVARIANCE, samples=np.stack(samples))


def rows(csv: str) -> list[list[str]]:
    return [line.split(",") for line in csv.splitlines()]


def test_gate_is_chi_square_99_percent_of_two_dof() -> None:
    assert pytest.approx(9.2103, abs=1e-4) == GATE_CHI2


def test_99_of_100_gaussian_samples_lie_within(gaussian: TransferredPoints) -> None:
    np.testing.assert_allclose(gaussian.share_within(), 0.99, atol=0.003)


def test_an_ellipse_that_is_too_small_holds_fewer(gaussian: TransferredPoints) -> None:
    """Of half the size: 1 - exp(-9.21 / 8) of them."""
    small = replace(gaussian, covariance=COVARIANCE / 4)
    np.testing.assert_allclose(small.share_within(), 1 - 0.01**0.25, atol=0.015)


def test_one_that_lies_elsewhere_holds_none(gaussian: TransferredPoints) -> None:
    assert replace(gaussian, mean=gaussian.mean + 100.0).share_within().max() == 0.0


def test_semi_axes_are_sigmas_times_the_root_of_the_gate(gaussian: TransferredPoints) -> None:
    np.testing.assert_allclose(
        gaussian.semi_axes_px()[1], [2 * GATE_CHI2**0.5, 10 * GATE_CHI2**0.5]
    )
    short, long = gaussian.semi_axes_px()[0]
    assert short * long == pytest.approx(GATE_CHI2 * 16.0)  # root of the determinant, 256


def test_every_point_of_an_outline_is_on_the_gate(gaussian: TransferredPoints) -> None:
    off = gaussian.outlines() - gaussian.mean[:, None]
    square = np.einsum("psi,pij,psj->ps", off, np.linalg.inv(COVARIANCE), off)
    np.testing.assert_allclose(square, GATE_CHI2)
    np.testing.assert_allclose(gaussian.outlines()[:, 0], gaussian.outlines()[:, -1])


def test_the_table_has_a_row_a_point_and_size(gaussian: TransferredPoints) -> None:
    table = rows(search_ellipses({"small": gaussian, "large": gaussian}, IMAGE_PX).csv)
    assert [row[:4] for row in table[1:]] == [
        [size, point, *at]
        for size in ("small", "large")
        for point, at in (("0", ["100.0", "80.0"]), ("1", ["200.0", "150.0"]))
    ]
    np.testing.assert_allclose(
        [float(row[6]) for row in table[1:3]], gaussian.share_within(), atol=1e-4
    )
    np.testing.assert_allclose(
        [[float(v) for v in row[4:6]] for row in table[1:3]], gaussian.semi_axes_px(), atol=0.01
    )


def test_the_caption_says_the_median_and_the_least_share_by_size(
    gaussian: TransferredPoints,
) -> None:
    off = replace(gaussian, mean=gaussian.mean + np.array([[0.0, 0.0], [500.0, 0.0]]))
    share = 100 * gaussian.share_within()
    caption = search_ellipses({"small": gaussian, "off": off}, IMAGE_PX).caption
    assert f"small {np.median(share):.1f} % (least {share.min():.1f} %)" in caption
    assert f"off {0.5 * share[0]:.1f} % (least 0.0 %)" in caption


@pytest.mark.usefixtures("pictures")
def test_there_is_a_panel_a_size(gaussian: TransferredPoints) -> None:
    pngs = [
        search_ellipses(dict.fromkeys(names, gaussian), IMAGE_PX).png for names in ("ab", "abc")
    ]
    width = [cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR).shape[1] for png in pngs]
    assert width[1] == pytest.approx(1.5 * width[0], rel=0.01)
