# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`check` of a workspace: every artifact against its manifest, and the package's files against what was read from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from hullrecon.artifacts.storage.documents import DamagedArtifactError
from hullrecon.artifacts.storage.hashing import HashCache
from hullrecon.artifacts.storage.manifest import Manifest
from hullrecon.artifacts.storage.workspace import PUBLISHED, Workspace, damaged_files, unequal_files


@dataclass
class WorkspaceCheck:
    """artifacts and files looked at, and a sentence for each that is not as it was written."""

    artifacts: int = 0
    files: int = 0
    read_bytes: int = 0
    damaged: list[str] = field(default_factory=list)


def check_workspace(workspace: Workspace, names: Sequence[str], *, read_data: bool) -> WorkspaceCheck:
    """Compares presence and size of every file with the manifests; with read_data every byte, the package's files too."""
    result = WorkspaceCheck()
    hashes = workspace.hashes(trusting=not read_data)
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
    return result


def _check_artifact(workspace: Workspace, name: str, manifest: Manifest, hashes: HashCache, result: WorkspaceCheck) -> None:
    folder = workspace.artifact(name)
    result.artifacts += 1
    result.files += len(manifest.outputs)
    result.read_bytes += sum(record.size for record in manifest.outputs.values())
    result.damaged += [f"{name}/{sentence}" for sentence in damaged_files(folder, manifest, hashes)]
    if manifest.recipe.key != manifest.key:
        result.damaged.append(f"{name}/manifest.json: its key does not fit its recipe")
    if (folder / PUBLISHED).is_dir():
        shown = unequal_files(folder / PUBLISHED, workspace.root / PUBLISHED)
        result.damaged += [f"{PUBLISHED}/{file} is not the one of {name}: `run` puts it right" for file in shown]


def _check_package(workspace: Workspace, manifest: Manifest, hashes: HashCache, result: WorkspaceCheck) -> None:
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
