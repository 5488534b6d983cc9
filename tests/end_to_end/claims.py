# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every number with a sigma that a run delivers beside the truth: errors in sigmas, by the name of
what was claimed.

Shares no code with what it judges. What a run says of a piece of steel is held against that piece;
what it says of a place in the ship's frame is held against the true place.
"""

import html
import json
import re
from dataclasses import dataclass

import numpy as np
from end_to_end.true_hull import read_numbers, read_ply, read_poses
from scipy.spatial.transform import Rotation, Slerp

SIGMAS = ("x", "y", "z", "roll", "pitch", "yaw")  # of trajectory.csv


def page_text(run):
    """The words of the page as a reader sees them."""
    raw = (run / "deliver" / "report" / "index.html").read_text()
    raw = re.sub(r"(?s)<style>.*?</style>|<script\b.*?</script>|<details.*?</details>", " ", raw)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"(?s)<[^>]*>", " ", raw)))


def document(run, name):
    return json.loads((run / "deliver" / name).read_text())


@dataclass(frozen=True)
class Claim:
    """What a run says, its sigma, and what is true."""

    said: float
    sigma: float
    true: float

    @property
    def error(self):
        """In sigmas."""
        return (self.said - self.true) / self.sigma


def object_errors(run, hull, in_ship_frame):
    """Errors over sigma of each reported object's numbers, by object and number; empty for one that
    matches no structure.
    """
    found = {o["id"]: o for o in document(run, "objects.json")["objects"]}
    out = {}
    for number, claimed in object_claims(run, hull, in_ship_frame).items():
        out[number] = {name: claim.error for name, claim in claimed.items()}
        if claimed:
            off = np.array([claimed[k].said - claimed[k].true for k in "xyz"])
            covariance = np.array(found[number]["position_covariance"])
            out[number]["place"] = np.sqrt(off @ np.linalg.solve(covariance, off) / 3)
            out[number]["along the normal"] = (
                off @ found[number]["normal"] / found[number]["sigma_normal"]
            )
    return out


def object_claims(run, hull, in_ship_frame):
    """Claims by each reported object's number and by name; none for one that matches no structure.

    In g a place is true that lies to the true path as the run's lies to its own.
    """
    out = {}
    for found in document(run, "objects.json")["objects"]:
        laid = hull.lay(np.array(found["center"])[None])[0]
        near = min(
            (o for o in hull.objects if o["height"]),
            key=lambda o: np.linalg.norm(laid - o["center"]),
        )
        if np.linalg.norm(laid - near["center"]) > 0.1 + 0.5 * max(near["extent"]):
            out[found["id"]] = {}
            continue
        extent, area, volume = hull.footprint(
            near["center"], near["height"], 0.6 * max(near["extent"]) + 0.05
        )
        out[found["id"]] = {
            "height": Claim(found["height"], found["height_sigma"], near["height"]),
            "extent along": Claim(found["extent"][0], found["extent_sigma"][0], extent[0]),
            "extent in girth": Claim(found["extent"][1], found["extent_sigma"][1], extent[1]),
            "area": Claim(found["area"], found["area_sigma"], area),
            "volume": Claim(found["volume"], found["volume_sigma"], volume),
            **(
                _place_on_ship(found, near, hull)
                if in_ship_frame
                else _place_by_the_path(found, near, hull, run)
            ),
        }
    return out


def _center(found, true):
    return {
        k: Claim(found["center"][i], found["position_sigma"][i], true[i])
        for i, k in enumerate("xyz")
    }


def _place_on_ship(found, near, hull):
    center = np.array(near["center"])
    along, girth = hull.chart(center[None])[0]
    relief = hull.relief(near["center"])
    on = np.hypot(relief[0], relief[1]) < 0.5 * max(near["extent"])
    largest = np.percentile(np.sign(near["height"]) * relief[2][on], 98) * np.sign(near["height"])
    claimed = {
        **_center(found, center),
        "along": Claim(found["along"], found["sigma_along"], along),
        "girth": Claim(found["girth"], found["sigma_girth"], girth),
        "deviation": Claim(found["deviation"], found["deviation_sigma"], largest),
    }
    if found["depth"] is not None:
        claimed["depth"] = Claim(found["depth"], found["depth_sigma"], hull.depth(center))
    return claimed


def _place_by_the_path(found, near, hull, run):
    plane = document(run, "chart.json")["plane"]
    true = hull.lay_back(np.array(near["center"])[None])[0]
    along, across = (np.array(plane[k]) @ (true - plane["origin"]) for k in ("along", "girth"))
    claimed = {
        **_center(found, true),
        "along": Claim(found["along"], found["sigma_along"], along),
        "girth": Claim(found["girth"], found["sigma_girth"], across),
    }
    if found["depth"] is not None:
        claimed["depth"] = Claim(
            found["depth"], found["depth_sigma"], hull.depth(np.array(near["center"]))
        )
    return claimed


def deviation_errors(run, hull):
    """Errors over sigma of the hull as found: of each seen vertex of bare steel its deviation and
    form; of the whole its offset and tilts; and, in sigmas of the form, of its percentiles.
    """
    claimed = deviation_claims(run, hull)
    return {name: claim.error for name, claim in claimed.items()}


def deviation_claims(run, hull):
    vertex, faces = read_ply(run / "deliver" / "as_found.ply")
    xyz = np.stack([vertex[k] for k in "xyz"], axis=1)
    area = vertex_areas(xyz, faces)
    seen = (vertex["support"] > 0) & np.isfinite(vertex["form"])
    vertex, xyz, area = vertex[seen], xyz[seen], area[seen]
    true = hull.deviation(xyz)
    bare = np.abs(true - np.median(true)) < 0.03
    plane = np.column_stack(
        [
            np.ones(len(xyz)),
            _along_and_across(hull, xyz, np.average(xyz[bare], axis=0, weights=area[bare])),
        ]
    )
    root = np.sqrt(area[bare])
    fit = np.linalg.lstsq(plane[bare] * root[:, None], true[bare] * root, rcond=None)[0]
    form = true - plane @ fit
    said = document(run, "summary.json")["deviation"]
    percentiles = np.array([weighted(form, area, p) for p in (5, 95)])
    offset = np.average((plane @ fit)[bare], weights=area[bare])
    return {
        "deviation": Claim(vertex["deviation"][bare], vertex["sigma"][bare], true[bare]),
        "form": Claim(vertex["form"][bare], vertex["form_sigma"][bare], form[bare]),
        "offset": Claim(said["offset_m"], said["offset_sigma_m"], offset),
        "tilt": Claim(np.array(said["tilt"]), np.array(said["tilt_sigma"]), fit[1:]),
        "form percentiles": Claim(
            np.array([said["form_m"]["p05"], said["form_m"]["p95"]]),
            said["form_sigma_m"],
            percentiles,
        ),
    }


def _along_and_across(hull, xyz, middle):
    """Metres (n, 2) from the middle along the ship, and in growing girth, on the plane that touches
    the hull there.
    """
    _, normal = hull.cad.closest(middle[None])
    along = np.array([1.0, 0, 0]) - normal[0] * normal[0, 0]
    along /= np.linalg.norm(along)
    return (xyz - middle) @ np.column_stack([along, -np.cross(normal[0], along)])


def vertex_areas(xyz, faces):
    corners = xyz[faces]
    third = (
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        / 6
    )
    return np.bincount(faces.ravel(), weights=np.repeat(third, 3), minlength=len(xyz))


def weighted(values, weight, percent):
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    return values[order][np.searchsorted(share, percent / 100 * share[-1])]


@dataclass(frozen=True)
class PathClaims:
    """The path beside the truth, at the times t (n,) s that the truth holds. error, sigma (n, 6):
    of the position along the frame's axes, m, and of a small rotation about the vehicle's, rad;
    true_position (n, 3) m in the frame of the results.
    """

    t: np.ndarray
    true_position: np.ndarray
    error: np.ndarray
    sigma: np.ndarray


def depth_errors(run, package, hull):
    """Errors over sigma (n,) of the vehicle's depth at the true times."""
    path = path_claims(run, package)
    want = np.array([hull.depth(point) for point in path.true_position])
    table = run / "deliver" / "trajectory.csv"
    on = np.isin(read_poses(table).t, path.t)
    return (read_numbers(table, "depth")[on] - want) / read_numbers(table, "depth_sigma")[on]


