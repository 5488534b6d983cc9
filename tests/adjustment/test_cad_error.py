# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from adjustment.scenes import ERROR, TRUTH, cad_model, side
from scipy.linalg import cho_factor

from hullrecon.adjustment.hull_pose import cad_error
from hullrecon.adjustment.hull_pose.cad_error import CadError
from hullrecon.geometry.meshes.tessellation import tessellation_error


def scattered(count, seed, sigma, length, noise, offset=0.0):
    """Points (n, 3) of a 12 by 4 m side and signed distances drawn from a cad_error_model."""
    random = np.random.default_rng(seed)
    model = cad_model(side(0.0), TRUTH, 0 * ERROR)
    at = np.c_[random.uniform(1, 13, count), np.zeros(count), random.uniform(1, 4, count)]
    nearest = model.mesh.vertices[
        np.argmin(np.linalg.norm(model.mesh.vertices[None] - at[:, None], axis=2), axis=1)
    ]
    at[:, 1] = nearest[:, 1]
    field = cad_error.distance_covariance(
        CadError(sigma=sigma, length=length, noise=noise, offset=offset), model, at
    )
    return model, at, np.linalg.cholesky(field) @ random.standard_normal(count)


def test_the_package_s_word_is_the_start():
    model = cad_model(side(0.0), TRUTH, 0 * ERROR)
    found = cad_error.expected_cad_error(model)
    assert (found.sigma, found.length) == (model.deviation_sigma, model.deviation_length)
    assert found.offset == pytest.approx(0.7 * model.deviation_sigma)


def test_point_on_structure_is_outlier_its_neighbours_are_not():
    model, at, distance = scattered(300, 4, 0.01, (3.0, 1.5), 0.002)
    distance[17] += 0.1
    known = CadError(sigma=0.01, length=(3.0, 1.5), noise=0.002, offset=0.014)
    found = cad_error.find_outliers(
        cho_factor(cad_error.distance_covariance(known, model, at), lower=True), distance
    )
    assert np.flatnonzero(found).tolist() == [17]


def test_offset_of_cad_model_is_common_to_all_points():
    model, at, _ = scattered(40, 5, 0.01, (3.0, 1.5), 0.002)
    known = CadError(sigma=0.01, length=(3.0, 1.5), noise=0.002, offset=0.014)
    without = cad_error.distance_covariance(replace(known, offset=0.0), model, at)
    np.testing.assert_allclose(
        cad_error.distance_covariance(known, model, at) - without, 0.014**2, atol=1e-12
    )


def test_points_on_one_facet_share_its_information():
    model, at, _ = scattered(200, 6, 0.01, (3.0, 1.5), 0.002)
    one_facet = np.repeat(at[:1], 50, axis=0)
    bare = CadError(sigma=0.0, length=(3.0, 1.5), noise=0.0, offset=0.0)
    variance = np.diag(cad_error.distance_covariance(bare, model, one_facet))
    mean_variance = variance[0] / 50
    assert mean_variance == pytest.approx(
        (3 * tessellation_error(model.mesh, one_facet).sigma_m) ** 2
    )
