# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every number with a sigma that a run delivers beside the truth: errors in sigmas, by the name of what was claimed.

Shares no code with what it judges. What a run says of a piece of steel is held against that piece; what it says of a place in
the ship's frame is held against the true place.
"""

import html
import json
import re

import numpy as np
from end_to_end.true_hull import read_ply, read_table
from scipy.spatial.transform import Rotation, Slerp


def page_text(run):
    """The words of the page as a reader sees them."""
    raw = (run / "deliver" / "report" / "index.html").read_text()
    raw = re.sub(r"(?s)<style>.*?</style>|<script\b.*?</script>|<details.*?</details>", " ", raw)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"(?s)<[^>]*>", " ", raw)))


def document(run, name):
    return json.loads((run / "deliver" / name).read_text())


def object_errors(run, hull, in_ship_frame):
    """Errors over sigma of each reported object's numbers, by object and number; empty for one that matches no structure."""
    out = {}
    for found in document(run, "objects.json")["objects"]:
        center = np.array(found["center"])
        laid = hull.lay(center[None])[0]
        near = min((o for o in hull.objects if o["height"]), key=lambda o: np.linalg.norm(laid - o["center"]))
        if np.linalg.norm(laid - near["center"]) > 0.1 + 0.5 * max(near["extent"]):
            out[found["id"]] = {}
            continue
        extent, area, volume = hull.footprint(near["center"], near["height"], 0.6 * max(near["extent"]) + 0.05)
        errors = {
            "height": (found["height"] - near["height"]) / found["height_sigma"],
            "extent along": (found["extent"][0] - extent[0]) / found["extent_sigma"][0],
            "extent in girth": (found["extent"][1] - extent[1]) / found["extent_sigma"][1],
            "area": (found["area"] - area) / found["area_sigma"],
            "volume": (found["volume"] - volume) / found["volume_sigma"],
        }
        if in_ship_frame:
            errors |= _place_errors(found, near, hull)
        out[found["id"]] = errors
    return out


def _place_errors(found, near, hull):
    off = np.array(found["center"]) - near["center"]
    covariance = np.array(found["position_covariance"])
    errors = {axis: off[k] / found["position_sigma"][k] for k, axis in enumerate("xyz")}
    errors["place"] = np.sqrt(off @ np.linalg.solve(covariance, off) / 3)
    errors["along"] = (found["along"] - near["center"][0]) / found["sigma_along"]
    relief = hull.relief(near["center"])
    on = np.hypot(relief[0], relief[1]) < 0.5 * max(near["extent"])
    largest = np.percentile(np.sign(near["height"]) * relief[2][on], 98) * np.sign(near["height"])
    errors["deviation"] = (found["deviation"] - largest) / found["deviation_sigma"]
    if found["depth"] is not None:
        errors["depth"] = (found["depth"] - hull.depth(np.array(near["center"]))) / found["depth_sigma"]
    return errors


def deviation_errors(run, hull):
    """Errors over sigma of the hull as found: of each seen vertex of bare steel its deviation and form; of the whole its
    offset; and, in sigmas of the form, of its percentiles."""
    vertex, faces = read_ply(run / "deliver" / "as_found.ply")
    xyz = np.stack([vertex[k] for k in "xyz"], axis=1)
    corners = xyz[faces]
    third = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 6
    area = np.zeros(len(xyz))
    np.add.at(area, faces.ravel(), np.repeat(third, 3))
    seen = (vertex["support"] > 0) & np.isfinite(vertex["form"])
    vertex, xyz, area = vertex[seen], xyz[seen], area[seen]
    true = hull.deviation(xyz)
    bare = np.abs(true - np.median(true)) < 0.03
    middle = np.average(xyz[bare], axis=0, weights=area[bare])
    _, _, axes = np.linalg.svd(xyz[bare] - middle, full_matrices=False)
    plane = np.column_stack([np.ones(len(xyz)), (xyz - middle) @ axes[:2].T])
    root = np.sqrt(area[bare])
    fit = np.linalg.lstsq(plane[bare] * root[:, None], true[bare] * root, rcond=None)[0]
    form = true - plane @ fit
    said = document(run, "summary.json")["deviation"]
    low, high = (weighted(form, area, p) for p in (5, 95))
    return {
        "deviation": (vertex["deviation"] - true)[bare] / vertex["sigma"][bare],
        "form": (vertex["form"] - form)[bare] / vertex["form_sigma"][bare],
        "offset": (said["offset_m"] - np.average((plane @ fit)[bare], weights=area[bare])) / said["offset_sigma_m"],
        "form percentiles": np.array([said["form_m"]["p05"] - low, said["form_m"]["p95"] - high]) / said["form_sigma_m"],
    }


