# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Collect what decides a step's result, and explain why an artifact is out of date."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from hullrecon.artifacts.documents import Json, digest, encode
from hullrecon.artifacts.manifest import (
    FILE_NAME,
    FileRecord,
    HashCache,
    Recipe,
    files_below,
    read_manifest,
)
from hullrecon.artifacts.stage import (
    Stage,
    StageSettings,
    flatten,
    resolve_settings,
    settings_for,
)
from hullrecon.errors import InputError

REMEDY = "nothing was delivered: run again when nobody writes there"
_ABSENT = object()  # value of a name that a mapping lacks
_LISTED = 3  # files that an error names one by one
_LONG = 100  # characters of a name that are shown


@dataclass(frozen=True, kw_only=True)
class Job:
    """One stage with all that it works on."""

    stage: Stage
    settings: StageSettings
    inputs: Mapping[str, Path]  # folder of each input artifact by stage name
    source: Path | None  # the package's folder
    recipe: Recipe  # what decides the result


def make_job(
    stage: Stage,
    sections: Mapping[str, object],
    inputs: Mapping[str, Path],
    source: Path | None,
    hashes: HashCache,
    failures: Mapping[str, str] = MappingProxyType({}),
) -> Job:
    """Collect what a stage works on, in its present state, with the recipe of its result.

    Parameters
    ----------
    stage
        The step.
    sections
        Sections of dive.toml, by dotted name.
    inputs
        Folder of each input artifact by stage name.
    source
        The package's folder.
    hashes
        Cache of file hashes.
    failures
        Why steps of this run left no artifact, by name. Only the stage's optional inputs matter.

    Raises
    ------
    InputError
        A file of the package is missing.
    UsageError
        An option is not finite.
    """
    settings = settings_for(stage, sections)
    recipe = Recipe(
        stage=stage.name,
        version=stage.version,
        settings=resolve_settings(settings),
        inputs={name: content_hash(folder, hashes) for name, folder in sorted(inputs.items())},
        external=external_files(stage, settings, source, hashes),
        failures={name: failures[name] for name in stage.optional if name in failures},
    )
    return Job(stage=stage, settings=settings, inputs=inputs, source=source, recipe=recipe)


def external_files(
    stage: Stage, settings: StageSettings, source: Path | None, hashes: HashCache
) -> dict[str, FileRecord]:
    """Hash the files of the package that the stage reads, by their path in it.

    Of a folder all files are hashed. Files outside the package have their absolute path.

    Raises InputError if a file is missing or cannot be read.
    """
    if stage.external is None or source is None:
        return {}
    found: dict[str, FileRecord] = {}
    try:
        for named in stage.external(settings, source):
            path = source / named
            members = [path / name for name in files_below(path)] if path.is_dir() else [path]
            for member in members:
                inside = member.is_relative_to(source)
                name = member.relative_to(source).as_posix() if inside else str(member)
                found[name] = _external_record(member, name, hashes)
    except OSError as error:  # a name that no file can have
        name = str(error.filename or "a file of the package")
        shown = name if len(name) <= _LONG else f"{name[: _LONG - 3]}..."
        raise InputError(
            f"{shown} cannot be read: {error.strerror}",
            where=str(source),
            remedy="correct dive.toml",
        ) from error
    return found


def _external_record(path: Path, name: str, hashes: HashCache) -> FileRecord:
    """Hash a file of the package. Raises InputError with its name if it cannot be read."""
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


def content_hash(folder: Path, hashes: HashCache) -> str:
    """Look up the content hash of an artifact. For a folder made by hand, hash its files."""
    manifest = read_manifest(folder) if (folder / FILE_NAME).exists() else None
    if manifest is not None:
        return manifest.content_hash
    return digest({name: hashes.record(folder / name).sha256 for name in files_below(folder)})


