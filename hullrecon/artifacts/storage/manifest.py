# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""manifest.json: what an artifact was made from, what it holds, and a `run` block for all that
differs between equal runs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

import msgspec
from msgspec import Struct

from hullrecon.artifacts.storage.disk import write_file
from hullrecon.artifacts.storage.documents import DamagedArtifactError, digest, seal, unseal

FILE_NAME = "manifest.json"
SCHEMA = 1
JsonTable: TypeAlias = dict[str, Any]  # msgspec decodes no recursive type


class FileRecord(Struct, frozen=True):
    sha256: str
    size: int


class Recipe(Struct, frozen=True, kw_only=True):
    """What decides an artifact's content: equal recipe, equal bytes.

    settings: resolved options by section, None for an absent section. inputs: content hash of each
    input artifact. external: files of the package by their path relative to it. failures: why
    optional inputs left no artifact, by stage name.
    """

    stage: str
    version: int
    settings: JsonTable
    inputs: dict[str, str] = {}
    external: dict[str, FileRecord] = {}
    failures: dict[str, str] = {}

    @property
    def key(self) -> str:
        return digest(self.content)

    @property
    def content(self) -> JsonTable:
        """Return what the key is the hash of; `failures` only where there are some, as older
        versions had none.
        """
        content: JsonTable = msgspec.to_builtins(self)
        if not self.failures:
            del content["failures"]
        return content


class Manifest(Struct, frozen=True, kw_only=True):
    """recipe: what it was made from; outputs: every file by relative path; run: host, seconds,
    memory, versions, source.
    """

    recipe: Recipe
    key: str
    outputs: dict[str, FileRecord]
    warnings: list[str] = []
    run: JsonTable = {}
    schema: int = SCHEMA

    @property
    def content_hash(self) -> str:
        """Return the hash of all but the `run` block: what a step that takes this artifact depends
        on.
        """
        content = msgspec.to_builtins(self) | {"recipe": self.recipe.content}
        del content["run"]
        return digest(content)


def write_manifest(folder: Path, manifest: Manifest) -> None:
    write_file(folder / FILE_NAME, seal(msgspec.to_builtins(manifest)))


def read_manifest(folder: Path) -> Manifest | None:
    """Return the manifest of an artifact; None when there is no artifact.

    Raises DamagedArtifactError when it is missing in one, cut short or altered.
    """
    if not folder.is_dir():
        return None
    try:
        data = (folder / FILE_NAME).read_bytes()
    except FileNotFoundError as error:
        raise DamagedArtifactError("its manifest is missing") from error
    try:
        return msgspec.convert(unseal(data), Manifest)
    except msgspec.ValidationError as error:
        raise DamagedArtifactError(f"its manifest is of another kind: {error}") from error
