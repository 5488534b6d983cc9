# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every number of the report's page beside the truth: a table of patterns, each with the function
that judges what it says.

A number that no pattern covers is untrue until somebody says what would make it true. What is said
of the ship, the path, the objects and the sensors is held against what was simulated; what is said
of the run itself (warnings, residuals, times) against the files that it left.
"""

import re

import numpy as np
from end_to_end.true_dive import BAY_M

from hullrecon.detection.options import DetectOptions

NUMBER = r"[−+-]?\d[\d,]*(?:\.\d+)?"
N = f"({NUMBER})"
WITH_SIGMA = rf"{N} ± {N}"
PLACE = rf"(?:frames? \d[^(]*\()?{WITH_SIGMA} m"


def value(text):
    return float(text.replace("−", "-").replace(",", ""))


def half_digit(text):
    """What rounding may have taken from a printed number."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def unlike(what, said, true, allowed=0.0):
    """Complains unless a printed number is the true one, to its digits and as much besides."""
    true = np.asarray(true, float)
    if abs(value(said) - true) <= 1.001 * half_digit(said) + allowed:
        return []
    return [f"{what}: said {said}, true {float(true):.5g} (allowed {allowed:.2g})"]


def beyond(what, said, sigma, true, most=3.0):
    """Complains unless the true value lies within three of the sigmas that are said beside the
    printed one.
    """
    return unlike(what, said, true, most * (value(sigma) + half_digit(sigma)))


def too_sure(what, sigma, error, unit=1.0, most=3.0):
    """Complains where the true error is more than three of a printed sigma."""
    return (
        []
        if np.all(np.abs(error) <= most * unit * (value(sigma) + half_digit(sigma)))
        else [f"{what}: sigma {sigma}, error {error}"]
    )


# What was done


SAME_TIME_S = 1e-4  # a time of some 1e9 s in double precision, printed to microseconds


def _dive(dive, _, minutes, seconds, path, poses, images, cameras):
    """A pose stands where something was measured: an image where there is a camera, and no image is
    left out.
    """
    t, at = dive.measured_times, dive.pose_times
    out = unlike("duration", _seconds(minutes, seconds), t[-1] - t[0])
    out += unlike("path", path, dive.true_path_m, 0.02 * dive.true_path_m)
    out += unlike("poses", poses, len(t) if dive.images else len(at))
    apart = np.abs(at[:, None] - t).min(axis=1)
    out += (
        []
        if apart.max() < SAME_TIME_S
        else [f"a pose stands {apart.max():.3f} s from all that was measured"]
    )
    if images is None:
        return out + (["images without a camera"] if dive.images else [])
    return (
        out
        + unlike("images", images, sum(dive.images))
        + unlike("cameras", cameras, len(dive.images))
    )


def _seconds(minutes, seconds):
    return str(60 * int(minutes or 0) + int(seconds))


def _median_sigmas(dive, _, *sigmas):
    unit = 1e-3 if sigmas[3] == "mm" else 1.0
    out = []
    for k, sigma in enumerate(sigmas[:3]):
        out += unlike(f"median sigma {k}", sigma, np.median(dive.path_sigma[:, k]) / unit)
        out += too_sure(f"position {k}", sigma, np.median(dive.path_error[:, k]), unit)
    return out


def _vehicle_place(dive, _, along, along_unit, across, across_unit):
    error = dive.error_on_hull
    units = {"m": 1.0, "mm": 1e-3}
    return too_sure("along", along, error[0], units[along_unit]) + too_sure(
        "across", across, error[1], units[across_unit]
    )


def _vehicle_place_m(dive, said, along, across):
    return _vehicle_place(dive, said, along, "m", across, "m")


def _weak_position(dive, _, way, sigma):
    return too_sure(f"position {way}", sigma, dive.weak_error("position", way))


def _weak_attitude(dive, _, angle, sigma):
    return too_sure(angle, sigma, np.degrees(dive.weak_error("attitude", angle)))


def _weak_axis(dive, _, axis, sigma, unit):
    k = "xyz".index(axis)
    return too_sure(
        f"position in {axis}", sigma, np.median(dive.path_error[:, k]), {"m": 1.0, "mm": 1e-3}[unit]
    )