def path_claims(run, package):
    """In the ship's frame the path is held against the true one; in g, which begins where the
    vehicle began, against the true one as seen from there.
    """
    ours, real = (
        read_poses(run / "deliver" / "trajectory.csv"),
        read_poses(package / "truth" / "poses.csv"),
    )
    on = (ours.t >= real.t[0] - 1e-6) & (ours.t <= real.t[-1] + 1e-6)
    position, attitude = real.at(ours.t[on])
    sigma = np.stack(
        [read_numbers(run / "deliver" / "trajectory.csv", f"sigma_{k}")[on] for k in SIGMAS], axis=1
    )
    if document(run, "summary.json")["frame"] == "g":
        position, attitude = _from_the_start(run, package, position, attitude)
    turn = (attitude.inv() * ours.attitude[on]).as_rotvec()
    return PathClaims(ours.t[on], position, np.hstack([ours.position[on] - position, turn]), sigma)


def _from_the_start(run, package, position, attitude):
    """True poses in the run's g: level and depth are those of the water where they were measured,
    else of the first pose; what is left of place and heading is that of the first pose.
    """
    first = read_poses(run / "deliver" / "trajectory.csv")
    place = json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]
    level = Rotation.from_quat(place["quaternion"])
    position, attitude = level.apply(position) + place["translation"], level * attitude
    measured = [(run / "ingest" / f"{name}.npz").exists() for name in ("imu", "pressure")]
    turn = first.attitude[0] * attitude[0].inv()
    if measured[0]:
        heading = [a.as_euler("ZYX")[0] for a in (first.attitude[0], attitude[0])]
        turn = Rotation.from_euler("z", heading[0] - heading[1])
    shift = first.position[0] - turn.apply(position[0])
    if measured[1]:
        shift[2] = 0.0
    return turn.apply(position) + shift, turn * attitude


