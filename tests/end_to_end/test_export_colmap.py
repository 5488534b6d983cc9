# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The demo's undistorted images and their COLMAP model belong together, by geometry and by what the
images show.
"""

import cv2
import numpy as np
import pytest
from end_to_end.shell import Shell

pytestmark = pytest.mark.slow
FRAMES = slice(None, None, 12)


@pytest.fixture(scope="module")
def exported(demo_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    Shell(folder)("export", "colmap", demo_run, folder / "out")
    return folder / "out"


@pytest.fixture(scope="module")
def models(demo_run, exported):
    import pycolmap

    return tuple(
        pycolmap.Reconstruction(str(folder))
        for folder in (demo_run / "deliver" / "colmap", exported / "sparse")
    )


def observed(image):
    return {p.point3D_id: p.xy for p in image.points2D if p.has_point3D()}


def test_observations_match_colmap_without_distortion(models):
    delivered, undistorted = models
    worst = 0.0
    for number, image in list(undistorted.images.items())[FRAMES]:
        before, camera = observed(delivered.images[number]), undistorted.cameras[image.camera_id]
        for point, pixel in observed(image).items():
            ideal = delivered.cameras[image.camera_id].cam_from_img(before[point])
            worst = max(worst, np.abs(camera.img_from_cam(np.r_[ideal, 1.0]) - pixel).max())
    assert 0 < worst < 1e-6


def test_points_fall_as_near_their_observations_as_before(models):
    delivered, undistorted = models
    errors = [model.compute_mean_reprojection_error() for model in models]
    assert errors[1] == pytest.approx(errors[0], rel=0.03)
    assert errors[1] < 0.5
    assert undistorted.compute_num_observations() > 0.99 * delivered.compute_num_observations()


def grey(path):
    return cv2.imread(str(path), cv2.IMREAD_GRAYSCALE).astype(np.float32)


def patches(image, pixels, shift=(0.0, 0.0)):
    """Return 9 x 9 patches (n, 81) around COLMAP's pixels (n, 2)."""
    grid = np.stack(np.meshgrid(np.arange(-4, 5), np.arange(-4, 5)), axis=-1).reshape(-1, 2)
    at = (pixels[:, None] + grid - 0.5 + np.array(shift)).astype(np.float32)
    return cv2.remap(image, at[..., 0], at[..., 1], cv2.INTER_CUBIC)


def likeness(first, second):
    """Return the median of the normalised correlation of patches."""
    a, b = (part - part.mean(axis=1, keepdims=True) for part in (first, second))
    return np.median((a * b).sum(axis=1) / np.sqrt((a * a).sum(axis=1) * (b * b).sum(axis=1)))


def test_both_cameras_agree_best_at_a_point_without_shift(models, exported):
    """By the pinhole model alone, as stereo and splatting use it; half a pixel more in any
    direction is less like.
    """
    model = models[1]
    sides = ((0, 0), (0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))
    found = {shift: [] for shift in sides}
    for frame in list(model.frames.values())[FRAMES]:
        top, bottom = (
            model.images[data.id] for data in sorted(frame.image_ids, key=lambda data: data.id)
        )
        both = sorted(observed(top).keys() & observed(bottom).keys())
        place = [
            np.array([image.project_point(model.points3D[p].xyz) for p in both])
            for image in (top, bottom)
        ]
        one, other = (grey(exported / "images" / image.name) for image in (top, bottom))
        for shift in sides:
            found[shift].append((patches(one, place[0]), patches(other, place[1], shift)))
    score = {
        shift: likeness(*map(np.vstack, zip(*parts, strict=True))) for shift, parts in found.items()
    }
    assert score[0, 0] > 0.92  # 0.937 measured
    assert max(score[shift] for shift in sides[1:]) < score[0, 0] - 0.01


def test_an_undistorted_image_shows_what_the_camera_saw(models, exported, demo_run):
    """Patches around observations, in the image of the log and undistorted, at the pixels of the
    two models.
    """
    from hullrecon.geometry.frames import Camera
    from hullrecon.steps.artifacts import IngestArtifact

    delivered, undistorted = models
    number = min(undistorted.images)
    image, before = undistorted.images[number], delivered.images[number]
    raw = cv2.cvtColor(
        IngestArtifact(demo_run / "ingest").images(Camera.TOP, None).read(0), cv2.COLOR_RGB2GRAY
    )
    there, here = observed(before), observed(image)
    points = sorted(here)
    one = patches(raw.astype(np.float32), np.array([there[p] for p in points]))
    other = patches(grey(exported / "images" / image.name), np.array([here[p] for p in points]))
    assert likeness(one, other) > 0.98
    assert np.median(np.abs(one - other)) < 4