def _pixels_place(dive, _, sigma):
    return too_sure("a pixel's place", sigma, np.hypot(*dive.error_on_hull), 1e-3)


# What was found


def _count_of_objects(dive, _, count, *__):
    due, real = dive.objects_due
    return [] if due <= int(count) <= real else [f"objects: said {count}, true {due} to {real}"]


def _objects(dive, said, count, kinds, number, height, sigma):
    signs = [np.sign(o["height"].true) for o in dive.objects.values()]
    out = _count_of_objects(dive, said, count)
    for many, kind in re.findall(r"(\d+) (protrusion|recess)", kinds):
        out += unlike(kind, many, signs.count(1.0 if kind == "protrusion" else -1.0))
    largest = max(abs(o["height"].true) for o in dive.objects.values())
    found = dive.objects[int(number)]["height"]
    out += beyond("height of the largest", height, sigma, found.true)
    return out + (
        ["another is the largest"] if abs(found.true) < largest - 3 * value(sigma) else []
    )


def _of_object(*names, factor=1.0):
    """Judges pairs of number and sigma by the truth of the object that the statement is of."""

    def judge(dive, said, *pairs):
        truths = dive.objects.get(said.object)
        if truths is None:
            return [f"there is no object {said.object}"]
        out = []
        for name, number, sigma in zip(names, pairs[::2], pairs[1::2], strict=True):
            out += beyond(f"{name} of {said.object}", number, sigma, factor * truths[name].true)
        return out

    return judge


def _area_and_volume(dive, said, area, area_sigma, volume, volume_sigma):
    return _of_object("area", factor=1e4)(dive, said, area, area_sigma) + _of_object(
        "volume", factor=1e3
    )(dive, said, volume, volume_sigma)


def _kind(dive, said, number, kind):
    recess = dive.objects[int(number)]["height"].true < 0
    return [] if recess == (kind.lower() == "recess") else [f"object {number} is no {kind}"]


def _row(dive, said, *pairs):
    names = ("height", "area", "along", "girth", "depth")[: 5 if pairs[-1] else 4]
    out = []
    for name, number, sigma in zip(names, pairs[::2], pairs[1::2], strict=False):
        out += _of_object(name, factor=1e4 if name == "area" else 1.0)(dive, said, number, sigma)
    return out


def _address(
    dive,
    said,
    number,
    height,
    height_sigma,
    frames,
    along,
    along_sigma,
    side,
    girth,
    girth_sigma,
    depth,
    depth_sigma,
):
    truths = dive.objects.get(int(number) if number else said.object)
    if truths is None:
        return ["an address of no object"]
    out = beyond("height", height, height_sigma, truths["height"].true) if number else []
    out += beyond("along", along, along_sigma or "0", truths["along"].true)
    if frames:
        low, high = (value(v) for v in (frames.split(" to ") * 2)[:2])
        true, spread = (
            truths["along"].true / dive.frame_spacing_m,
            2 * value(along_sigma or "0") / dive.frame_spacing_m,
        )
        out += (
            []
            if low - 0.5 - spread <= true <= high + 0.5 + spread
            else [f"frames {frames}: true {true:.1f}"]
        )
    if girth:
        signed = "-" + girth if side == "starboard" else girth
        out += beyond("girth", signed, girth_sigma or "0", truths["girth"].true)
    return out + (beyond("depth", depth, depth_sigma or "0", truths["depth"].true) if depth else [])


def _views(dive, said, count):
    seen = dive.views.frames_that_show(dive.structure_of(said.object))
    return unlike(f"views of {said.object}", count, seen, max(1, 0.15 * seen))


def _alarm(dive, said, p):
    return [] if said.object in dive.objects else ["a false alarm is said to be sure"]


def _object_number(dive, said, number):
    return [] if said.object == int(number) else ["another object's picture"]


def _image(dive, _, camera, number, stamp):
    near = np.abs(
        dive.image_times(camera) - np.datetime64(stamp.replace(" ", "T"), "ns").astype(np.int64)
    ).argmin()
    return unlike("image", number, near)


