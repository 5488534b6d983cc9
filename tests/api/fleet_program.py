# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stands for hullrecon in the processes of a fleet: does at once what `do.txt` in the package says.

FLEET_TRACE: a file that gets a line for each dive that is run."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from pathlib import Path

from hullrecon.api.fleet.processes import end_with_parent


def main(command: str, package: Path, options: dict[str, str]) -> int:
    if command == "status":
        print(json.dumps({"error": {"message": "dive.toml is not valid TOML"}}))
        return 2
    do = (package / "do.txt").read_text() if (package / "do.txt").exists() else "deliver"
    with open(os.environ["FLEET_TRACE"], "a") as trace:
        trace.write(f"{package.name} {os.getpid()}\n")
    log = Path(options["--log-file"])
    log.write_text("" if do == "fail silently" else "started\n")
    name = options["--set"].removeprefix('dive.name="').removesuffix('"')
    if do == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if do == "wait":
        time.sleep(300)
    if do == "crash":
        print("terminate called\nwithout an active exception\n", file=sys.stderr)
        return 1
    if do == "read outside" and "--allow-outside" not in options:
        print(json.dumps({"error": {"message": "it lies outside the package"}}))
        return 2
    if do.startswith("fail") and do != "fail in one step":
        print(json.dumps({"error": {"message": "too few\x1b[31m matches"}}))
        return 4
    deliver = Path(options["--runs"]) / name / "deliver"
    deliver.mkdir(parents=True, exist_ok=True)
    (deliver / "report.txt").write_text(f"{name} {options.get('--scheduler')}")
    if do == "fail in one step":
        print(json.dumps({"error": {"message": "no ping meets the surface"}}))
        return 4
    return 0


if __name__ == "__main__":
    end_with_parent(int(sys.argv[1]))
    assert sys.argv[2:4] == ["--quiet", "--json"]
    words = [word for word in sys.argv[6:] if word != "--allow-outside"]
    options = dict(zip(words[::2], words[1::2], strict=True))
    options |= {"--allow-outside": ""} if len(words) < len(sys.argv[6:]) else {}
    sys.exit(main(sys.argv[4], Path(sys.argv[5]), options))
