# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import pickle
from io import BytesIO

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.dive.images.encoded import IMAGE_SUFFIXES, check_image, decode, jpeg_is_whole
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.images.store import CAMERAS, ImageStore
from hullrecon.dive.ingest.refusals import refuse_same_files
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.records.serialisation import to_arrays


@pytest.fixture(scope="module")
def jpegs(kit) -> list[bytes]:
    return [kit.jpeg(shade) for shade in range(6)]


def sink(tmp_path, size=(64, 48)):
    file = BytesIO()
    return ImageSink("camera_top", size, tmp_path, lambda: file), file


def take(sink: ImageSink, *samples: ImageSample):
    for sample in samples:
        sink.take(sample, sample.t_ns, 0)
    notes = []
    return sink.finish(notes), notes


def image(t, encoded=b"", file=""):
    return ImageSample(t, "camera_top", encoded, file)


def test_images_keep_their_bytes_and_are_indexed_in_time_order(tmp_path, jpegs):
    store, file = sink(tmp_path)
    index, notes = take(store, image(20, jpegs[0]), image(10, jpegs[1]))
    assert index.t_ns.tolist() == [10, 20]
    for row, encoded in ((0, jpegs[1]), (1, jpegs[0])):
        assert file.getvalue()[index.offset[row] : index.offset[row] + index.size[row]] == encoded
    assert index.usable.all()
    assert sentences(notes) == ["camera_top: 1 readings stood out of order and were sorted"]


