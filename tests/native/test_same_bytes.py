# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""At the field's scale, where every sum is cut into many slabs, the number of threads still changes
no byte.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import pose_graph
from benchmarks.problems import make
from benchmarks.survey import Size
from hullrecon.native import Options, solve
from hullrecon.navigation.pose_graph.graph import OPTIONS


@pytest.mark.slow
def test_half_a_million_observations_repeat_bytes_on_two_threads() -> None:
    problem = make(Size(poses=12500, imaged=11600, landmarks=125000, stereo=True, legs=20))
    assert problem.stereo.pixel.size // 2 >= 500_000
    one, two = (solve(problem, Options(threads=threads, max_iterations=2)) for threads in (1, 2))
    assert one.iterations.accepted.sum() > 1
    for name, values in vars(one.unknowns).items():
        assert values.tobytes() == getattr(two.unknowns, name).tobytes(), name
    for name in ("cost", "step_norm", "gradient_norm", "radius", "on_surface", "label_changes"):
        np.testing.assert_array_equal(
            getattr(one.iterations, name), getattr(two.iterations, name), err_msg=name
        )
    for name in ("label", "distance", "ray_hit"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name


def test_pose_graph_repeats_its_bytes_on_any_number_of_threads() -> None:
    problem, _ = pose_graph.make(2 * pose_graph.LEG_NODES)
    one, *others = (
        solve(problem, replace(OPTIONS, threads=threads, max_iterations=2)) for threads in (1, 2, 3)
    )
    assert one.iterations.accepted.sum() > 1
    for other in others:
        assert one.unknowns.pose.tobytes() == other.unknowns.pose.tobytes()
        assert one.unknowns.plane.tobytes() == other.unknowns.plane.tobytes()
        np.testing.assert_array_equal(one.iterations.cost, other.iterations.cost)
