# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Keep the finished parts of a running step, so that a kill loses only the part under way.

The reasons are in docs/adr/0014-finished-parts-outlive-a-kill.md.
"""

from __future__ import annotations

import enum
import errno
import hashlib
import io
import logging
import pickle
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import is_dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import msgspec

from hullrecon.artifacts.disk import remove, replace_file, storage_errors
from hullrecon.artifacts.documents import digest
from hullrecon.artifacts.machine import versions
from hullrecon.artifacts.manifest import Recipe

Item = TypeVar("Item")
Result = TypeVar("Result")
Depends = Callable[[Item], object]
log = logging.getLogger(__name__)
_HASH_BYTES = hashlib.sha256().digest_size  # before the data in a part's file
_FULL = {errno.ENOSPC, errno.EDQUOT}
# Names by which pickle rebuilds NumPy's arrays and scalars (numpy.core or numpy._core)
_OF_NUMPY = {"ndarray", "dtype", "scalar", "_reconstruct", "_frombuffer"}


class PartStore:
    """Results of a step's items, each in a file named by a hash of all that decides it."""

    def __init__(self, folder: Path, recipe: Recipe) -> None:
        """Keep the parts of the step that `recipe` describes below `folder`, its own."""
        decided = {
            "version": recipe.version,
            "settings": recipe.settings,
            "libraries": versions(),
        }
        self._step, self._all = recipe.stage, folder
        self._folder = folder / digest(decided)[:16]
        self._inputs = digest(
            {name: recipe.content.get(name) for name in ("inputs", "external", "failures")}
        )
        self._keeps = True
        self._bytes = 0  # size of all parts

    def begin(self) -> None:
        """Remove the parts of other settings, and count those that are there."""
        with storage_errors(self._all):
            for other in self._all.glob("*"):
                if other != self._folder:
                    remove(other)
            self._bytes = sum(part.stat().st_size for part in self._folder.glob("*"))

    def remove(self) -> None:
        """Remove all parts of the step."""
        with storage_errors(self._all):
            remove(self._all)

    def resume(
        self,
        label: str,
        items: Sequence[Item],
        compute: Callable[[Sequence[Item]], Iterator[Result]],
        depends: Depends[Item] | None = None,
        given: Mapping[str, object] = MappingProxyType({}),
    ) -> tuple[int, Iterator[Result]]:
        """Compute the results of the items that have no part yet, and keep them.

        Parameters
        ----------
        label
            What the items are. A part's file is named by a hash of the label, the step's inputs and
            the item.
        items
            All items, in order.
        compute
            Gives results in the order of the items that it is given.
        depends
            Gives the value that is hashed instead of the step's inputs and the item: the part of
            the inputs' content on which the item's result depends.
        given
            Large objects that every run has anyway, by name. In a kept result a reference to one is
            replaced by its name.

        Returns
        -------
        kept
            Number of items whose part is there.
        results
            In the order of the items, as they were written.
        """
        parts = [self._place(label, item, depends) for item in items]
        missing = [_read(part) is None for part in parts]
        return len(items) - sum(missing), self._results(items, parts, missing, compute, given)

    def _results(
        self,
        items: Sequence[Item],
        parts: Sequence[Path],
        missing: Sequence[bool],
        compute: Callable[[Sequence[Item]], Iterator[Result]],
        given: Mapping[str, object],
    ) -> Iterator[Result]:
        """Yield kept results and new ones in the items' order.

        `parts`: the file of each item. `missing`: whether it was not there. A part that was there
        but turns out to be damaged when read is computed again alone.
        """
        lacking = [item for item, lacks in zip(items, missing, strict=True) if lacks]
        computed = iter(compute(lacking) if lacking else ())
        for item, part, lacks in zip(items, parts, missing, strict=True):
            data = None if lacks else _read(part)
            if data is not None:
                yield _PlainData(data, given).load()
            else:
                made = next(computed) if lacks else next(iter(compute([item])))
                yield self._keep(part, made, given)

    def _place(self, label: str, item: Item, depends: Depends[Item] | None) -> Path:
        """Name the file of an item's part by a hash of all that decides its content."""
        decided = (self._inputs, item) if depends is None else depends(item)
        return self._folder / _value_hash((label, decided))

    def _keep(self, part: Path, made: Result, given: Mapping[str, object]) -> Result:
        """Write a result, and return it as read back, so that a resumed run gets the same object.

        A result that cannot be pickled is returned as it is and not kept.
        """
        try:
            data = _write(made, given)
            read: Result = _PlainData(data, given).load()
        except (pickle.PicklingError, pickle.UnpicklingError, AttributeError, TypeError) as error:
            log.warning("%s: a finished part cannot be kept: %s", self._step, error)
            return made
        if self._keeps:
            self._write(part, data)
        return read

    def _write(self, part: Path, data: bytes) -> None:
        """Write a part. If the disk is nearly full, remove all parts and keep none from now on."""
        with storage_errors(self._all):
            try:
                self._folder.mkdir(parents=True, exist_ok=True)
                # Leave as much room free as all parts take: the artifact itself needs it.
                if shutil.disk_usage(self._folder).free > self._bytes + len(data):
                    replace_file(part, hashlib.sha256(data).digest() + data)
                    self._bytes += _HASH_BYTES + len(data)
                    return
            except OSError as error:
                if error.errno not in _FULL:
                    raise
        self._keeps = False
        self.remove()
        log.warning(
            "%s: the disk has no room to keep finished parts: a run that is killed begins this"
            " step anew",
            self._step,
        )


