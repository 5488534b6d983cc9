# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words: what was read of a dive's logs, what was lost, and what was assumed or corrected.

Functions here take the values of a finding by name and return its sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

# a template for str.format, or a function where the sentence depends on the values
Words = str | Callable[..., str]


LACKING = {"logs.time_zone": "time zone", "dive.date": "day"}  # by the key that says it
COUNTED = {"logs.time_zone": "in UTC", "dive.date": "from 1970-01-01"}
YEAR_S = 365.25 * 86400.0


def count_noun(count: int, noun: str) -> str:
    """Return count and noun, the noun in the plural unless the count is 1."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _read(count: int, noun: str, seconds: float, start: str, rate_hz: float | None) -> str:
    rate = "" if rate_hz is None else f", {rate_hz:.1f} Hz"
    return f"{count_noun(count, noun)} in {seconds:.1f} s from {start}{rate}"


def _positions(north_m: float, east_m: float, sigma_m: Sequence[float], single: bool) -> str:
    """Describe the extent of position fixes, and their least and greatest sigma."""
    low, high = sigma_m
    sigma = f"sigma {low:.2g} m"
    if abs(high - low) > 1e-8 + 1e-5 * abs(high):
        sigma = f"sigmas from {low:.2g} to {high:.2g} m"
    alone = "; one alone tells nothing of the path" if single else ""
    return (
        f"positions from outside span {north_m:.1f} m north and {east_m:.1f} m east, {sigma}{alone}"
    )


def _lost(topic: str, start: str | None, end: str | None, messages: int | None, why: str) -> str:
    """Say what part of a topic is lost, and why.

    topic: empty for all of them. start, end: times, None at an end of the log. messages: how many,
    None where that is not known.
    """
    span = "an unknown part is"
    if start or end:
        first = f"from {start}" if start else "from the start"
        span = f"{first} {f'to {end}' if end else 'to the end'} is"
    many = f" ({count_noun(messages, 'message')})" if messages is not None else ""
    return f"{topic or 'every topic'}: {span} lost{many}: {why}"


def _far(count: int, time: str) -> str:
    """Say that readings far from all others were left out. time: stamp of the first."""
    many = "reading was" if count == 1 else "readings were"
    first = "as" if count == 1 else "the first as"
    return f"{count} {many} left out, stamped a day or more from all others, {first} {time}"


def _jumps(seconds: float, time: str, more: int, corrected: int, set_back: bool) -> str:
    """Say that a clock jumps, and what was done.

    seconds, time: of the first jump. more: number of other jumps. corrected: number of stamps
    that were put right. set_back: as after a clock that was set back, else by the logger's clock.
    """
    again = f", and {more} more times" if more else ""
    by = "as if it had been set back" if set_back else "by the logger's clock"
    done = f"{corrected} stamps were put right {by}"
    if not corrected:
        done = "stamps around it cannot be trusted"
    return f"the clock jumps by {seconds:+.3f} s at {time}{again}; {done}"


def _marked_lost(
    huge: int,
    zero: int,
    repeated: int,
    unheard: int,
    limit_m_s: float,
    start: str,
    seconds: float,
) -> str:
    """Say why velocities were taken as lost, with their number for each reason, and when."""
    parts = [f"{huge} have a sigma of {limit_m_s:g} m/s or more"] if huge else []
    parts += [f"{zero} are exactly zero, unlike those around them"] if zero else []
    parts += [f"{repeated} repeat the last one exactly"] if repeated else []
    parts += [f"{unheard} come while no beam has a range"] if unheard else []
    return (
        f"velocities were taken as lost, the first at {start}, the last {seconds:.1f} s later: "
        f"{' and '.join(parts)}"
    )


def _in_bursts(count: int, bursts: int, within_s: float | None) -> str:
    """Describe stamps in bursts. within_s: to which they are known once spread, else None."""
    done = "the times of logging were taken, which come one by one"
    if within_s is not None:
        done = (
            "they were spread evenly over the time from one burst to the next, and are known to "
            f"some {within_s:.2g} s"
        )
    return (
        f"its {count} stamps come in {bursts} bursts, as a computer received the readings or as a "
        f"coarse clock showed, not as they were measured: {done}"
    )


def _of_dvl(sensor: str, count: int) -> str:
    """Say that readings by a DVL's own IMU or pressure sensor, `sensor`, were ignored."""
    what, other = ("attitudes", "the IMU") if sensor == "imu" else ("depths", "the pressure sensor")
    return f"{count} {what} by the DVL's own sensors were ignored, as {other} was logged"


