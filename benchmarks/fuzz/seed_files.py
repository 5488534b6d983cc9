# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Small sound inputs that are no ROS logs: PD0, plain tables, pings, dive.toml, calibrations, CAD
models, images.
"""

from __future__ import annotations

import io
import json
import struct

import numpy as np

WIDTH, HEIGHT = 48, 32  # px, of the images and of the calibration
DIVE_TOML = """# a dive
[dive]
name = "tiny"
vessel = "a ship"
date = 2026-05-04T09:30:00Z
[logs]
files = ["logs"]
[topics]
dvl = "/dvl"
imu = "/imu"
[tray]
joint = "tray"
origin = [0.45, 0.0, 0.10]
sigma_deg = 0.8
[imu]
frame = "ned"
[pressure]
density = 1025.0
atmosphere = 101325
[dvl]
mount = [0.0, 0.0, 0.08, 0.0, 90.0, 0.0]
beam_angle_deg = 30.0
beam_azimuth_deg = [180, 0, 90, -90]
[camera.top]
calibration = "calibration/camera_top.yaml"
time_offset = 1e-3
[hull]
mesh = "hull.stl"
units = "m"
pose = [0.0, 0.0, 0.0, 180.0, 0.0, 0.0]
[adjust]
threads = 2
"""
LONG_DIVE_TOML = (
    DIVE_TOML
    + """
[camera.bottom]
calibration = "calibration/camera_bottom.yaml"
pose_in_top = [0.0, 0.3, 0.0, 0.0, 0.0, 0.0]
[sonar]
joint = "sonar_tray"
origin = [0.5, 0.0, -0.1]
mount = [0.0, 0.0, 0.0, 0.0, 90.0, 0.0]
elevation_deg = 14.0
"""
)
CALIBRATION = f"""image_width: {WIDTH}
image_height: {HEIGHT}
camera_name: top
camera_matrix:
  rows: 3
  cols: 3
  data: [50.0, 0.0, 23.5, 0.0, 51.0, 15.5, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [-0.1, 0.02, 0.001, -0.002, 0.003]}}
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
"""
SHORT_CALIBRATION = (
    f"{{image_width: {WIDTH}, image_height: {HEIGHT}, "
    "camera_matrix: [50, 0, 23.5, 0, 51, 15.5, 0, 0, 1]}"
)
TABLES = {
    "dvl": "t,vx,vy,vz,range_1,range_2,range_3,range_4\n1700000000,1,0,0,1,1,1,\n"
    "1700000001,1,0,0,2,2,2,2\n"
    "1700000002,1,0,0,2,2,2,2\n",
    "imu": "t,qx,qy,qz,qw,wx,wy,wz,ax,ay,az\n1700000000,0,0,0,1,0,0,0,0,0,-9.81\n"
    "1700000001.25,0,0,0,1,,,,,,\n"
    "1700000002,0,0,0,1,1,1,1,0,0,0\n",
    "pressure": "t,pascal\n1700000000,111380\n1700000001,111380.5\n1700000002,121435\n",
    "joints": "t,name,rad\n1700000000,tray,0.1\n1700000001,tray,0.2\n1700000000,fan,0.3\n",
    "camera_top": 't,file\n1700000000,a.png\n1700000001,"b.png"\n1700000002,a.png\n',
    "sonar": "t,file\n1700000000,p.npz\n1700000001,p.npz\n",
}


def pixels(seed: int) -> np.ndarray:
    """Return a smooth picture (h, w, 3) with some noise."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    noise = np.random.default_rng(seed).integers(0, 20, (HEIGHT, WIDTH, 3))
    return (np.stack([4 * x, 6 * y, 2 * (x + y)], axis=-1) + noise).astype(np.uint8)


def encode(suffix: str, seed: int, *flags: int) -> bytes:
    """Return a picture encoded by OpenCV."""
    import cv2

    ok, data = cv2.imencode(suffix, pixels(seed), list(flags))
    assert ok
    return data.tobytes()


def images() -> dict[str, bytes]:
    """Return one picture in each form by name: JPEG of three kinds, PNG, and the plain ones."""
    import cv2

    return {
        "a.jpg": encode(".jpg", 1, cv2.IMWRITE_JPEG_QUALITY, 40),
        "progressive.jpg": encode(
            ".jpg", 2, cv2.IMWRITE_JPEG_PROGRESSIVE, 1, cv2.IMWRITE_JPEG_QUALITY, 40
        ),
        "restarts.jpg": encode(
            ".jpg", 3, cv2.IMWRITE_JPEG_RST_INTERVAL, 2, cv2.IMWRITE_JPEG_QUALITY, 40
        ),
        "a.png": encode(".png", 1),
        "a.bmp": encode(".bmp", 1),
        "a.ppm": encode(".ppm", 1),
        "a.tif": encode(".tif", 1),
        "a.webp": encode(".webp", 1, cv2.IMWRITE_WEBP_QUALITY, 40),
        "a.jp2": encode(".jp2", 1),
    }