# The hull


def _form(dive, _, low, high, sigma):
    true = 1000 * np.array(dive.deviation["form percentiles"].true)
    return beyond("form, low", low, sigma, true[0]) + beyond("form, high", high, sigma, true[1])


def _offset(dive, _, size, side, sigma, insignificant):
    signed = size if side != "inside" else "-" + size
    out = beyond("offset", signed, sigma, 1000 * dive.deviation["offset"].true)
    small = abs(value(size)) <= 2 * value(sigma) + half_digit(sigma) + 0.5
    clear = abs(value(size)) >= 2 * value(sigma) - half_digit(sigma) - 0.5
    return out + (
        ["its significance is said wrongly"] if not (small if insignificant else clear) else []
    )


def _signed_offset(dive, _, size, sigma):
    return beyond("offset", size, sigma, 1000 * dive.deviation["offset"].true)


def _tilt(dive, _, along, along_sigma, girth, girth_sigma):
    true = 1000 * np.array(dive.deviation["tilt"].true)
    return beyond("tilt along", along, along_sigma, true[0]) + beyond(
        "tilt in girth", girth, girth_sigma, true[1]
    )


def _proportions(dive, _, percent):
    """The simulated CAD model is to scale."""
    return [] if value(percent) > 0 else ["a sigma of zero"]


def _lengths(dive, _, percent, in_fresh_water):
    """Two cameras tell lengths. Sound goes at 1490 m/s in sea water of 10 degrees, in fresh water
    of 10 degrees at 1447 m/s.
    """
    out = unlike("dvl.scale_sigma", percent, 100 * dive.settings["dvl"].get("scale_sigma", 0.005))
    out += unlike("sea water over fresh", in_fresh_water, 100 * (1490 / 1447 - 1))
    return out + (["two cameras tell lengths"] if len(dive.images) > 1 else [])


def _cad_model(dive, _, faces, *sizes):
    size = dive.cad_mesh.bounds
    true = (*(size[1] - size[0]), *size[0], *size[1])
    out = unlike("faces", faces, len(dive.real_faces))
    for said, real in zip(sizes, true, strict=True):
        out += unlike("size of the CAD model", said, real)
    return out


def _degenerate(dive, _, count):
    return unlike("degenerate faces", count, int(dive.flat_faces.sum()))


def _duplicate(dive, _, count):
    return unlike("duplicate faces", count, int((~dive.flat_faces).sum()) - len(dive.real_faces))


def _boundary(dive, _, count):
    return unlike("boundary edges", count, dive.boundary_edges)


# Coverage and mosaics

AREA_SHARE = 0.03  # of the rim of an area, summed over pieces of a decimetre


def _area(dive, _, area, sensor):
    if sensor == "DVL":
        least, most = dive.seen_by_dvl()
        return (
            []
            if least <= value(area) <= most
            else [f"area seen by DVL: said {area}, true {least:.1f} to {most:.1f}"]
        )
    true = dive.seen_area(sensor)
    return unlike(f"area seen by {sensor}", area, true, AREA_SHARE * true)


def _region(dive, _, along_low, along_high, girth_low, girth_high, area, *seen):
    """Of each sensor its area and share with sigmas, in the order of the table's columns."""
    on = dive.within((value(along_low), value(along_high)), (value(girth_low), value(girth_high)))
    whole = dive.views.steel.area[on].sum()
    out = unlike("area of a region", area, whole, AREA_SHARE * whole)
    for k, sensor in enumerate(("camera", "sonar", "DVL")):
        said, sigma, share, share_sigma = seen[4 * k : 4 * k + 4]
        if said is None:
            out += [f"{sensor} was carried"] if dive.carried(sensor) else []
            continue
        least, most = dive.seen_by_dvl(on) if sensor == "DVL" else [dive.seen_area(sensor, on)] * 2
        for what, number, its_sigma, unit in (
            ("area", said, sigma, 1.0),
            ("share", share, share_sigma, 100 / whole),
        ):
            true = np.clip(value(number), unit * least, unit * most)
            allowed = 3 * (value(its_sigma) + half_digit(its_sigma)) + AREA_SHARE * unit * most
            out += unlike(f"{what} of a region seen by {sensor}", number, true, allowed)
    return out


