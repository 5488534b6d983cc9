# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How fast and how heavy a report's page is in a headless Chromium:

    python -m benchmarks.page RUN PACKAGE [--objects 500]

RUN is the folder of a finished run over PACKAGE. Its report is measured as it is and again with
that many objects (copies of its own, each at a place of its own). Prints JSON: bytes of the page
and of all that it needs, time to the first paint, time of a sort measured inside the page.
"""

from __future__ import annotations

import json
import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.arguments import parser_for
from benchmarks.chromium import browser, visit

if TYPE_CHECKING:
    from hullrecon.artifacts.stage import Context

VISITS = 5
SORTS = 5


def crowded_report(run: Path, package: Path, out: Path, count: int) -> Path:
    """Write the report of a run as if it had found `count` objects, copies of its own; return its
    page.
    """
    from hullrecon.artifacts.runner import run_stage
    from hullrecon.dive.config.load import load_config
    from hullrecon.report.deliver import deliver
    from hullrecon.steps.chain import stage, stages
    from hullrecon.steps.report import read_survey

    detect = out / "detect"
    detect.mkdir(parents=True)
    for path in (run / "detect").iterdir():
        if path.name not in ("objects.json", "manifest.json"):
            (detect / path.name).symlink_to(path)
    found = json.loads((run / "detect" / "objects.json").read_text())["objects"]
    (detect / "objects.json").write_text(
        json.dumps({"objects": [_copy(found[k % len(found)], k) for k in range(count)]})
    )
    report = stage("report")
    inputs = {
        name: run / name for name in (*report.inputs, *report.optional) if (run / name).is_dir()
    } | {"detect": detect}
    config = load_config(package, {step.name: step.parameters for step in stages()})
    sections = {
        section: config.value(section) for section in {name.split(".")[0] for name in report.uses}
    }
    page = "report/index.html"

    def write(context: Context[Any]) -> None:
        only = ("objects/", "report/tiles/", page)
        failures = deliver(read_survey(context), context.out, only=only)
        assert not failures, failures

    artifact = run_stage(replace(report, run=write), sections, inputs, out / "report", package)
    return artifact / "deliver" / page


def _copy(found: dict[str, Any], k: int) -> dict[str, Any]:
    """Return an object of its own number, and of a height that no other has, in no order."""
    height = 0.01 + (k * 7919 % 10_007) * 1e-5
    along = 0.02 * (k % 25)
    center = [found["center"][0] + along, *found["center"][1:]]
    return found | {
        "id": k + 1,
        "height": height,
        "center": center,
        "along": found["along"] + along,
    }


def measure(page: Path) -> dict[str, Any]:
    """Return weight and times of a page."""
    paints, sorts = [], []
    with browser() as chromium:
        for _ in range(VISITS):
            with visit(chromium, page) as seen:
                seen.page.wait_for_function(FIRST_PAINT)
                paints.append(seen.page.evaluate(FIRST_PAINT))
                needed = {request for request in seen.requests if request.startswith("file:")}
        with visit(chromium, page) as seen:
            rows = seen.page.locator(ROWS).count()
            for _ in range(SORTS if rows > 1 else 0):
                sorts.append(seen.page.evaluate(TIMED_SORT))
    weight = sum(Path(url.removeprefix("file://").split("?")[0]).stat().st_size for url in needed)
    return {
        "page_bytes": page.stat().st_size, "all_bytes": weight, "files": len(needed), "rows": rows,
        "first_paint_ms": _spread(paints), "sort_ms": _spread(sorts),
    }  # fmt: skip


ROWS = "#object-table tbody tr"
FIRST_PAINT = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime"
TIMED_SORT = """() => {
  const headings = [...document.querySelectorAll('#object-table thead button')]
  const heading = headings.find((one) => one.textContent.trim() === 'Height')
  const start = performance.now()
  heading.click()
  document.querySelector('#object-table').getBoundingClientRect()  // the layout belongs to it
  return performance.now() - start
}"""


def _spread(values: list[float]) -> dict[str, float] | None:
    if not values:
        return None
    return {"median": round(statistics.median(values), 1), "worst": round(max(values), 1)}


def main() -> None:
    parser = parser_for(__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("package", type=Path)
    parser.add_argument("--objects", type=int, default=500)
    options = parser.parse_args()
    run = options.run.resolve()
    with tempfile.TemporaryDirectory() as folder:
        crowded = crowded_report(run, options.package.resolve(), Path(folder), options.objects)
        result = {
            "as_it_is": measure(run / "deliver/report/index.html"),
            f"{options.objects}_objects": measure(crowded),
        }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
