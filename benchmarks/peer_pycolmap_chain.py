# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pycolmap's sparse pipeline on a folder of images of one calibrated camera: features, matching of
neighbours in time, incremental mapping. Its calibration is held, and no GPU is used.

Arguments: the folder of images, the twelve parameters of FULL_OPENCV as a text, the number of
threads, and where to write the answer.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pycolmap


def main() -> int:
    images, parameters, threads, answer = sys.argv[1:]
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model, reader.camera_params = "FULL_OPENCV", parameters
    extraction, matching = pycolmap.FeatureExtractionOptions(), pycolmap.FeatureMatchingOptions()
    mapping = pycolmap.IncrementalPipelineOptions()
    for options in (extraction, matching, mapping):
        options.num_threads = int(threads)
    extraction.use_gpu = matching.use_gpu = False
    mapping.ba_refine_focal_length = False
    mapping.ba_refine_principal_point = mapping.ba_refine_extra_params = False
    seconds: dict[str, float] = {}
    models: dict[int, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        data, sparse = Path(folder) / "database.db", Path(folder) / "sparse"
        stages: dict[str, Callable[[], Any]] = {
            "features": lambda: pycolmap.extract_features(
                data,
                images,
                camera_mode=pycolmap.CameraMode.SINGLE,
                reader_options=reader,
                extraction_options=extraction,
            ),
            "matching": lambda: pycolmap.match_sequential(data, matching_options=matching),
            "mapping": lambda: models.update(
                pycolmap.incremental_mapping(data, images, sparse, mapping)
            ),
        }
        for name, make in stages.items():
            begun = time.perf_counter()
            make()
            seconds[name] = round(time.perf_counter() - begun, 1)
    largest = max((model.num_reg_images() for model in models.values()), default=0)
    result = {
        "seconds": seconds,
        "total_s": round(sum(seconds.values()), 1),
        "cpu_s": round(time.process_time(), 1),
        "images_in_largest_model": largest,
        "models": len(models),
    }
    Path(answer).write_text(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
