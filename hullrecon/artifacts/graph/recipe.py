# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Collect what decides a stage's result: its settings, its inputs by content, its files of the
package, its version.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from hullrecon.artifacts.graph.settings import resolve_settings
from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.graph.stage_settings import StageSettings
from hullrecon.artifacts.storage.documents import digest
from hullrecon.artifacts.storage.hashing import HashCache, files_below
from hullrecon.artifacts.storage.manifest import FILE_NAME, FileRecord, Recipe, read_manifest
from hullrecon.errors import InputError


def make_recipe(
    stage: Stage, settings: StageSettings, inputs: Mapping[str, Path], source: Path | None, hashes: HashCache,
    failures: Mapping[str, str] = MappingProxyType({}),
) -> Recipe:  # fmt: skip
    """Return the recipe as things are now. Raises InputError when a file of the package is missing."""
    return Recipe(
        stage=stage.name,
        version=stage.version,
        settings=resolve_settings(settings),
        inputs={name: content_hash(folder, hashes) for name, folder in sorted(inputs.items())},
        external=external_files(stage, settings, source, hashes),
        failures=dict(failures),
    )


def external_files(
    stage: Stage, settings: StageSettings, source: Path | None, hashes: HashCache
) -> dict[str, FileRecord]:
    """Return the files of the package that the stage reads by path relative to it, a folder as all
    files below it.
    """
    if stage.external is None or source is None:
        return {}
    found: dict[str, FileRecord] = {}
    try:
        for named in stage.external(settings, source):
            path = source / named
            members = [path / name for name in files_below(path)] if path.is_dir() else [path]
            for member in members:
                name = (
                    member.relative_to(source).as_posix()
                    if member.is_relative_to(source)
                    else str(member)
                )
                found[name] = _external_record(member, name, hashes)
    except OSError as error:  # a name that no file can have
        name = str(error.filename or "a file of the package")
        shown = name if len(name) <= 100 else f"{name[:97]}..."
        raise InputError(
            f"{shown} cannot be read: {error.strerror}",
            where=str(source),
            remedy="correct dive.toml",
        ) from error
    return found


def content_hash(folder: Path, hashes: HashCache) -> str:
    """Return the content hash of an artifact by its manifest; of a folder made by hand, the hash of
    its files.
    """
    manifest = read_manifest(folder) if (folder / FILE_NAME).exists() else None
    if manifest is not None:
        return manifest.content_hash
    return digest({name: hashes.record(folder / name).sha256 for name in files_below(folder)})


def _external_record(path: Path, name: str, hashes: HashCache) -> FileRecord:
    try:
        return hashes.record(path)
    except FileNotFoundError as error:
        raise InputError(
            f"{name} is missing", where=str(path.parent), remedy="put it there or correct dive.toml"
        ) from error
    except OSError as error:
        raise InputError(
            f"{name} cannot be read: {error.strerror}", where=str(path.parent)
        ) from error