def hull_pose_errors(run, package):
    """Errors of T_g_M about the survey's center over sigma: six, and the root mean square of all in
    their covariance.
    """
    error, covariance = _hull_pose_error(run, package)
    whole = np.sqrt(error @ np.linalg.solve(covariance, error) / 6)
    return np.append(error / np.sqrt(np.diag(covariance)), whole)


def _hull_pose_error(run, package):
    """Error (6,) of T_g_M: of the survey's center in g, m, of the rotation in the ship's axes, rad;
    covariance (6, 6).
    """
    said = document(run, "alignment.json")
    true = json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]
    center = np.array(said["survey_center"])
    ours, real = (
        Rotation.from_quat(said["T_g_M"]["quaternion"]),
        Rotation.from_quat(true["quaternion"]),
    )
    places = [
        turn.apply(center) + at["translation"] for turn, at in ((ours, said["T_g_M"]), (real, true))
    ]
    return np.append(places[0] - places[1], (real.inv() * ours).as_rotvec()), np.array(
        said["covariance"]
    )


def errors_by_axis(run, package):
    """Errors of the hull's pose by kind, position (3,) m and attitude (3,) rad, along and about the
    ship's axes.
    """
    real = Rotation.from_quat(
        json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]["quaternion"]
    )
    error, _ = _hull_pose_error(run, package)
    return {"position": real.inv().apply(error[:3]), "attitude": error[3:]}


def weak_direction_errors(run, package):
    """Error (m or rad) and sigma along each direction that is called weak, by its kind and the
    ship's axis next to it.
    """
    said, parts = document(run, "alignment.json"), errors_by_axis(run, package)
    return {
        (weak["kind"], int(np.argmax(np.abs(weak["direction"])))): (
            parts[weak["kind"]] @ weak["direction"],
            weak["sigma"],
        )
        for weak in said["weak_directions"]
    }


def surface_errors(run, hull, name):
    """Distances over sigma (n,) of a surface's or cloud's supported points to the steel that they
    are of; without those beyond the rim of the true steel.
    """
    vertex = read_ply(run / "deliver" / name)[0]
    keep = np.isfinite(vertex["sigma"])
    if "support" in vertex.dtype.names:
        keep &= vertex["support"] > 0
    points = hull.lay(np.stack([vertex[k] for k in "xyz"], axis=1)[keep])
    foot, _ = hull.built.closest(points)
    known = hull.rim.query(foot)[0] > 0.02  # as wide as the truth's faces
    return (np.linalg.norm(points - foot, axis=1) / vertex["sigma"][keep])[known]


def sensor_errors(run, package, **simulated):
    """Errors over sigma of the sensors' errors that the page's table of the calibration names;
    simulated: what `true_sensor_errors` takes, where it is not the simulator's default.
    """
    truth = true_sensor_errors(run, package, **simulated)
    page = html.unescape((run / "deliver" / "report" / "index.html").read_text())
    rows = re.findall(r'<tr><th scope="row">([^<]*)</th><td>([−+][\d.]+) ± ([\d.]+)[ °]', page)
    return {
        name: (float(value.replace("−", "-")) - truth[name]) / float(sigma)
        for name, value, sigma in rows
        if name in truth
    }


def true_sensor_errors(run, package, drift_deg_per_hour=1.0, dvl_scale_error=0.003):
    """The sensors' errors in the units of the page: what was simulated, where it is one number,
    else the mean of what was logged less the truth.
    """
    return {
        "Scale error of the DVL's velocities": 100 * dvl_scale_error,
        "Drift of the heading": drift_deg_per_hour,
        **_mean_biases(run, package),
    }


def _mean_biases(run, package):
    """Roll, pitch (deg) and depth (mm) as logged less the truth, over the dive."""
    rows = np.genfromtxt(package / "truth" / "poses.csv", delimiter=",", names=True)
    alignment = json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]
    to_level = Rotation.from_quat(alignment["quaternion"])
    attitude = to_level * Rotation.from_quat(
        np.stack([rows[k] for k in ("qx", "qy", "qz", "qw")], axis=1)
    )
    depth = (
        to_level.apply(np.stack([rows[k] for k in "xyz"], axis=1))[:, 2]
        + alignment["translation"][2]
    )
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
        out["Bias of the depth"] = (
            1000 * (pressure["depth"][on] - np.interp(t, rows["t"], depth)).mean()
        )
    return out


def _within(t_ns, t):
    """The times, in s, that lie within those of the truth, and which they are."""
    on = (t_ns * 1e-9 > t[0]) & (t_ns * 1e-9 < t[-1])
    return t_ns[on] * 1e-9, on