def _value_hash(value: object) -> str:
    """Hash a value by its content, whether equal members of it are one object or several.

    Pickle's memo would write a repeated object as a reference, so that it is switched off.
    """
    data = io.BytesIO()
    pickler = pickle.Pickler(data, protocol=5)
    pickler.fast = True  # without memo
    pickler.dump(value)
    return hashlib.sha256(data.getvalue()).hexdigest()


def _read(part: Path) -> bytes | None:
    """Read what a part holds. None if it is missing, damaged or cannot be read."""
    try:
        content = part.read_bytes()
    except OSError:
        return None
    data = content[_HASH_BYTES:]
    return data if hashlib.sha256(data).digest() == content[:_HASH_BYTES] else None


def _write(result: object, given: Mapping[str, object]) -> bytes:
    """Pickle a result. References to `given` objects are written as their names."""
    data = io.BytesIO()
    _Naming(data, given).dump(result)
    return data.getvalue()


class _Naming(pickle.Pickler):
    """Writes given objects by their name, and members of an enumeration by their value."""

    def __init__(self, file: io.BytesIO, given: Mapping[str, object]) -> None:
        super().__init__(file, protocol=5)
        self._names = {id(value): name for name, value in given.items() if value is not None}

    def persistent_id(self, value: object) -> str | None:
        return self._names.get(id(value))

    def reducer_override(self, value: Any) -> Any:
        """Pickle a member as a call of its class, as Python 3.11.2 would pickle it as getattr."""
        if isinstance(value, enum.Enum):
            return type(value), (value.value,)
        return NotImplemented


class _PlainData(pickle.Unpickler):
    """Unpickles data classes, enumerations and arrays only, so that no other code can be called."""

    def __init__(self, data: bytes, given: Mapping[str, object]) -> None:
        super().__init__(io.BytesIO(data))
        self._given = given

    def persistent_load(self, name: str) -> object:
        return self._given[name]

    def find_class(self, module: str, name: str) -> Any:
        """Allow data classes, structs, enumerations and numpy's own types. Refuse all else."""
        found = super().find_class(module, name)
        package = module.partition(".")[0]
        if package == "numpy" and (name in _OF_NUMPY or module.startswith("numpy.dtypes")):
            return found
        if is_dataclass(found) or isinstance(found, enum.EnumType | msgspec.StructMeta):
            return found
        raise pickle.UnpicklingError(f"{module}.{name} is no data that a part may hold")
