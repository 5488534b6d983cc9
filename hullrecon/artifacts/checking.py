# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check a workspace: every artifact against its manifest, and the package's files against what was
read from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from hullrecon.artifacts.delivery import PUBLISHED, delivered_records, unlike_files
from hullrecon.artifacts.documents import DamagedArtifactError, unseal
from hullrecon.artifacts.manifest import HashCache, Manifest
from hullrecon.artifacts.workspace import COMPARE_FOLDER, PRIVATE, Workspace, damaged_files


@dataclass(kw_only=True)
class WorkspaceCheck:
    """artifacts and files looked at, and a sentence for each that is not as it was written."""

    artifacts: int = 0
    files: int = 0
    read_bytes: int = 0
    damaged: list[str] = field(default_factory=list)


def check_workspace(
    workspace: Workspace, names: Sequence[str], *, read_data: bool
) -> WorkspaceCheck:
    """Compare presence and size of every file with the manifests; with read_data every byte, the
    package's files too.

    deliver/ is compared with what the artifacts deliver, and what `compare` left is looked at like
    the chain's own.
    """
    result = WorkspaceCheck()
    hashes = workspace.hashes(trusting=not read_data)
    _check_own_documents(workspace, result)
    _check_artifacts(workspace, names, hashes, read_data, result)
    for variant in sorted((workspace.root / COMPARE_FOLDER).glob("*/")):
        found = WorkspaceCheck()
        _check_artifacts(Workspace(variant), names, hashes, False, found)
        result.artifacts += found.artifacts
        result.files += found.files
        result.read_bytes += found.read_bytes
        remedy = "remove it with its step's folder, and `hullrecon compare` solves it again"
        result.damaged += [
            f"{COMPARE_FOLDER}/{variant.name}/{sentence}: {remedy}" for sentence in found.damaged
        ]
    return result


def _check_own_documents(workspace: Workspace, result: WorkspaceCheck) -> None:
    """Look at what the workspace keeps for itself: the next run writes anew what is damaged of it."""
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
    folder = workspace.artifact(name)
    result.artifacts += 1
    result.files += len(manifest.outputs)
    result.read_bytes += sum(record.size for record in manifest.outputs.values())
    result.damaged += [f"{name}/{sentence}" for sentence in damaged_files(folder, manifest, hashes)]
    if manifest.recipe.key != manifest.key:
        result.damaged.append(f"{name}/manifest.json: its key does not fit its recipe")
    delivered = delivered_records(manifest)
    if delivered:
        result.files += len(delivered)
        result.read_bytes += sum(record.size for record in delivered.values())
        unlike = unlike_files(workspace.delivery.folder, delivered, hashes)
        result.damaged += [
            f"{PUBLISHED}/{file} {what}: `run --read-data` restores it"
            for file, what in unlike.items()
        ]


def _check_package(
    workspace: Workspace, manifest: Manifest, hashes: HashCache, result: WorkspaceCheck
) -> None:
    package = workspace.package
    if package is None:
        return
    for name, record in sorted(manifest.recipe.external.items()):
        result.files += 1
        result.read_bytes += record.size
        try:
            now = hashes.record(package / name)
        except OSError as error:
            result.damaged.append(f"{package / name} cannot be read: {error.strerror}")
            continue
        if now != record:
            result.damaged.append(f"{package / name} is not what {manifest.recipe.stage} read")
