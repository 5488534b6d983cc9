# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Collect what decides a step's result, and explain why an artifact is out of date."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from hullrecon.artifacts.documents import Json, digest
from hullrecon.artifacts.manifest import (
    FILE_NAME,
    FileRecord,
    HashCache,
    Recipe,
    files_below,
    read_manifest,
)
from hullrecon.artifacts.stage import Stage, StageSettings, flatten, resolve_settings, settings_for
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


@dataclass(frozen=True, kw_only=True)
class Job:
    """One stage with all that it works on. source: the package's folder. recipe: what decides the
    result.
    """

    stage: Stage
    settings: StageSettings
    inputs: Mapping[str, Path]
    source: Path | None
    recipe: Recipe


def make_job(
    stage: Stage, sections: Mapping[str, object], inputs: Mapping[str, Path], source: Path | None, hashes: HashCache,
    failures: Mapping[str, str] = MappingProxyType({}),
) -> Job:  # fmt: skip
    """Return the job; failures: why steps of this run left no artifact, of which those that it
    could use count.

    Raises InputError when a file of the package is missing, UsageError for an option that is not
    finite.
    """
    settings = settings_for(stage, sections)
    own = {name: failures[name] for name in stage.optional if name in failures}
    return Job(
        stage=stage,
        settings=settings,
        inputs=inputs,
        source=source,
        recipe=make_recipe(stage, settings, inputs, source, hashes, own),
    )


_ABSENT = object()


def differences(made: Recipe, now: Recipe) -> list[str]:
    """Return a sentence for each part of the recipe that changed; none exactly when the keys are
    equal.
    """
    return [
        *_options(made.settings, now.settings),
        *_inputs(made.inputs, now.inputs),
        *_external(made.external, now.external),
        *_failures(made.failures, now.failures),
        *([f"code version {made.version} -> {now.version}"] if made.version != now.version else []),
        *([f"it was made by step {made.stage}"] if made.stage != now.stage else []),
    ]


def _options(made: Mapping[str, Json], now: Mapping[str, Json]) -> Iterator[str]:
    """Yield a sentence for each changed option; one for a whole section that came or went, or that
    the step reads no longer.
    """
    for section in sorted({*made, *now}):
        before, after = made.get(section, _ABSENT), now.get(section, _ABSENT)
        if isinstance(before, dict) and isinstance(after, dict):
            yield from _changed_options(
                flatten(before, f"{section}."), flatten(after, f"{section}.")
            )
        elif after is _ABSENT:
            yield f"{section} is no longer read, it was {_as_text(before)}"
        elif before is _ABSENT:
            yield f"{section} is read now, it is {_as_text(after)}"
        elif before != after:
            yield f"{section} changed from {_as_text(before)} to {_as_text(after)}"


def _changed_options(before: Mapping[str, Json], after: Mapping[str, Json]) -> Iterator[str]:
    for name in sorted({*before, *after}):
        one, two = before.get(name, _ABSENT), after.get(name, _ABSENT)
        if one is _ABSENT:
            yield f"option {name} is new, it is {_as_text(two)}"
        elif two is _ABSENT:
            yield f"option {name} is gone, it was {_as_text(one)}"
        elif one != two or type(one) is not type(two):
            yield f"option {name} changed from {_as_text(one)} to {_as_text(two)}"


def _inputs(made: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield f"input {name} {_verb(name in made, name in now)}"


def _external(made: Mapping[str, FileRecord], now: Mapping[str, FileRecord]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield f"external file {name} {_verb(name in made, name in now)}"


def _failures(made: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield (
                f"{name} failed: {now[name]}"
                if name in now
                else f"it was made without {name}, which had failed"
            )


def _verb(before: bool, after: bool) -> str:
    return "changed" if before and after else "is new" if after else "is gone"


def _as_text(value: object) -> str:
    """Return a whole section as the word for it, any other value as in JSON."""
    if value is None:
        return "none"
    return "a section" if isinstance(value, dict) else json.dumps(value, ensure_ascii=False)


_LISTED = 3  # files that the error names one by one
REMEDY = "nothing was delivered: run again when nobody writes there"


class SourceWatch:
    """Keeps what each file was when a step of this run read it."""

    def __init__(
        self, hashes: HashCache, package: Path, read_before: Mapping[str, FileRecord] | None = None
    ) -> None:
        """Watch a package. read_before: files of it that were read before the first step, by their
        path relative to it.
        """
        self._hashes, self._package = hashes, package
        self._read: dict[str, FileRecord] = dict(read_before or {})

    def begin(self, job: Job) -> None:
        """Note the files that a step is about to read. Raises InputError where an earlier step of
        this run read another one.
        """
        changed = [
            name
            for name, record in job.recipe.external.items()
            if self._read.get(name, record) != record
        ]
        if changed:
            raise _changed_error(changed, self._package)
        self._read |= job.recipe.external

    def end(self, job: Job) -> None:
        """Raise InputError where a file that a step of this run has read is no longer what it was,
        or files came or went.
        """
        now = external_files(job.stage, job.settings, job.source, self._hashes)
        changed = {
            name
            for name in {*now, *job.recipe.external}
            if now.get(name) != job.recipe.external.get(name)
        }
        changed |= {
            name
            for name, record in self._read.items()
            if name not in now and not self._is_still(name, record)
        }
        if changed:
            raise _changed_error(sorted(changed), self._package)

    def _is_still(self, name: str, record: FileRecord) -> bool:
        try:
            return self._hashes.record(self._package / name) == record
        except OSError:
            return False


def _changed_error(names: list[str], package: Path) -> InputError:
    listed = ", ".join(names[:_LISTED]) + (
        f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    )
    return InputError(f"{listed} changed during the run", where=str(package), remedy=REMEDY)