def test_pictures_that_a_driver_publishes_again_are_read_once(tmp_path, jpegs):
    pictures = [jpegs[k // 2 % 2] for k in range(60)]
    index, notes = take(sink(tmp_path)[0], *(image(t, each) for t, each in enumerate(pictures)))
    assert index.t_ns.tolist() == list(range(0, 60, 2))
    assert "30 of 60 images repeat the one before" in notes[0].sentence


def test_pictures_of_a_camera_that_stopped_for_a_while_are_left_out(tmp_path, jpegs):
    pictures = [jpegs[k] for k in (0, 1, 1, 1, 2, 0)]
    index, notes = take(sink(tmp_path)[0], *(image(t, each) for t, each in enumerate(pictures)))
    assert index.t_ns.tolist() == [0, 1, 4, 5]
    assert "2 of 6 images repeat the one before" in notes[0].sentence


def smooth_colours(width=64, height=48) -> np.ndarray:
    """Blue, green, red (h, w, 3) of a bluish scene that changes from place to place."""
    y, x = np.mgrid[:height, :width]
    waves = np.stack([np.sin(x / 7 + y / 9 + k) for k in range(3)], axis=2)
    return np.clip(waves * 30 + (150, 90, 40), 0, 255)


@pytest.mark.parametrize("pattern", ["rggb", "gbrg"])
@pytest.mark.parametrize("scale", [1, 16])
def test_a_mosaic_in_a_gray_picture_is_named(tmp_path, pattern, scale):
    colours = smooth_colours() * scale
    mosaic = np.empty(colours.shape[:2], np.uint8 if scale == 1 else np.uint16)
    for site, colour in enumerate(pattern):
        y, x = divmod(site, 2)
        mosaic[y::2, x::2] = colours[y::2, x::2, "bgr".index(colour)]
    _, notes = take(sink(tmp_path)[0], image(0, bytes(cv2.imencode(".png", mosaic)[1])))
    assert "1 of 1 images are Bayer mosaics" in notes[0].sentence


def test_pictures_and_noise_are_no_mosaics(tmp_path):
    noise = np.random.default_rng(3).integers(0, 255, (48, 64)).astype(np.uint8)
    for pixels in (smooth_colours()[:, :, 1].astype(np.uint8), noise):
        assert not check_image(bytes(cv2.imencode(".png", pixels)[1])).is_mosaic


@pytest.mark.parametrize("bad", [b"", b"no image", "half", "turned"])
def test_corrupt_image_is_kept_as_unusable_and_counted(tmp_path, jpegs, bad):
    spoilt = {"half": jpegs[1][: len(jpegs[1]) // 2], "turned": jpegs[1][:-2]}.get(bad, bad)
    index, notes = take(sink(tmp_path)[0], image(0, jpegs[0]), image(1, spoilt), image(2, jpegs[2]))
    assert index.usable.tolist() == [True, False, True]
    assert sentences(notes) == ["camera_top: 1 of 3 images are missing or damaged and are left out"]


def test_image_of_other_size_is_unusable_and_counted(tmp_path, kit, jpegs):
    index, notes = take(sink(tmp_path)[0], image(0, jpegs[0]), image(1, kit.jpeg(1, 32, 24)))
    assert index.usable.tolist() == [True, False]
    assert sentences(notes) == ["camera_top: 1 of 2 images have another size and are left out"]


@pytest.mark.parametrize("count", [3, 9])
def test_a_camera_most_of_whose_images_are_of_another_size_is_refused(tmp_path, kit, count):
    pictures = [kit.jpeg(0), *(kit.jpeg(t, 32, 24) for t in range(1, count))]
    images = [image(t, picture) for t, picture in enumerate(pictures)]
    words = f"{count - 1} of {count} images of camera_top have 32 x 24 pixels"
    with pytest.raises(InputError, match=words) as refused:
        take(sink(tmp_path)[0], *images)
    assert refused.value.remedy == "give the calibration of this camera at this size"
    index, _ = take(sink(tmp_path, (32, 24))[0], *images)
    assert index.usable.sum() == count - 1


def test_images_unlike_calibration_are_refused_early_with_sizes(tmp_path, jpegs):
    store, _ = sink(tmp_path, (640, 480))
    for t in range(4):
        store.take(image(t, jpegs[0]), t, 0)
    with pytest.raises(InputError, match="64 x 48 pixels, its calibration is for 640 x 480"):
        store.take(image(4, jpegs[0]), 4, 0)
    assert len(take(sink(tmp_path, (64, 48))[0], image(4, jpegs[0]))[0].t_ns) == 1


def test_few_images_of_another_size_are_refused_at_the_end(tmp_path, jpegs):
    with pytest.raises(InputError, match="64 x 48"):
        take(sink(tmp_path, (640, 480))[0], image(0, jpegs[0]))


def test_files_stay_where_they_are(tmp_path, jpegs):
    (tmp_path / "a.jpg").write_bytes(jpegs[0])
    store, file = sink(tmp_path)
    index, notes = take(store, image(0, file="a.jpg"), image(1, file="gone.jpg"))
    assert index.file.tolist() == ["a.jpg", "gone.jpg"]
    assert index.usable.tolist() == [True, False]
    assert file.getvalue() == b""
    assert "missing or damaged" in notes[0].sentence


def named(tmp_path, kit, names):
    """Images in files, in the order of their stamps."""
    for shade, name in enumerate(names):
        (tmp_path / name).write_bytes(kit.jpeg(shade))
    return [image(t, file=name) for t, name in enumerate(names)]


def test_stamps_in_the_order_of_names_as_text_are_refused(tmp_path, kit):
    names = [f"img{number}.jpg" for number in range(1, 13)]
    take(sink(tmp_path)[0], *named(tmp_path, kit, names))
    with pytest.raises(InputError, match=r"img2\.jpg after img12\.jpg"):
        take(sink(tmp_path)[0], *named(tmp_path, kit, sorted(names)))


@pytest.mark.parametrize(
    "names",
    [
        [f"img{number:04d}.jpg" for number in range(1, 13)],
        [f"{second / 8}.jpg" for second in range(800, 812)],  # 100.5 comes after 100.375
        [f"img{number}.jpg" for number in range(12, 0, -1)],  # counted down
        [f"img{number}.jpg" for number in (10, 9)],
    ],
)
def test_names_that_the_order_of_text_does_not_explain_are_taken(tmp_path, kit, names):
    index, _ = take(sink(tmp_path)[0], *named(tmp_path, kit, names))
    assert len(index) == len(names)


def test_two_cameras_that_name_the_same_pictures_are_refused(tmp_path, kit):
    first, second = (
        take(sink(tmp_path)[0], *named(tmp_path, kit, [f"{camera}{k}.jpg" for k in range(3)]))[0]
        for camera in ("top", "bottom")
    )
    with pytest.raises(InputError, match="3 pictures are of both cameras, the first is top0"):
        refuse_same_files({"camera_top": first, "camera_bottom": first})
    refuse_same_files({"camera_top": first, "camera_bottom": second})
    refuse_same_files({"camera_top": first})


def test_images_of_which_none_is_whole_are_refused_until_they_are(tmp_path, jpegs):
    with pytest.raises(InputError, match="the only image of camera_top cannot be read") as caught:
        take(sink(tmp_path)[0], image(10, jpegs[0][:200]))
    assert caught.value.remedy.startswith("see that they are there and whole, in a form that")
    assert len(take(sink(tmp_path)[0], image(10, jpegs[0]))[0].t_ns) == 1


def test_no_images_are_no_index(tmp_path):
    assert sink(tmp_path)[0].finish([]) is None


@pytest.fixture
def store(tmp_path, jpegs) -> ImageStore:
    filled, file = sink(tmp_path)
    (tmp_path / "b.jpg").write_bytes(jpegs[2])
    index, _ = take(filled, image(0, jpegs[0]), image(1, jpegs[1][:100]), image(2, file="b.jpg"))
    ArtifactWriter(tmp_path).arrays("images_camera_top.npz", to_arrays(index))
    (tmp_path / "images_camera_top.bin").write_bytes(file.getvalue())
    return ImageStore(tmp_path, tmp_path, "camera_top")


def test_store_reads_rgb_from_artifact_and_package(store, jpegs):
    assert len(store) == 3
    for row, encoded in ((0, jpegs[0]), (2, jpegs[2])):
        bgr = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR)
        np.testing.assert_array_equal(store.read(row), bgr[:, :, ::-1])


def test_an_unusable_image_is_none(store):
    assert store.read(1) is None


def test_the_store_pickles_and_reads_the_same(store):
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(store)).read(0), store.read(0))


def test_an_image_file_that_is_gone_is_an_input_error(store, tmp_path, jpegs):
    (tmp_path / "b.jpg").unlink()
    with pytest.raises(InputError, match="cannot be read"):
        store.read(2)
    with pytest.raises(InputError, match="lies in the package"):
        ImageStore(tmp_path, None, "camera_top").read(2)
    (tmp_path / "b.jpg").write_bytes(jpegs[1])
    assert store.read(2) is not None  # with the package's folder


def test_a_gray_png_reads_as_rgb():
    ok, png = cv2.imencode(".png", np.full((4, 5), 7, np.uint8))
    assert ok
    assert decode(png.tobytes()).tolist() == np.full((4, 5, 3), 7).tolist()


@given(st.binary(max_size=100))
def test_any_bytes_are_an_image_or_none(content):
    assert decode(content) is None or decode(content).shape[2] == 3
    assert check_image(b"\xff\xd8" + content).size is None


def test_a_whole_jpeg_is_whole_with_bytes_behind_it_too(jpegs):
    assert check_image(jpegs[0]).size == (64, 48)
    assert jpeg_is_whole(jpegs[0] + b"\0\0")


@pytest.mark.parametrize(
    ("flag", "value"), [(cv2.IMWRITE_JPEG_PROGRESSIVE, 1), (cv2.IMWRITE_JPEG_RST_INTERVAL, 2)]
)
def test_progressive_jpegs_and_restarts_are_whole(flag, value):
    pixels = np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8)
    encoded = cv2.imencode(".jpg", pixels, [flag, value])[1].tobytes()
    assert jpeg_is_whole(encoded)
    assert not jpeg_is_whole(encoded[:-2])


