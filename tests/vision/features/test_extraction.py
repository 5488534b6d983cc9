# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from hullrecon.vision.features.extraction import extract, no_features, root_sift
from hullrecon.vision.features.scale_space import describe_keypoints
from hullrecon.vision.options import FeatureOptions


@pytest.fixture
def blobs():
    """Gaussian spots of 3 px sigma at known places on grey, as an RGB image."""
    places = np.array([[60.25, 50.5], [130.0, 70.75], [90.5, 120.0], [40.0, 130.25]])
    v, u = np.mgrid[0:180, 0:200]
    image = np.full((180, 200), 90.0)
    for x, y in places:
        image += 120 * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * 3.0**2))
    rgb = np.repeat(image[..., None], 3, axis=2)
    rgb[..., 2] *= 0.5
    return places, rgb.clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("reduction", [1.0, 2.0])
def test_spot_is_found_at_its_place_in_raw_pixels(blobs, reduction):
    places, image = blobs
    found = extract(image, FeatureOptions(reduction=reduction, level_window=0.0))
    for place in places:
        assert np.linalg.norm(found.keypoints[:, :2] - place, axis=1).min() < 0.15


def test_features_carry_colour_of_their_pixel(blobs):
    places, image = blobs
    found = extract(image, FeatureOptions(level_window=0.0))
    k = int(np.linalg.norm(found.keypoints[:, :2] - places[1], axis=1).argmin())
    u, v = np.rint(found.keypoints[k, :2]).astype(int)
    np.testing.assert_array_equal(found.color[k], image[v, u])


def test_features_come_in_fixed_order_and_repeat_bit_for_bit(blobs):
    first, second = (extract(blobs[1], FeatureOptions()) for _ in range(2))
    assert (np.diff(first.keypoints[:, 1]) >= 0).all()
    np.testing.assert_array_equal(first.keypoints, second.keypoints)
    np.testing.assert_array_equal(first.descriptors, second.descriptors)


def test_levelling_brings_out_faint_texture():
    rng = np.random.default_rng(2)
    faint = (40 + np.kron(rng.uniform(0, 5, (32, 40)), np.ones((8, 8)))).astype(np.uint8)
    plain = extract(faint, FeatureOptions(level_window=0.0, reduction=1.0))
    assert len(extract(faint, FeatureOptions(reduction=1.0))) > 3 * len(plain) + 20


@pytest.fixture(scope="module")
def texture():
    """Grey texture of all sizes, (280, 400), as floats about 100."""
    rng = np.random.default_rng(4)
    total = np.zeros((280, 400))
    for cell, gain in ((40, 12.0), (20, 10.0), (10, 8.0), (5, 7.0)):
        coarse = rng.standard_normal((280 // cell, 400 // cell))
        total += gain * np.kron(coarse, np.ones((cell, cell)))
    return 100 + gaussian_filter(total, 1.2)


def moved(first, second):
    """Return by how much (n, 2) the features of a first image have moved in a second, where both
    have them, and where.
    """
    gap, nearest = cKDTree(first[:, :3]).query(second[:, :3])
    return (second - first[nearest])[gap < 0.7, :2], second[gap < 0.7]


def features_of(image, window_px=10.0):
    """Return keypoints of an image of any width, levelled over the same window."""
    return extract(image, FeatureOptions(level_window=window_px / image.shape[1])).keypoints


def test_feature_stays_where_it_is_when_image_is_cut_elsewhere(texture):
    image = texture.clip(0, 255).astype(np.uint8)
    shift, at = moved(features_of(image) - [24, 12, 0, 0], features_of(image[12:, 24:]))
    inside = (at[:, :2] > 50).all(axis=1)
    assert inside.sum() > 300
    assert np.sqrt((shift[inside] ** 2).mean()) < 0.02  # 0.1 px where tiles are equalised apart


def test_features_beside_border_are_not_drawn_to_it(texture):
    image = texture.clip(0, 255).astype(np.uint8)
    shifts = []
    for side in range(4):
        whole = np.ascontiguousarray(np.rot90(image, side))
        shift, at = moved(features_of(whole, 0.0) - [80, 0, 0, 0], features_of(whole[:, 80:], 0.0))
        shifts.append(shift[at[:, 0] < 25, 0])
        assert (at[:, 0] >= 2 * at[:, 2]).all()
    near = np.concatenate(shifts)
    assert len(near) > 80
    assert abs(near.mean()) < 0.005  # 0.009 px, and 0.07 px rms, where none is left out


def test_features_are_clear_of_where_levelling_leans_on_border(texture):
    image = texture.clip(0, 255).astype(np.uint8)

    def nearest(window_px):
        u, v = features_of(image, window_px)[:, :2].T
        return min(u.min(), v.min(), 399 - u.max(), 279 - v.max())

    assert nearest(0.0) < 12 < 15 <= nearest(10.0) < 18
    assert nearest(16.0) >= 24


def test_light_falling_off_does_not_draw_features(texture):
    lit = texture * np.exp((np.arange(400) - 200) / 600)
    shift, _ = moved(
        *(
            extract(np.rint(0.8 * image).astype(np.uint8), FeatureOptions()).keypoints
            for image in (texture, lit)
        )
    )
    assert abs(np.median(shift[:, 0])) < 0.008  # 0.015 px where the light is not followed


def test_at_most_number_of_features_asked_for_is_kept():
    noise = np.random.default_rng(1).integers(0, 255, (256, 256)).astype(np.uint8)
    assert len(extract(noise, FeatureOptions(max_features=100))) <= 102  # OpenCV keeps ties


def test_image_without_texture_has_no_features_but_whole_arrays():
    found = extract(np.full((64, 64, 3), 7, np.uint8), FeatureOptions())
    assert len(found) == len(no_features()) == 0
    assert found.descriptors.shape == (0, 128)
    assert found.color.shape == (0, 3)


def test_grey_image_gets_grey_colours():
    noise = np.random.default_rng(1).integers(0, 255, (128, 128)).astype(np.uint8)
    color = extract(noise, FeatureOptions()).color
    assert len(color) > 3
    assert (color == color[:, :1]).all()


def test_root_sift_is_root_of_shares():
    raw = np.zeros((1, 128), np.float32)
    raw[0, :2] = 3.0
    raw[0, 2:18] = 1.0  # sum 22: roots of 3/22 and 1/22, times 512
    found = root_sift(raw)
    assert found[0, 0] == round(512 * np.sqrt(3 / 22))
    assert found[0, 5] == round(512 * np.sqrt(1 / 22))
    assert not found[0, 18:].any()


def test_share_beyond_byte_is_held_at_255():
    raw = np.zeros((1, 128), np.float32)
    raw[0, 0] = 9.0
    assert root_sift(raw)[0, 0] == 255


def test_descriptors_are_those_of_opencv(texture):
    image = texture.clip(0, 255).astype(np.uint8)
    sift = cv2.SIFT.create(contrastThreshold=0.02, enable_precise_upscale=True)
    found, expected = sift.detectAndCompute(image, None)
    rows = np.array([(*p.pt, p.size, p.angle) for p in found])
    octave = np.array([p.octave for p in found])
    assert len(np.unique(octave & 0xFF)) > 2  # octaves
    described = describe_keypoints(image, rows, octave)
    off = np.abs(described.astype(int) - expected)
    assert off.max() <= 1
    assert (off > 0).mean() < 1e-4
