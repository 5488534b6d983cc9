# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check every artifact against its manifest, and the package's files against what was read."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from hullrecon.artifacts.delivery import PUBLISHED, delivered_records, unlike_files
from hullrecon.artifacts.documents import DamagedArtifactError, unseal
from hullrecon.artifacts.manifest import FileRecord, HashCache, Manifest
from hullrecon.artifacts.workspace import COMPARE_FOLDER, PRIVATE, Workspace, damaged_files


@dataclass(kw_only=True)
class WorkspaceCheck:
    """Counts of what was checked, and a sentence for each file that was changed or is missing."""

    artifacts: int = 0
    files: int = 0
    read_bytes: int = 0
    damaged: list[str] = field(default_factory=list)

    def count(self, records: Iterable[FileRecord]) -> None:
        """Add files to the counts."""
        for record in records:
            self.files += 1
            self.read_bytes += record.size


def check_workspace(
    workspace: Workspace, names: Sequence[str], *, read_data: bool
) -> WorkspaceCheck:
    """Compare every file of the steps `names` with the manifests.

    Files whose size and time of modification are those of the hash cache are not read again, unless
    `read_data` is set. deliver/ is compared with what the artifacts deliver, and with `read_data`
    also the package with what was read. Variants that a study left are checked like the chain's own
    artifacts.
    """
    result = WorkspaceCheck()
    hashes = workspace.hashes(trusting=not read_data)
    _check_own_documents(workspace, result)
    _check_artifacts(workspace, names, hashes, read_data, result)
    for variant in sorted((workspace.root / COMPARE_FOLDER).glob("*/")):
        seen = len(result.damaged)
        _check_artifacts(Workspace(variant), names, hashes, False, result)
        remedy = "remove it with its step's folder, and the study solves it again"
        result.damaged[seen:] = [
            f"{COMPARE_FOLDER}/{variant.name}/{sentence}: {remedy}"
            for sentence in result.damaged[seen:]
        ]
    return result


def _check_own_documents(workspace: Workspace, result: WorkspaceCheck) -> None:
    """Check the seals of the workspace's own documents. The next run makes damaged ones anew."""
    for path in sorted((workspace.root / PRIVATE).glob("[!.]*.json")):
        result.files += 1
        try:
            data = path.read_bytes()
            result.read_bytes += len(data)
            unseal(data)
        except (OSError, DamagedArtifactError) as error:
            result.damaged.append(f"{PRIVATE}/{path.name}: {error}")


def _check_artifacts(
    workspace: Workspace,
    names: Sequence[str],
    hashes: HashCache,
    read_data: bool,
    result: WorkspaceCheck,
) -> None:
    """Check manifest and files of each step's artifact, and with `read_data` the package.

    Results are added to `result`.
    """
    for name in names:
        try:
            manifest = workspace.manifest(name)
        except DamagedArtifactError as error:
            result.damaged.append(f"{name}/manifest.json: {error}")
            continue
        if manifest is not None:
            _check_artifact(workspace, name, manifest, hashes, result)
            if read_data:
                _check_package(workspace, manifest, hashes, result)


def _check_artifact(
    workspace: Workspace, name: str, manifest: Manifest, hashes: HashCache, result: WorkspaceCheck
) -> None:
    """Compare an artifact's files, and the copies of them in deliver/, with its manifest.

    Counts, and a sentence for each file that differs, are added to `result`.
    """
    result.artifacts += 1
    result.count(manifest.outputs.values())
    found = damaged_files(workspace.artifact(name), manifest, hashes)
    result.damaged += [f"{name}/{sentence}" for sentence in found]
    if manifest.recipe.key != manifest.key:
        result.damaged.append(f"{name}/manifest.json: its key does not fit its recipe")
    delivered = delivered_records(manifest)
    if delivered:
        result.count(delivered.values())
        unlike = unlike_files(workspace.delivery.folder, delivered, hashes)
        result.damaged += [
            f"{PUBLISHED}/{file} {what}: `run --read-data` restores it"
            for file, what in unlike.items()
        ]


def _check_package(
    workspace: Workspace, manifest: Manifest, hashes: HashCache, result: WorkspaceCheck
) -> None:
    """Compare the package's files with what the step read of them. Adds to `result`.

    Nothing is compared where it is not known which package was read.
    """
    package = workspace.package
    if package is None:
        return
    result.count(manifest.recipe.external.values())
    for name, record in sorted(manifest.recipe.external.items()):
        try:
            now = hashes.record(package / name)
        except OSError as error:
            result.damaged.append(f"{package / name} cannot be read: {error.strerror}")
            continue
        if now != record:
            result.damaged.append(f"{package / name} is not what {manifest.recipe.stage} read")