def _rotator(turned_deg: Mapping[str, float]) -> str:
    moved = ", ".join(f"{axis} by {degrees:.0f} degrees" for axis, degrees in turned_deg.items())
    return f"its rotator turned ({moved}), which is not read"


def duration(seconds: float) -> str:
    """Write a time in the unit that suits it: 18.0 s, 2.0 h, 56.3 years."""
    units = ((YEAR_S, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min"))
    for size, unit in units:
        if abs(seconds) >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def names(sensors: Sequence[str]) -> str:
    """List sensors as in a sentence."""
    *most, last = sensors
    return f"{', '.join(most)} and {last}" if most else last


def _joined(count: int, seconds: float, others: Sequence[str], spread_s: float | None) -> str:
    """Say that stamps on a time base of their own were put onto that of others.

    spread_s: of the offset of stamps and logging times, None where it jumps: then each stamp was
    moved by the offset at its moment.
    """
    side = "behind" if seconds > 0 else "ahead of"
    spread = "by the offset of that moment" if spread_s is None else f"spread {spread_s:.3f} s"
    return (
        f"by when they were logged, {count_noun(count, 'stamp')} are {duration(abs(seconds))} "
        f"{side} those of {names(others)} ({spread}); they were put onto that time base"
    )


_SONAR_FILE = (
    "has no checksums; stamps are those of the computer that recorded it, taken as UTC "
    "(sonar.time_offset corrects its clock); beams are those of a sonar that stands upright (one "
    "upside down has roll 180 in sonar.mount); heading, tilts"
)

NOTES: dict[str, Words] = {
    # what was read
    "stream-read": _read,
    "stream-silent": "nothing for {seconds:.1f} s from {start} to {end}",
    "stream-more-gaps": "{count} more gaps, shorter",
    "stream-late": "begins {seconds:.1f} s after the log does",
    "stream-early": "ends {seconds:.1f} s before the log does",
    "depth-span": "depth runs from {low_m:.1f} to {high_m:.1f} m",
    "range-span": "DVL ranges run from {low_m:.2f} to {high_m:.2f} m",
    "speed-span": "DVL speeds reach {high_m_s:.2f} m/s",
    "position-span": _positions,
    "angle-span": "{joint} angles run from {low_deg:.1f} to {high_deg:.1f} degrees",
    "first-image": "the first camera image is {seconds:.1f} s {side} the first DVL ping",
    "data-lost": _lost,
    # stamps
    "stamps-doubled": "{doubled} of {count} stamps are duplicates; the first of each was kept",
    "readings-twice": "{copies} of {count} readings stand in the log once more, with the same "
    "stamp and values; they were left out",
    "readings-republished": "{repeated} of {count} readings repeat the one before to the last "
    "digit, as evenly as a driver that publishes each several times with new stamps; the first of "
    "each was kept",
    "stamps-unordered": "{count} readings stood out of order and were sorted",
    "stamps-far": _far,
    "rates-unfilled": "all {count} angular velocities are zero while the orientation turns: they "
    "were not filled in, and are left out",
    "accelerations-unfilled": "all {count} accelerations are zero: they were not filled in, and "
    "are left out",
    "gravity-taken-off": "its accelerations have gravity taken off (their median is "
    "{felt_m_s2:.2g} m/s2); it was added again by the orientation",
    "accelerations-in-unit": "half of its accelerations are {median:.3g} and more, as gravity in "
    "{unit}: they were converted to m/s2",
    "stamps-in-bursts": _in_bursts,
    "logged-late": "{count} readings were logged late, by up to {seconds:.1f} s, the first at "
    "{time}; their stamps were kept",
    "logs-overlap": "logs were read in another order than they were recorded, or overlap: "
    "{seconds:.1f} s back to {time}; their readings were sorted",
    "clock-jumps": _jumps,
    "time-base-joined": _joined,
    "clock-drifts": lambda per_million: (
        f"by when they were logged, its clock runs {abs(per_million):.0f} millionths "
        f"{'fast' if per_million > 0 else 'slow'}; its stamps were put right"
    ),
    "stamps-fall-behind": "its stamps fall evenly behind when they were logged, by {seconds:.2f} s "
    "over the log: its clock is slow, or its messages waited longer and longer; they were kept",
    # streams of one sensor
    "readings-not-finite": "{lost} of {count} readings are no finite numbers, or marked as lost, "
    "and were left out",
    "ranges-all-lost": "every range is lost; it measures no distance to the hull",
    "velocities-absurd": "{count} velocities above {limit_m_s:.0f} m/s were taken as lost",
    "velocities-not-over-ground": "{lost} of {count} velocities are {what}, not over ground along "
    "the DVL's axes: they are not used",
    "velocities-marked-lost": _marked_lost,
    "velocity-sigmas-useless": "every velocity has a sigma of {least_m_s:.2g} m/s or more, which "
    "says nothing of it; dvl.sigma_velocity was used",
    "ranges-at-limit": "{count} ranges are exactly {limit_m:g} m, the others {next_m:.2f} m at "
    "most: they were taken as lost",
    "depths-above-water": "{lost} of {count} readings lie {limit_m:g} m or more above the water "
    "and were left out",
    "quaternions-scaled": "its quaternions are all {length:.5g} long, as in an instrument's whole "
    "numbers: they were scaled to 1",
    "quaternions-completed": "the w of its quaternions is {w:g} in all {count} messages; x, y and "
    "z turn as the rates do where they are {form}, and were read so",
    "attitudes-lacking": "{lacking} of {count} readings have no attitude and were left out",
    "attitudes-held": "{held} readings repeat the one before for more than a second, the first at "
    "{start}: the IMU or its driver stood still, and they were left out",
    "depths-spikes": "{spikes} of {count} readings lie farther from those around them than a "
    "vehicle sinks meanwhile and were left out",
    "beams-inward": "the beams in the messages point into the instrument; those of dive.toml were "
    "taken",
    "heading-of-rates": "its heading is the integral of the rates, about which that of the "
    "orientation swings by {swing_deg:.2g} degrees (root mean square). They drift by "
    "{drift_deg_h:.0f} degrees an hour, which was taken off. What is left is known to "
    "{sigma_deg_h:.0f} degrees an hour: imu.heading_drift_deg_per_hour states it",
    "attitude-of-dvl": "attitude comes from the DVL's own sensors; a compass near a steel hull can "
    "be off by tens of degrees, which imu.heading_drift_deg_per_hour has to cover",
    "depth-of-dvl": "depth comes from the DVL's own sensor; pressure.origin is that sensor's",
    "dvl-sensors-ignored": _of_dvl,
    "angles-in-degrees": "angles reach {largest_rad:.1f} rad; are they in degrees (give "
    'sonar.joint_unit = "deg" then)?',
    "angles-wrap": "its angles jump by a whole turn {jumps} times, as where they are counted from "
    "0 to 360 degrees: they were joined",
    "joint-absent": "no reading of {joint} is in the log; it is taken as fixed at 0 degrees",
    "joint-before-window": "at the start of the time window as last read, at {time}",
    # the DVL's beams
    "beams-of-type": "the messages have no beam directions; those of a {instrument} were used",
    "beams-off-axis": "beams stand up to {degrees:.0f} degrees off the z axis of dvl: are they "
    "right?",
    "beams-leaning": "the beams' mean direction is {degrees:.0f} degrees off the z axis of dvl: "
    "are they right?",
    "beams-against-altitude": "along these beams the ranges reach {percent:.0f} % {side} than the "
    "altitude that the DVL computed: are the beams' directions right?",
    "ranges-in-unit": "its ranges are in {unit}, not in m: so they fit the altitude that it "
    "computed; they were put right",
    "ranges-along-axis": "its ranges are distances along its axis, not along the beams: so they "
    "fit the altitude that it computed; they were put right",
    "ranges-unconfirmed": "its table has no altitude, which would tell ranges along the beams from "
    "distances along its axis: they were taken along the beams. Without a camera positions on the "
    "hull are known to {percent:.0f} % of a range (one sigma); a column altitude, in m, tells",
    "ranges-alike": "all beams have one range in each of {count} pings, as where a driver writes "
    "the altitude for all: they were left out",
    "beam-stands-still": "beam {beam} reads {low_m:.2f} to {high_m:.2f} m, while the hull in the "
    "others comes and goes by {others_m:.2f} m: it hears itself or the vehicle, and was left out",
    "beams-change": "the beams' directions change during the dive; their mean was used",
    "beams-unlike-toml": "the beams of dive.toml are up to {degrees:.1f} degrees off those of the "
    "messages, which were used",
    # sonar
    "sonar-other-windows": "{others} of {count} pings have another range or number of beams than "
    "{beams} beams to {range_m:.1f} m and were left out",
    "sonar-other-fans": "the beams of {others} of {count} pings point elsewhere, as in another "
    "mode of the sonar, than those of the others; they were left out",
    "sonar-other-ranges": "{others} of {count} pings have ranges that differ by up to "
    "{differ_mm:.0f} mm, as by another speed of sound, and were put onto one",
    "sonar-azimuths-unused": "the log says where the beams point; sonar.beam_azimuth_deg was not "
    "used",
    "sonar-bytes-exchanged": "the bytes of its pixels stand in the other order than the log says: "
    "exchanged, neighbours differ {smoother:.1f} times less, and so they were read",
    "sonar-black": "no pixel of any ping is above zero: its mosaic will be black",
    "sonar-scaled": "{dtype} pixels were scaled to 8 bits, {white:g} and more to 255",
    # positions
    "positions-without-fix": "{lacking} of {count} messages have no fix and were left out",
    "positions-other-form": "{others} of {count} fixes are not of the form of the first (latitude "
    "and longitude, or metres) and were left out",
    "positions-under-water": "{drowned} of {count} GPS fixes are of a vehicle deeper than "
    "{deepest_m:g} m, where no antenna receives: they are not used; acoustic positions of this "
    'type are, with position.source = "acoustic"',
    # images
    "images-bad": "{bad} of {count} images are missing or damaged and are left out",
    "images-mosaic": "{mosaics} of {count} images are Bayer mosaics stored as gray pictures: they "
    "are used as they are, without colours",
    "images-repeated": "{repeated} of {count} images repeat the one before to the last byte, as no "
    "camera sees twice; they were left out",
    "images-other-size": "{others} of {count} images have another size and are left out",
    "pictures-turned": "its pictures are to be shown {turn}; they are read as the sensor stored "
    "them, and the calibration has to be one of such pictures",
    "images-deep": "its images have 16 bits with values up to {largest}; the upper 8 of {bits} "
    "bits are used",
    "calibration-of-log": "its calibration is the CameraInfo on {topic}; see that it is that of "
    "the camera in water",
    # topics
    "topic-lost": "nothing of {topic} is left in the damaged log",
    "messages-unusable": "{count} messages could not be used: {why}",
    "messages-unstamped": "{count} messages have no stamp; their logging time was used",
    "outside-window": "only what was measured {window} is used; {count} readings were ignored",
    "readings-ignored": "its {count} readings were ignored, as topics.{sensor} is set",
    # files: ROS bags and MCAP
    "bag-no-index": "the bag has no usable index (was its recording cut short?): it was read from "
    "its start",
    "bag-no-checksum": "chunks of the bag carry no checksum: damage inside them may go unseen",
    "mcap-no-summary": "the MCAP's summary is damaged or does not fit its records: whole chunks "
    "may be missing",
    "mcap-no-checksum": "chunks of the MCAP carry no checksum: damage inside them may go unseen",
    "mcap-no-end": "the MCAP has no closing records: its recording or its copy was cut short",
    "mcap-chunk-kind": "the record at byte {byte} is a chunk whose kind is damaged; it was read "
    "all the same",
    "mcap-private": "{count} records of a private kind were ignored",
    "database-no-checksum": "the database carries no checksums: damage inside its messages may go "
    "unseen",
    "database-journal": "a journal lies beside the database: its last transaction was not finished",
    "database-rows-missing": "{count} row numbers are missing: rows were deleted, or lost by "
    "damage",
    "database-wal": "the write-ahead log beside the database was read with it",
    "folder-by-name": "{why}; the folder's files were read by name",
    # files of instruments and tables
    "table-empty": "it has a header and no row",
    "stamps-open": lambda lacks: (
        f"its stamps tell no {' and no '.join(LACKING[key] for key in lacks)}, and are counted "
        f"{' and '.join(COUNTED[key] for key in lacks)} here"
    ),
    "columns-not-read": "columns that are not read: {columns}; read are {read}",
    "pictures-unnamed": "{what} are not read: {remedy}",
    "tables-not-read": "not read: {files}; the tables of sensors are {tables}",
    "pd0-no-bottom": "no ensemble has a bottom track (a current profiler's file?): it gives no "
    "velocity over ground",
    "pd0-read": "velocities in {frames} coordinates were turned into the frame dvl (x to beam 3); "
    "ranges along the axis were divided by the cosine of the beam angle; the instrument's clock "
    "was taken as UTC",
    "ad2cp-not-tracked": "no bottom track of it is valid: it gives no velocity over ground",
    "ad2cp-no-bottom": "no bottom-track record was read from it (a current profiler's file?): it "
    "gives no velocity over ground",
    "ad2cp-no-beams": "{count} velocities along the beams were lost: the file does not say where "
    "its beams point (the configuration at its start is missing)",
    "ad2cp-no-attitude": "{count} velocities east, north, up were lost: their records have no "
    "attitude of the z axis",
    "ad2cp-df20": "distances and figures of merit of its bottom tracks (DF20) were ignored, as no "
    "public document says whether those are along the beams or along z, and in which unit these "
    "are",
    "ad2cp-others": "{count} blocks of other kinds were passed over ({water_tracks} water tracks)",
    "ad2cp-read": "its frame dvl has Nortek's axes (z out of the transducers); its pressure was "
    "ignored; the instrument's clock was taken as UTC",
    "water-linked-timeless": "{count} reports have no time_of_validity (a protocol older than "
    "json_v3): they cannot be used",
    "water-linked-offset": "velocities were turned by the DVL's mounting rotation offset of "
    "{degrees:g} degrees, its ranges were not: add it to each of dvl.beam_azimuth_deg",
    "water-linked-no-offset": "its mounting rotation offset is not in the file: where it is not "
    "0, add it to each of dvl.beam_azimuth_deg",
    "oculus-others": "{count} items were passed over: they hold no ping with an image",
    "oculus-empty": "no ping of it could be read",
    "oculus-read": f"a log of ViewPoint {_SONAR_FILE} and depth in its pings were ignored",
    "aris-empty": "no frame of it could be read",
    "aris-kinds": "{kinds}",
    "aris-telephoto": "a telephoto lens narrows the aperture out of the fan: sonar.elevation_deg "
    "has to be that lens's",
    "aris-silent": "{count} frames were left out: the transmitter was off",
    "aris-rotator": _rotator,
    "aris-read": f"a file of an ARIS {_SONAR_FILE}, depth and position in its frames were ignored",
}
