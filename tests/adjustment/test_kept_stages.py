# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""adjust: the stages that a killed run has left give the adjusted dive that it would have given."""

import numpy as np
from adjustment.simulated_dive import simulate

from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.artifacts.manifest import Recipe
from hullrecon.artifacts.parts import PartStore

OPTIONS = AdjustOptions()


def test_kept_stages_give_the_same_result_without_their_rounds(tmp_path):
    measured = simulate(per_leg=8, landmarks=300).measured
    given = {name: getattr(measured, name) for name in measured.__dataclass_fields__}
    store = PartStore(tmp_path / "parts", Recipe(stage="adjust", version=1, settings={}))

    def keep(make, label):
        _, results = store.resume(label, [label], lambda _: iter([make()]), given=given)
        return next(results)

    def solve(*more):
        lines = []
        return adjust(measured, OPTIONS, lines.append, PRODUCT, *more), lines

    plain, _ = solve()
    kept, first_lines = solve(keep)
    resumed, lines = solve(keep)
    for found in (kept, resumed):
        np.testing.assert_array_equal(found.result.unknowns.pose, plain.result.unknowns.pose)
        np.testing.assert_array_equal(found.state.landmark, plain.state.landmark)
    assert len(resumed.rounds) == len(plain.rounds)
    assert [line for line in lines if line.startswith("round")] == [
        line for line in first_lines if line.startswith(f"round {len(plain.rounds)}")
    ]
