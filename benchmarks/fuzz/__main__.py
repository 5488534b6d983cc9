# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Damage inputs and see how they end: python -m benchmarks.fuzz --cases 10000 --seed 1 [--format
mcap] [--jobs 2]

Prints one JSON document: verdicts by format, failures with the cases that reproduce them (`--format
F --first CASE --cases 1` with the same seed), cases per second. Ends with 1 when there was a
failure: a traceback, more than 2 s of the processor, more than 512 MiB, a lost process, an error or
remark of more than one line, or data that changed without a word though a checksum covers them.
--keep FILE adds the first case of each failure to a corpus file, such as tests/fuzz/corpus.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    from benchmarks.fuzz.campaign import Campaign, read_campaign, run_campaign
    from benchmarks.fuzz.corpus import add_findings
    from benchmarks.fuzz.formats import seeds
    from hullrecon.artifacts.disk import write_file

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fuzz", description=__doc__.splitlines()[0] if __doc__ else ""
    )
    parser.add_argument("--cases", type=int, default=10_000, help="over all formats together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--format", choices=sorted(seeds()), action="append", help="only this one; may be repeated"
    )
    parser.add_argument("--jobs", type=int, default=1, help="worker processes")
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first case of each format"
    )
    parser.add_argument("--keep", type=Path, help="corpus file that gets the failures")
    parser.add_argument(
        "--state",
        type=Path,
        help="file that gets the document every minute; the next call goes on from there",
    )
    given = parser.parse_args(arguments)
    campaign = Campaign(given.seed, given.first)
    if given.state is not None and given.state.exists():
        campaign = read_campaign(given.state)
        if (campaign.seed, campaign.first) != (given.seed, given.first):
            parser.error(
                f"{given.state} holds a campaign of seed {campaign.seed} from case {campaign.first}"
            )

    def keep() -> None:
        if given.state is not None:
            write_file(given.state, json.dumps(campaign.document(), indent=1).encode())

    run_campaign(campaign, given.format or sorted(seeds()), given.cases, given.jobs, keep)
    keep()
    if given.keep is not None:
        add_findings(given.keep, campaign)
    json.dump(campaign.document(), sys.stdout, indent=1)
    print()
    return 1 if campaign.findings else 0


if __name__ == "__main__":
    sys.exit(main())
