# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What limits the shape of a path: python -m benchmarks.path_modes PACKAGE RUN

Adjusts a simulated dive with a CAD model again from what RUN (its folder of results, up to the step
matches) holds, that model left out, and prints as JSON how well the measurements tell the slow
shapes of the path: its scale, and bends with one and with two turns across its longest axis, along
the hull and off it. Of each it prints the sigma by the information of all factors, landmarks and
all other unknowns eliminated; the true error; and each kind of factor's share of the information.
Sigma and error are the rms in mm that they give the path after rigid alignment.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from benchmarks.arguments import parser_for
from benchmarks.wrong_cad import measurements
from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.typing import Array, Mask

DAMPING = 1e-9  # of information: what nothing determines stays finite
ITERATIONS = 60
SETTINGS = native.Options(
    max_iterations=ITERATIONS, function_tolerance=1e-9, initial_radius=1e8, threads=2
)


@dataclass(frozen=True, kw_only=True)
class Mode:
    """A slow shape of a path of n poses: displacement (n, 3), in g, of rms 1 over the path."""

    name: str
    displacement: Array


@dataclass(frozen=True, kw_only=True)
class Known:
    """How well a mode is known: sigma, m rms of the path; share of the information that each kind
    of factor has.
    """

    sigma: float
    share: dict[str, float]


def modes_of(positions: Array) -> list[Mode]:
    """Return the scale of a path (n, 3) and its bends, quadratic and cubic along its longest axis,
    across both others: free of what a rigid motion does, and of each other's lower order.
    """
    gap = positions - positions.mean(axis=0)
    axes = np.linalg.svd(gap, full_matrices=False)[2]
    along = gap @ axes[0] / np.abs(gap @ axes[0]).max()
    found = [("scale", gap)]
    for axis, name in ((axes[1], "across"), (axes[2], "off the hull")):
        for order, kind in ((2, "bend"), (3, "double bend")):
            lower = np.column_stack([along**k for k in range(order)])
            shape = along**order
            shape = shape - lower @ np.linalg.lstsq(lower, shape, rcond=None)[0]
            found.append((f"{kind} {name}", shape[:, None] * axis))
    return [
        Mode(name=name, displacement=shape / np.sqrt((shape**2).sum(axis=1).mean()))
        for name, shape in found
    ]


def component(mode: Mode, displacement: Array) -> float:
    """Project displacements (n, 3) of the poses on a mode, m rms."""
    return float((mode.displacement * displacement).sum() / len(displacement))


def how_well_known(
    problem: native.Problem, settings: native.Options, modes: list[Mode]
) -> list[Known]:
    """Return the sigma of each mode's component at a problem's solution."""
    at = native.evaluate(problem, settings)
    rows = sparse.csr_matrix(
        (at.jacobian_value, at.jacobian_column, at.jacobian_start),
        shape=(len(at.residual), at.width),
    )
    jacobian = (sparse.diags(at.weight) @ rows).tocsc()
    is_landmark = _landmark_columns(at.columns, at.width)
    points, rest = jacobian[:, is_landmark], jacobian[:, ~is_landmark]
    inverse, coupling = _block_inverse(points), (points.T @ rest).tocsr()
    reduced = splu(
        (
            rest.T @ rest - coupling.T @ (inverse @ coupling) + DAMPING * sparse.eye(rest.shape[1])
        ).tocsc()
    )
    out = []
    for mode in modes:
        functional = np.zeros(at.width)
        for k, moved in enumerate(mode.displacement):
            functional[at.columns[f"pose {k}"][0] :][:3] = moved / len(mode.displacement)
        of_rest = reduced.solve(functional[~is_landmark])
        sigma = float(np.sqrt(functional[~is_landmark] @ of_rest))
        seen = (rest @ of_rest - points @ (inverse @ (coupling @ of_rest))) / sigma
        share = np.bincount(at.factor, seen**2, minlength=len(native.FACTORS))
        out.append(
            Known(
                sigma=sigma,
                share={native.FACTORS[k]: float(share[k]) for k in np.flatnonzero(share > 5e-4)},
            )
        )
    return out


def _landmark_columns(columns: dict[str, tuple[int, int]], width: int) -> Mask:
    """Select the columns (width,) of the Jacobian that belong to landmarks."""
    out = np.zeros(width, bool)
    for name, (start, count) in columns.items():
        if name.startswith("landmark "):
            out[start : start + count] = True
    return out


def _block_inverse(points: sparse.csc_matrix) -> sparse.csr_matrix:
    """Return the inverse of the landmarks' own information, blocks of three, from their Jacobian
    (R, 3 L).
    """
    own = (points.T @ points).tocoo()
    count = points.shape[1] // 3
    blocks = np.zeros((count, 3, 3))
    blocks[own.row // 3, own.row % 3, own.col % 3] = own.data
    inverse = np.linalg.inv(blocks + DAMPING * np.eye(3))
    return sparse.csr_matrix(
        sparse.bsr_matrix((inverse, np.arange(count), np.arange(count + 1)), shape=2 * (3 * count,))
    )


def figures(package: Path, run: Path) -> dict[str, object]:
    """Return the modes of a run's path by name."""
    measured, options = measurements(package, run)
    measured = replace(measured, cad_model=None)
    adjusted = adjust(measured, options, lambda _sentence: None)
    solved = native.solve(adjusted.problem, SETTINGS).unknowns
    problem, positions = adjusted.problem.started_from(solved), solved.pose[:, :3]
    true = read_truth(package).vehicle_at(measured.trajectory.t_ns / 1e9).translation
    error = positions - fit_rigid(true, positions).apply(true)
    modes = modes_of(positions)
    return {
        "nodes": len(positions),
        "error_mm": 1e3 * float(np.sqrt((error**2).sum(axis=1).mean())),
        "modes": {
            mode.name: {
                "error_mm": 1e3 * component(mode, error),
                "sigma_mm": 1e3 * known.sigma,
                "information": known.share,
            }
            for mode, known in zip(modes, how_well_known(problem, SETTINGS, modes), strict=True)
        },
    }


def main() -> None:
    """Print the modes of one run."""
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path, help="the simulated dive")
    parser.add_argument("run", type=Path, help="its folder of results")
    args = parser.parse_args()
    print(json.dumps(figures(args.package, args.run), indent=1))


if __name__ == "__main__":
    main()