def differences(made: Recipe, now: Recipe) -> list[str]:
    """Describe each part of a recipe that changed. Empty exactly if the keys are equal."""
    found = [*_options(made.settings, now.settings)]
    for what, before, after in (
        ("input", made.inputs, now.inputs),
        ("external file", made.external, now.external),
    ):
        for name in _changed(before, after):
            verb = "changed" if name in before and name in after else "is new"
            found.append(f"{what} {name} {verb if name in after else 'is gone'}")
    for name in _changed(made.failures, now.failures):
        found.append(
            f"{name} failed: {now.failures[name]}"
            if name in now.failures
            else f"it was made without {name}, which had failed"
        )
    if made.version != now.version:
        found.append(f"code version {made.version} -> {now.version}")
    if made.stage != now.stage:
        found.append(f"it was made by step {made.stage}")
    return found


def _options(made: Mapping[str, Json], now: Mapping[str, Json]) -> Iterator[str]:
    """Describe each changed option, and each whole section that came or went."""
    for section in _changed(made, now):
        before, after = made.get(section, _ABSENT), now.get(section, _ABSENT)
        if isinstance(before, dict) and isinstance(after, dict):
            one, two = flatten(before, f"{section}."), flatten(after, f"{section}.")
            for name in _changed(one, two):
                if name not in one:
                    yield f"option {name} is new, it is {_as_text(two[name])}"
                elif name not in two:
                    yield f"option {name} is gone, it was {_as_text(one[name])}"
                else:
                    was, now_is = _as_text(one[name]), _as_text(two[name])
                    yield f"option {name} changed from {was} to {now_is}"
        elif after is _ABSENT:
            yield f"{section} is no longer read, it was {_as_text(before)}"
        elif before is _ABSENT:
            yield f"{section} is read now, it is {_as_text(after)}"
        else:
            yield f"{section} changed from {_as_text(before)} to {_as_text(after)}"


def _changed(before: Mapping[str, object], after: Mapping[str, object]) -> list[str]:
    """List the names whose values differ as they are written in JSON, as 1 and 1.0 do."""
    return [
        name
        for name in sorted({*before, *after})
        if not _is_same(before.get(name, _ABSENT), after.get(name, _ABSENT))
    ]


def _is_same(one: object, other: object) -> bool:
    """Tell whether two values of a recipe are equal, and of one type."""
    if isinstance(one, list | dict) and isinstance(other, list | dict):
        return encode(one) == encode(other)
    return type(one) is type(other) and one == other


def _as_text(value: object) -> str:
    """Write a value of a recipe for a reason. Sections are not written out."""
    if value is None:
        return "none"
    return "a section" if isinstance(value, dict) else json.dumps(value, ensure_ascii=False)


class SourceWatch:
    """Checks that the package does not change during a run.

    It remembers each file as it was when a step of this run read it.
    """

    def __init__(
        self, hashes: HashCache, package: Path, read_before: Mapping[str, FileRecord] | None = None
    ) -> None:
        """Watch a package, of which `read_before` was read before the first step, by path in it."""
        self._hashes, self._package = hashes, package
        self._read: dict[str, FileRecord] = dict(read_before or {})

    def begin(self, job: Job) -> None:
        """Note the files that a step is about to read.

        Raises InputError if a file is not what an earlier step of this run read.
        """
        now = job.recipe.external
        self._refuse([n for n, record in now.items() if self._read.get(n, record) != record])
        self._read |= now

    def end(self, job: Job) -> None:
        """Raise InputError if a file that was read has changed, or files came or went."""
        before = job.recipe.external
        now = external_files(job.stage, job.settings, job.source, self._hashes)
        changed = set(_changed(before, now))
        changed |= {
            name
            for name, record in self._read.items()
            if name not in now and not self._is_still(name, record)
        }
        self._refuse(sorted(changed))

    def _is_still(self, name: str, record: FileRecord) -> bool:
        """Tell whether a file of the package is as it was recorded."""
        try:
            return self._hashes.record(self._package / name) == record
        except OSError:
            return False

    def _refuse(self, changed: list[str]) -> None:
        """Raise InputError for files that changed during the run. Nothing where none did."""
        if changed:
            more = f" and {len(changed) - _LISTED} more" if len(changed) > _LISTED else ""
            what = f"{', '.join(changed[:_LISTED])}{more} changed during the run"
            raise InputError(what, where=str(self._package), remedy=REMEDY)