def test_a_restart_out_of_order_is_damage():
    pixels = np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8)
    encoded = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_RST_INTERVAL, 2])[1].tobytes()
    at = encoded.find(b"\xff\xd1")
    assert not jpeg_is_whole(encoded[:at] + b"\xff\xd3" + encoded[at + 2 :])


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.data())
def test_any_cut_of_a_jpeg_is_noticed(jpegs, data):
    assert check_image(jpegs[0][: data.draw(st.integers(0, len(jpegs[0]) - 1))]).size is None


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg", ".png", ".tif", ".bmp"])
def test_files_with_common_suffixes_are_images_and_decode(suffix):
    assert suffix in IMAGE_SUFFIXES
    ok, encoded = cv2.imencode(suffix, np.full((4, 6, 3), 128, np.uint8))
    assert ok
    image = decode(encoded.tobytes())
    assert image is not None
    assert image.shape == (4, 6, 3)


def test_names_of_logs_and_tables_are_no_images():
    assert not IMAGE_SUFFIXES & {".csv", ".npz", ".mcap", ".toml", ".mp4"}


def test_the_cameras_of_the_store_are_those_of_the_rig():
    assert CAMERAS == ("camera_top", "camera_bottom")


def turned_jpeg(value):
    picture = Image.fromarray(np.tile(np.arange(0, 250, 4, np.uint8)[:63], (48, 1)))
    exif = Image.Exif()
    exif[0x0112] = value
    out = BytesIO()
    picture.save(out, "JPEG", exif=exif)
    return out.getvalue()


@pytest.mark.parametrize(("value", "turn"), [(3, "by 180 degrees"), (6, "by 90 degrees")])
def test_a_picture_is_read_as_stored_and_its_turn_is_named(tmp_path, value, turn):
    encoded = turned_jpeg(value)
    pixels = decode(encoded)
    assert pixels.shape == (48, 63, 3)
    assert pixels[:, :8].mean() < 50 < 200 < pixels[:, -8:].mean()
    _, notes = take(sink(tmp_path, (63, 48))[0], image(10, encoded))
    (line,) = sentences(notes)
    assert f"turned {turn}; they are read as the sensor stored them" in line


def test_a_calibration_of_turned_pictures_is_refused_with_the_turn(tmp_path):
    store, _ = sink(tmp_path, (48, 63))
    words = "63 x 48 pixels as stored, to be shown turned by 90 degrees, its calibration is for 48"
    with pytest.raises(InputError, match=words):
        take(store, image(10, turned_jpeg(6)))
