# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The reprojection part of an adjustment, as every bundle adjuster knows it: cameras, points,
pixels. NumPy alone, because the peers run in an environment without hullrecon.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.typing import Array, Ints32

# Blocks of `native.Problem` that are held where poses and landmarks alone are solved
HELD = (
    "T_g_M",
    "T_s_ct",
    "T_ct_cb",
    "T_s_d",
    "navigation",
    "intrinsics_top",
    "intrinsics_bottom",
    "tray",
)


@dataclass(frozen=True)
class Bundle:
    """Poses, points and pixels. Calibration and stereo mount are held.

    The gauge is pose 0, which is held. With one camera the scale is held too, by the coordinate of
    `baseline`.
    """

    pose: Array  # (n, 7) T_g_ct: x y z qx qy qz qw
    point: Array  # (L, 3) m in g
    camera: Array  # (9,) fx fy cx cy k1 k2 p1 p2 k3, the same for every image
    top_from_bottom: Array  # (7,) T_ct_cb
    seen_from: Ints32  # (m,) pose of each row of `pixel`
    seen: Ints32  # (m,) point of each row
    pixel: Array  # (m, 2) top u v, or (m, 4) top u v, bottom u v

    @property
    def stereo(self) -> bool:
        return bool(self.pixel.shape[1] == 4)

    def baseline(self) -> tuple[int, int, float]:
        """Choose the coordinate that fixes a mono bundle's scale, the largest of the last pose's.

        Returns pose, axis, and the coordinate in m, in the axes of pose 0.
        """
        last = len(self.pose) - 1
        offset = rotation(self.pose[0, 3:]).T @ (self.pose[last, :3] - self.pose[0, :3])
        axis = int(np.argmax(np.abs(offset)))
        return last, axis, float(offset[axis])

    def save(self, path: Path) -> None:
        np.savez(path, **asdict(self))


def load(path: Path) -> Bundle:
    with np.load(path) as archive:
        return Bundle(**{field.name: archive[field.name] for field in fields(Bundle)})


def rotation(quaternion: Array) -> Array:
    """Convert unit quaternions (..., 4), x y z w, to matrices (..., 3, 3)."""
    x, y, z, w = np.moveaxis(np.asarray(quaternion), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def residuals(bundle: Bundle, pose: Array, point: Array) -> Array:
    """Compute predicted less measured pixels, (m, 2) or (m, 4).

    The formula of the pinhole is applied to points behind a camera, too.
    """
    at = pose[bundle.seen_from]
    in_top = np.einsum("nji,nj->ni", rotation(at[:, 3:]), point[bundle.seen] - at[:, :3])
    views = [in_top]
    if bundle.stereo:
        views.append((in_top - bundle.top_from_bottom[:3]) @ rotation(bundle.top_from_bottom[3:]))
    return np.hstack([_project(bundle.camera, view) for view in views]) - bundle.pixel


def _project(camera: Array, points: Array) -> Array:
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = camera
    x, y = (points[:, :2] / points[:, 2:]).T
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([fx * u + cx, fy * v + cy], axis=1)


def rms_px(bundle: Bundle, pose: Array, point: Array) -> float:
    """Compute the RMS over all coordinates of all pixels, by the same code for every solver."""
    return float(np.sqrt(np.mean(residuals(bundle, pose, point) ** 2)))


def peak_mb() -> float:
    """Read the peak resident memory of this process, MB.

    ru_maxrss would not do: a child inherits its parent's through fork and exec.
    """
    status = Path("/proc/self/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def keep_to(threads: int) -> None:
    """Keep this process, and the threads of its libraries, on that many cores."""
    os.sched_setaffinity(0, set(sorted(os.sched_getaffinity(0))[:threads]))


def answer(path: Path, **row: Any) -> None:
    path.write_text(json.dumps(row))