def _area_of(dive, said, sensor, area):
    return _area(dive, said, area, sensor)


def _uncertain_area(dive, _, area, sigma, sensor):
    return beyond(f"area seen by {sensor}", area, sigma, dive.seen_area(sensor))


def _uncertain_area_of(dive, said, sensor, area, sigma):
    return _uncertain_area(dive, said, area, sigma, sensor)


def _area_twice(dive, _, area):
    return unlike("area seen twice", area, dive.seen_twice, AREA_SHARE * dive.seen_twice)


def _percentiles(name, share, least):
    def judge(dive, _, middle, low, high):
        out = []
        for said, true in zip((low, middle, high), dive.seen_percentiles(name), strict=True):
            out += unlike(name, said, true, share * true + least)
        return out

    return judge


def _hole_numbers(dive, least):
    """Between which numbers of holes of at least that size there truly are."""
    if dive.images:
        return [len(dive.holes(least))] * 2
    return [len(holes) for holes in dive.holes_of_dvl(least)]


def _holes(dive, _, count, least):
    fewest, most = _hole_numbers(dive, value(least))
    return [] if fewest <= int(count) <= most else [f"holes: said {count}, true {fewest} to {most}"]


def _some_hole(dive, _, least):
    return [] if _hole_numbers(dive, value(least))[1] else [f"no hole is larger than {least} m²"]


def _bay(_, __, side):
    return unlike("bay", side, BAY_M)


def _hole(dive, _, *numbers):
    """The hole that is nearest in size is of that size."""
    area, holes = (
        numbers[-1],
        dive.holes(0.0)
        if dive.images
        else [hole for few in dive.holes_of_dvl(0.0) for hole in few],
    )
    return unlike(
        "hole", area, min(holes, key=lambda hole: abs(hole - value(area)), default=0.0), 0.02
    )


def _no_hole(dive, _, least):
    hole = max(dive.holes(0.0) if dive.images else dive.holes_of_dvl(0.0)[0], default=0.0)
    return (
        []
        if hole < value(least) + 0.01
        else [f"no hole of more than {least} said, true {hole:.3f}"]
    )


def _resolution(dive, _, name, step):
    return unlike(f"pixel of the {name} mosaic", step, 1000 * dive.pixel_m(name.lower()))


def _gaps(dive, said, area):
    name = said.words.split(":")[0].lower()
    return unlike("gaps", area, dive.mosaic_gaps(name), 0.25 * dive.mosaic_gaps(name))


def _plan(dive, _, along, girth):
    low, high = dive.seen_extent
    out = (
        []
        if high[0] - low[0] - 0.1 < value(along) < high[0] - low[0] + 2
        else [f"plan {along} m along, seen {low} {high}"]
    )
    return out + (
        []
        if high[1] - low[1] - 0.1 < value(girth) < high[1] - low[1] + 2
        else [f"plan {girth} m, seen {low} {high}"]
    )


def _frame_tick(dive, _, metres, frame):
    return unlike("frame", frame, value(metres) / dive.frame_spacing_m)


def _landmarks(dive, _, count, *share):
    out = unlike("landmarks", count, dive.landmark_count)
    if share and share[0]:
        low, high = dive.share_on_cad_model
        out += unlike("on the CAD model", share[0], 0.5 * (low + high), 0.5 * (high - low))
    return out


# The run


# of median and tails: said of flat ground, and of the path known before the adjustment
OVERLAP_PERCENT = (3.0, 6.0, 6.0)


def _overlap(across):
    def judge(dive, _, pairs, matched, *overlap):
        compared, joined, true = dive.overlaps(across)
        out = unlike("pairs", pairs, compared) + unlike("matched", matched, joined)
        for said, real, allowed in zip(
            overlap, (true[1], true[0], true[2]), OVERLAP_PERCENT, strict=False
        ):
            out += unlike("overlap", said, real, allowed) if said else []
        return out

    return judge