def ping_npz(seed: int = 0) -> bytes:
    """Return a sonar ping of a plain package."""
    file = io.BytesIO()
    image = np.random.default_rng(seed).integers(0, 255, (3, 4), dtype=np.uint8)
    save = np.savez if seed == 0 else np.savez_compressed
    save(file, image=image, azimuth=np.array([-0.1, 0, 0.1]), range=np.arange(1.0, 5.0))
    return file.getvalue()


def ping_npy() -> bytes:
    """Return the image of a sonar ping as .npy."""
    file = io.BytesIO()
    np.save(file, np.random.default_rng(0).integers(0, 255, (3, 4), dtype=np.uint8))
    return file.getvalue()


def oculus_ping() -> bytes:
    """Return a simple ping result, version 1, of four beams and eight ranges."""
    beams, ranges, start = 4, 8, 122
    image = bytes(range(beams * ranges))
    body = bytearray(start + 2 * beams) + image
    struct.pack_into("<HHHHHIH", body, 0, 0x4F53, 1, 0, 0x23, 0, len(body) - 16, 0)
    body[20] = 0x19
    struct.pack_into("<BdHH", body, 97, 0, 0.01, ranges, beams)
    struct.pack_into("<III", body, 110, start + 2 * beams, len(image), len(body))
    struct.pack_into(f"<{beams}h", body, start, *range(-1500, 1500, 3000 // beams))
    return bytes(body)


def reports(count: int = 4) -> str:
    """Return lines of what a DVL of Water Linked sends over TCP: velocities and attitudes."""
    out = []
    for number in range(count):
        t = 1_700_000_000.0 + number
        transducers = [{"id": i, "distance": 1.0 + 0.1 * i, "beam_valid": True} for i in range(4)]
        out.append(
            {
                "type": "velocity",
                "vx": 0.1,
                "vy": 0.2,
                "vz": 0.01 * number,
                "fom": 0.002,
                "altitude": 0.9,
                "velocity_valid": True,
                "transducers": transducers,
                "time_of_validity": round(1e6 * t),
                "format": "json_v3.1",
            }
        )
        out.append(
            {
                "type": "position_local",
                "ts": t + 0.5,
                "roll": 1.0,
                "pitch": 2.0,
                "yaw": 3.0 * number,
                "format": "json_v3.1",
            }
        )
    return "".join(json.dumps(report) + "\n" for report in out)


def pd0(count: int = 4) -> bytes:
    """Return PD0 ensembles with bottom track."""
    return b"".join(_ensemble(number) for number in range(1, count + 1))


def _ensemble(number: int) -> bytes:
    fixed = bytearray(59)
    struct.pack_into("<H", fixed, 4, 0x0200)  # 30 degrees, faces down
    fixed[8:10] = bytes([4, 2])  # beams, cells
    struct.pack_into("<H", fixed, 12, 50)
    fixed[25] = 0b01000  # instrument coordinates
    struct.pack_into("<H", fixed, 32, 100)
    variable = bytearray(65)
    struct.pack_into("<HH", variable, 0, 0x80, number)
    variable[4:11] = bytes([26, 5, 4, 9, 30, number % 60, 25])
    struct.pack_into("<HHhh", variable, 16, 25, 0, 0, 0)
    velocity = struct.pack("<H8h", 0x0100, *range(100, 108))
    bottom = bytearray(81)
    struct.pack_into("<H", bottom, 0, 0x0600)
    struct.pack_into("<4H", bottom, 16, 1000, 1100, 1200, 1300 + number)
    struct.pack_into("<4h", bottom, 24, 100, 200, -300, number)
    parts = [bytes(fixed), bytes(variable), velocity, bytes(bottom)]
    offsets = np.cumsum([6 + 2 * len(parts), *map(len, parts)])
    body = (
        b"\x7f\x7f" + struct.pack("<HBB4H", int(offsets[-1]), 0, 4, *offsets[:-1]) + b"".join(parts)
    )
    return body + struct.pack("<H", sum(body) % 65536)


def hulls() -> dict[str, bytes]:
    """Return a small spindle of 20 m in every format of a CAD model, text and binary."""
    import trimesh

    x, angle = np.linspace(-10, 10, 5), np.linspace(0, 2 * np.pi, 7)[:-1]
    radius = 3.0 * (1.02 - (x / 10) ** 2)
    ring = np.stack([np.zeros(6), np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.vstack([[(a, 0, 0) + r * ring for a, r in zip(x, radius, strict=True)]]).reshape(
        -1, 3
    )
    faces = [
        face for i in range(4) for j in range(6)
        for a, b, c, d in [(6 * i + j, 6 * i + (j + 1) % 6, 6 * i + 6 + j, 6 * i + 6 + (j + 1) % 6)]
        for face in ((a, b, c), (b, d, c))
    ]  # fmt: skip
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    out = {f"hull.{kind}": mesh.export(file_type=kind) for kind in ("stl", "obj", "off", "glb")}
    out["ascii.stl"] = mesh.export(file_type="stl_ascii")
    out["hull.ply"] = mesh.export(file_type="ply")
    out["ascii.ply"] = mesh.export(file_type="ply", encoding="ascii")
    return {name: data.encode() if isinstance(data, str) else data for name, data in out.items()}