def weighted(values, weight, percent):
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    return values[order][np.searchsorted(share, percent / 100 * share[-1])]


def path_errors(run, package):
    """Errors over sigma (n, 3) of the vehicle's position in the ship's frame at the true times."""
    ours, real = read_table(run / "deliver" / "trajectory.csv"), read_table(package / "truth" / "poses.csv")
    t, true_t = np.array(ours["t"], float), np.array(real["t"], float)
    columns = []
    for k in "xyz":
        want = np.interp(t, true_t, np.array(real[k], float))
        columns.append((np.array(ours[k], float) - want) / np.array(ours[f"sigma_{k}"], float))
    return np.stack(columns, axis=1)


def depth_errors(run, package, hull):
    """Errors over sigma (n,) of the vehicle's depth at the true times."""
    ours, real = read_table(run / "deliver" / "trajectory.csv"), read_table(package / "truth" / "poses.csv")
    t, true_t = np.array(ours["t"], float), np.array(real["t"], float)
    place = np.stack([np.interp(t, true_t, np.array(real[k], float)) for k in "xyz"], axis=1)
    want = np.array([hull.depth(point) for point in place])
    return (np.array(ours["depth"], float) - want) / np.array(ours["depth_sigma"], float)


def sensor_errors(run, package, drift_deg_per_hour=1.0, dvl_scale_error=0.003):
    """Errors over sigma of the sensors' errors that the page's table of the calibration names; what was simulated, where it is
    one number, else the mean of what was logged less the truth."""
    truth = {
        "Scale error of the DVL's velocities": 100 * dvl_scale_error,
        "Drift of the heading": drift_deg_per_hour,
        **_mean_biases(run, package),
    }
    page = html.unescape((run / "deliver" / "report" / "index.html").read_text())
    rows = re.findall(r'<tr><th scope="row">([^<]*)</th><td>([−+][\d.]+) ± ([\d.]+)[ °]', page)
    return {name: (float(value.replace("−", "-")) - truth[name]) / float(sigma) for name, value, sigma in rows if name in truth}


def _mean_biases(run, package):
    """Roll, pitch (deg) and depth (mm) as logged less the truth, over the dive."""
    rows = np.genfromtxt(package / "truth" / "poses.csv", delimiter=",", names=True)
    alignment = json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]
    to_level = Rotation.from_quat(alignment["quaternion"])
    attitude = to_level * Rotation.from_quat(np.stack([rows[k] for k in ("qx", "qy", "qz", "qw")], axis=1))
    depth = to_level.apply(np.stack([rows[k] for k in "xyz"], axis=1))[:, 2] + alignment["translation"][2]
    out = {}
    if (run / "ingest" / "imu.npz").exists():
        imu = np.load(run / "ingest" / "imu.npz")
        t, on = _within(imu["t_ns"], rows["t"])
        measured = Rotation.from_quat(imu["quaternion"][on]).as_euler("ZYX")
        off = np.degrees(measured - Slerp(rows["t"], attitude)(t).as_euler("ZYX")).mean(axis=0)
        out |= {"Bias of pitch": off[1], "Bias of roll": off[2]}
    if (run / "ingest" / "pressure.npz").exists():
        pressure = np.load(run / "ingest" / "pressure.npz")
        t, on = _within(pressure["t_ns"], rows["t"])
        out["Bias of the depth"] = 1000 * (pressure["depth"][on] - np.interp(t, rows["t"], depth)).mean()
    return out


def _within(t_ns, t):
    """The times, in s, that lie within those of the truth, and which they are."""
    on = (t_ns * 1e-9 > t[0]) & (t_ns * 1e-9 < t[-1])
    return t_ns[on] * 1e-9, on