def _residuals(name, sigma, unit):
    def judge(dive, _, count, robust, rms, share):
        found, scale = dive.adjust["residuals_after"][name], unit * dive.adjust["sigmas"][sigma]
        out = unlike(f"{name} residuals", count, found["count"])
        out += unlike(f"{name} rms", rms, scale * found["rms"], 0.05 * scale * found["rms"])
        out += unlike(
            f"{name} robust",
            robust,
            scale * found["robust_sigma"],
            0.05 * scale * found["robust_sigma"],
        )
        return out + unlike(f"{name} beyond 3", share, 100 * found["share_beyond_3"])

    return judge


def _sensor(dive, _, name, error, sigma):
    return beyond(name, error, sigma, dive.sensor_errors[name])


def _time_of_step(dive, _, step, minutes, seconds, memory):
    run = dive.step_runs[step]
    out = unlike(f"time of {step}", _seconds(minutes, seconds), run["seconds"])
    return out + unlike(f"memory of {step}", memory, run["peak_rss_bytes"] / 1e6)


def _time(dive, _, minutes, seconds, steps):
    others = [run for name, run in dive.step_runs.items() if name != "report"]
    spans = sorted((run["started"], run["started"] + run["seconds"]) for run in others)
    begins, ends = np.array(spans).T
    # a step beside another one counts from where all before it have ended
    last = np.maximum.accumulate(np.r_[begins[0], ends[:-1]])
    total = np.maximum(ends - np.maximum(begins, last), 0).sum()
    return unlike("time", _seconds(minutes, seconds), total) + unlike("steps", steps, len(others))


def _warnings(dive, _, count):
    return unlike("warnings", count, len(dive.warnings))


def _no_pdf(dive, _):
    written = (dive.run / "deliver" / "report" / "report.pdf").exists()
    return ["a PDF is missing, and there is one"] if written else []


def _ranges_rejected(dive, _, rejected, of):
    return unlike("ranges", of, dive.ranges) + unlike(
        "rejected ranges", rejected, dive.ranges_flagged
    )


def _unsure_clock(dive, _, sensor, late_s, shift_mm):
    """The simulated clocks agree; the shift is that of the true way, of its depth alone for one."""
    way = dive.way_within(value(late_s))
    way = way[:, 2:] if sensor == "pressure" else way - way[0]
    true = 1000 * np.linalg.norm(way, axis=1).max()
    return unlike(f"shift by the {sensor}'s clock", shift_mm, true, 0.3 * true)


def _pairs_failed(dive, _, reason, count):
    """The page's table of compared pairs says how many failed in all."""
    return (
        []
        if 0 < int(count) <= dive.pairs_without_pose
        else [f"{reason}: {count} of {dive.pairs_without_pose} pairs"]
    )


def _observations(dive, _, rejected, of):
    return unlike("rejected", rejected, dive.adjust["observations_left_out"]) + unlike(
        "observations", of, dive.adjust["observations_left_out"] + dive.adjust["observations"]
    )


def _not_reported(dive, _, height, sigma, address):
    """No structure that is due stands where a region was examined and refused."""
    known = [
        r
        for r in dive.regions_refused
        if r["address"] == address and unlike("", height, r["height"]) == []
    ]
    if not known:
        return [f"no region was refused at {address}"]
    near = min(dive.nearest_structure_m(np.array(r["center"])) for r in known)
    return [] if near > 0.15 else [f"a structure {near:.2f} m from {address} is called none"]


def _looked_for(_, __, height_mm, area_cm2, views, p_value):
    least = DetectOptions()
    wanted = (1e3 * least.min_height_m, 1e4 * least.min_area_m2, least.min_views, least.max_p_value)
    said = zip((height_mm, area_cm2, views, p_value), wanted, strict=True)
    return [complaint for number, true in said for complaint in unlike("looked for", number, true)]


def _examined(dive, _, count):
    return unlike("regions examined", count, len(dive.regions_refused))


def _title(dive, _, number, title):
    return unlike(title, number, dive.titles.index(title) + 1)


