# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a study is: what it reproduces, what it is run on, and what comes out of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar

from hullrecon.studies.methods import variants as method_variants

if TYPE_CHECKING:
    from hullrecon.api.dive_run import DiveRun
    from hullrecon.artifacts.runner import RunContext
    from hullrecon.evaluation.truth import Truth
    from hullrecon.studies.figure_style import PublishedFigure
    from hullrecon.studies.methods.comparison import DeadReckoning, SolvedVariant


@dataclass(frozen=True)
class StudyDive:
    """A simulated dive with the products that studies need, each made when first asked for."""

    dive: DiveRun
    run_context: RunContext

    @cached_property
    def truth(self) -> Truth:
        """Read the truth of the package. Raises InputError when it holds none."""
        from hullrecon.evaluation.truth import read_truth

        return read_truth(self.dive.chain.package)

    @cached_property
    def variants(self) -> list[SolvedVariant]:
        """Solve the dive by every method and weighting."""
        method_variants.solve_all(self.dive, self.run_context)
        return method_variants.read_solutions(self.dive)

    @cached_property
    def start(self) -> DeadReckoning:
        """Read the dead-reckoned dive, which every method starts from."""
        method_variants.run_before_adjust(self.dive, self.run_context)
        return method_variants.read_dead_reckoning(self.dive)


@dataclass(frozen=True, kw_only=True)
class ComparedValue:
    """A number that a source prints, with ours beside it."""

    what: str  # of what, in a few words
    unit: str = ""  # empty for a pure number
    printed: float | None = None  # None where the source gives it in words alone
    ours: float | None  # None where the run gives none
    note: str = ""  # what the source says in words, or why ours differs


@dataclass(frozen=True, kw_only=True)
class StudyResult:
    """Result of a study: figures, a table, numbers beside the printed ones, or all of them."""

    figures: tuple[PublishedFigure, ...] = ()
    values: Mapping[str, object] = field(default_factory=dict)  # of the table, by row
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    compared: tuple[ComparedValue, ...] = ()  # besides those of its figures


@dataclass(frozen=True, kw_only=True)
class Study:
    """A reproducible result of the sources."""

    needs_dive: ClassVar[bool]
    id: str  # as `hullrecon study run` takes it
    source: str  # figures and equations, as docs/references.md keys their papers
    shows: str  # one line


@dataclass(frozen=True, kw_only=True)
class DiveStudy(Study):
    """A study of a simulated dive."""

    needs_dive = True
    run: Callable[[StudyDive], StudyResult]


@dataclass(frozen=True, kw_only=True)
class SceneStudy(Study):
    """A study of scenes that it makes itself, the same at every run."""

    needs_dive = False
    run: Callable[[], StudyResult]


@dataclass(frozen=True)
class StudyFunction:
    """A study's function, imported when it is first asked for: most commands run none."""

    path: str  # below hullrecon.studies

    def load(self) -> Callable[..., StudyResult]:
        """Import the function."""
        module, _, name = self.path.rpartition(".")
        found: Callable[..., StudyResult] = getattr(
            import_module(f"hullrecon.studies.{module}"), name
        )
        return found

    def __call__(self, *given: StudyDive) -> StudyResult:
        """Run the study, on a dive if it takes one."""
        return self.load()(*given)