def _section(dive, _, number):
    return (
        []
        if dive.titles[int(number) - 1] == "Objects on the hull"
        else ["another section holds the objects"]
    )


def _shown(dive, _, some, of):
    return unlike("shown", some, len(dive.objects)) + unlike("of", of, len(dive.objects))


def _date(dive, _, date):
    return [] if date == dive.date else [f"date {date}: true {dive.date}"]


def _true(*_):
    """Of a number that says nothing of the dive: the length of a scale bar, a bound, a name."""
    return []


TITLES = (
    "Map of the hull|The hull in 3-D|Objects on the hull|Deviation from the CAD "
    "model|Mosaics|Coverage|Position uncertainty|"
    "Quality of the data|Rejected data and warnings|Record|Appendix: plots"
)
LENGTH = rf"{N} (mm|m)"
METRES = rf"{N}(?: ± {N})? m"
ADDRESS = (
    rf"(?:frames? ({NUMBER}(?: to {NUMBER})?) \()?{METRES} (?:from AP|along)\)?, "
    rf"(?:(port|starboard|keel)(?:, |\b))?"
    rf"(?:{METRES} (?:girth from keel|across))?(?:, {METRES} (?:below|above) waterline)?"
)
SEEN = rf"(?:{WITH_SIGMA} m² \({WITH_SIGMA} %\)|not carried)"
TIME = r"(?:(\d+) min )?(\d+) s"
TABLE = (
    # what a pattern covers is gone for those after it
    (rf"^(\d+) ({TITLES})$", _title),
    (r"of section (\d+)\.", _section),
    (r"(\d\d \w+ \d{4}, \d\d:\d\d UTC)", _date),
    (
        rf": {TIME}, {N} m of path, {N} poses(?:, {N} images? from (\d) cameras?|, without a "
        rf"camera)\.",
        _dive,
    ),
    (rf"median one sigma in x / y / z: {N} / {N} / {N} (mm|m)\.", _median_sigmas),
    (
        rf"The position (along the hull|across the hull|vertically) is uncertain by {N} m \(one "
        rf"sigma\)",
        _weak_position,
    ),
    (
        rf"The (heel|trim|heading) of the hull is uncertain by {N} degrees \(one sigma\)",
        _weak_attitude,
    ),
    (
        rf"The position in ([xyz]) of the local frame is uncertain by {LENGTH} \(one sigma\)",
        _weak_axis,
    ),
    (
        rf"known to {LENGTH} along the (?:hull|survey) and {LENGTH} (?:in girth|across it) \(one "
        rf"sigma, median\)",
        _vehicle_place,
    ),
    (rf"^± {LENGTH} ± {LENGTH} (?:in girth|across), one sigma", _vehicle_place),
    (rf"one sigma of the vehicle: {N} m along, {N} m (?:in girth|across)", _vehicle_place_m),
    (rf"A pixel's position on the hull is known to {N} mm \(one sigma\)", _pixels_place),
    (
        rf"(\d+) objects? found on the hull \(([^)]*)\); the largest, no\. (\d+), has a height "
        rf"of {WITH_SIGMA} m",
        _objects,
    ),
    (
        rf"Looked for: what is at least {N} mm high or deep, {N} cm² large, shown by {N} "
        rf"images?, and bare hull with a"
        rf" probability below {N}",
        _looked_for,
    ),
    (r"(\d+) regions? examined and not reported", _examined),
    (r"^(\d+) on the hull$", _count_of_objects),
    (r"hull seen, (\d+) objects?", _count_of_objects),
    (r"(\d+) of (\d+) shown", _shown),
    (
        rf"^(?:only|bare hull does so with probability) [^(]*\(height {WITH_SIGMA} m, (.*)\)$",
        _not_reported,
    ),
    (rf"{ADDRESS}, {N} m²$", _hole),
    (r"(\d+) holes? of more than (0\.\d+) m² in the coverage", _holes),
    (r"^Holes of more than (0\.\d+) m²$", _some_hole),
    (r"^A bay of the outline counts as a hole if a square of (0\.\d+) m fits into it\.$", _bay),
    (rf"(?:Object (\d+): height {WITH_SIGMA} m, )?{ADDRESS}", _address),
    (r"^(\d+)(?: \| show)? (?:\||·) (protrusion|recess|Protrusion|Recess)", _kind),
    (
        rf"(?<=\| ){WITH_SIGMA} m \| {WITH_SIGMA} cm² \| {WITH_SIGMA} m \| {WITH_SIGMA} m(?: \| "
        rf"{WITH_SIGMA} m)?(?= \| <)",
        _row,
    ),
    (rf"^Height above the hull around it \| {WITH_SIGMA} m$", _of_object("height")),
    (
        rf"^Extent along the hull, in girth \| {WITH_SIGMA} m × {WITH_SIGMA} m$",
        _of_object("extent along", "extent in girth"),
    ),
    (rf"^Area, volume \| {WITH_SIGMA} cm², {WITH_SIGMA} l$", _area_and_volume),
    (rf"^Largest distance to the CAD model \| {WITH_SIGMA} m$", _of_object("deviation")),
    (rf"^Along, (?:girth|across) \| {WITH_SIGMA} m, {WITH_SIGMA} m$", _of_object("along", "girth")),
    (rf"^Depth below the water surface \| {WITH_SIGMA} m$", _of_object("depth")),
    (
        rf"^Centre \(x, y, z\) \| {WITH_SIGMA}, {WITH_SIGMA}, {WITH_SIGMA} m in [Mg]$",
        _of_object("x", "y", "z"),
    ),
    (r"^More than half of its top seen in \| (\d+) views?$", _views),
    (r"^False-alarm probability, anywhere in the survey \| (< 0\.0001|0\.\d+)$", _alarm),
    (r"(?<=\| )(< 0\.0001|0\.\d{4})(?= \|)", _alarm),
    (rf"Outline beyond which nothing was measured \| {N} %", _true),
    (r"^camera_(top|bottom), image (\d+), (\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{3}) UTC$", _image),
    (r"Object (\d+) in an image of camera_(?:top|bottom), with its outline\.", _object_number),
    (rf"{N} to {N} mm \(5th to 95th percentile; one sigma {N} mm\)", _form),
    (rf"^{N} to {N} mm one sigma {N} mm", _form),
    (rf"from its CAD model by {N} to {N} mm", _true),
    (
        rf"lies {N} mm (inside|outside|from) it \(one sigma {N} mm(, not significantly different "
        rf"from zero)?\)",
        _offset,
    ),
    (rf"^Offset of the surveyed patch \| {WITH_SIGMA} mm$", _signed_offset),
    (
        rf"^Tilt of the surveyed patch, along / in girth \| {WITH_SIGMA} / {WITH_SIGMA} mm per m$",
        _tilt,
    ),
    (rf"tells the CAD model's proportions and scale to {N} % \(one sigma\)", _proportions),
    (
        rf"hold for a speed of sound that is right to {N} % \(dvl\.scale_sigma\): set for sea "
        rf"water, a DVL measures {N} % too long in fresh water",
        _lengths,
    ),
    (
        rf"hull\.stl: {N} faces, {N} x {N} x {N} m, from \({N}, {N}, {N}\) to \({N}, {N}, {N}\)",
        _cad_model,
    ),
    (r"(\d+) degenerate faces? (?:was|were) removed", _degenerate),
    (r"(\d+) duplicate faces? (?:was|were) removed", _duplicate),
    (r"the mesh is not watertight: (\d+) boundary edges?", _boundary),
    (rf"{WITH_SIGMA} m² by (sonar)", _uncertain_area),
    (rf"{N} m² by (camera|sonar|DVL)", _area),
    (rf"^(?:Hull|Measured surface) seen by (camera|sonar|DVL) \| {N} m²$", _area_of),
    (rf"^Hull seen by (sonar) \| {WITH_SIGMA} m²$", _uncertain_area_of),
    (rf"^[^|]+ \| {N} to {N} m \| {N} to {N} m \| {N} m² \| {SEEN} \| {SEEN} \| {SEEN}$", _region),
    (rf"^(?:Hull|Measured surface) seen at least twice by camera \| {N} m²$", _area_twice),
    (
        rf"^Ground sample distance, camera \| {N} mm \(5th to 95th percentile {N} to {N} mm\)$",
        _percentiles("gsd", 0.02, 0.0),
    ),
    (
        rf"^Incidence angle of the best view, camera \| {N}° \(5th to 95th percentile {N} to "
        rf"{N}°\)$",
        _percentiles("incidence", 0.03, 0.5),
    ),
    (
        rf"^Views per point, camera \| {N} \(5th to 95th percentile {N} to {N}\)$",
        _percentiles("views", 0.0, 1.0),
    ),
    (r"No hole of more than (0\.\d+) m² was found", _no_hole),
    (rf"(optical|sonar) at {N} mm per pixel", _resolution),
    (rf"^(Optical|Sonar): {N} mm a pixel", _resolution),
    (rf"Gaps inside its outline: {N} m²", _gaps),
    (rf"{N} m along by {N} m (?:girth|across)", _plan),
    (rf"(?<=\| ){N} m \| fr {N}(?= \|)", _frame_tick),
    (
        rf"{N} landmarks were measured in the images(?:, {N} % of them taken to lie on the CAD "
        rf"model's surface)?",
        _landmarks,
    ),
    (
        rf"^Neighbours along the track \| {N} \| {N} \| (?:{N} % \({N} to {N} %\)|–)$",
        _overlap(across=False),
    ),
    (
        rf"^Images of other legs \| {N} \| {N} \| (?:{N} % \({N} to {N} %\)|–)$",
        _overlap(across=True),
    ),
    (
        rf"^Features seen by both cameras \| {N} \| {N} px \| {N} px \| {N} %$",
        _residuals("stereo", "pixel_px", 1.0),
    ),
    (
        rf"^Features seen by one camera \| {N} \| {N} px \| {N} px \| {N} %$",
        _residuals("mono", "pixel_px", 1.0),
    ),
    (rf"^DVL ranges \| {N} \| {N} mm \| {N} mm \| {N} %$", _residuals("range", "range_m", 1e3)),
    (
        rf"^(Scale error of the DVL's velocities|Drift of the heading|Bias of \w+|Bias of the "
        rf"depth) \| {N} ± {N}[^\d|]*$",
        _sensor,
    ),
    (rf"^([a-z-]+) \| {TIME} \| {N} MB$", _time_of_step),
    (rf"^Time and memory by step: {TIME} for (\d+) steps", _time),
    (r"(\d+) warnings? (?:was|were) raised", _warnings),
    (rf"{N} of {N} DVL ranges rejected as outliers", _ranges_rejected),
    (
        rf"(pressure|DVL): that its clock agrees with the IMU's is known to {N} s \(one sigma\), "
        rf"which moves the path by up to {N} mm",
        _unsure_clock,
    ),
    (r"^report/report\.pdf: Pango is not installed .*$", _no_pdf),
    (r"^([a-z ]+): (\d+) pairs?$", _pairs_failed),
    (rf"{N} of {N} image observations rejected as outliers", _observations),
    # numbers that say nothing of the dive: percentiles' names, dimensions, scale bars, ticks of an
    # axis, marks on the plan
    (r"5th to 95th percentile|Beyond 3 sigmas|\b3-D\b", _true),
    (r"(?<=\| )-?\d+(?:\.\d+)? m(?= \||$)", _true),
    (r"(?<= \| )\d+(?= \|)", _true),
)


def untrue(dive, found):
    """Complaints about a statement's numbers: those that are not true, and those that no pattern
    covers.
    """
    words, complaints = found.words.replace(dive.vessel, "the ship").replace(dive.name, "it"), []
    for pattern, judge in TABLE:
        for match in re.finditer(pattern, words):
            complaints += judge(dive, found, *match.groups())
        words = re.sub(pattern, "covered", words)
    rest = re.findall(r"\S*\d\S*", words)
    return complaints + (
        [f"nothing says what would make these true: {rest} in: {found.words}"] if rest else []
    )
