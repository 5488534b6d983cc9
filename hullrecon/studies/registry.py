# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of studies: what of the sources is reproduced, and how each study is run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from hullrecon.errors import UsageError
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
class StudyResult:
    """Result of a study: figures, or a table, or both."""

    figures: tuple[PublishedFigure, ...] = ()
    values: Mapping[str, object] = field(default_factory=dict)  # of the table, by row
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, kw_only=True)
class Study:
    """A reproducible result of the sources."""

    id: str  # as `hullrecon study run` takes it
    source: str  # figures and equations, as docs/references.md keys their papers
    shows: str  # one line
    run: Callable[[StudyDive], StudyResult]


def _compare_methods(given: StudyDive) -> StudyResult:
    from hullrecon.studies.methods.comparison import compare_solutions, comparison_table

    truth = given.truth  # first: without it nothing is solved
    values = compare_solutions(given.variants, given.start, truth)
    return _table(values, *comparison_table(values))


def _compare_surfaces(given: StudyDive) -> StudyResult:
    from hullrecon.studies.surfaces.comparison import compare_surfaces, surface_table

    values = compare_surfaces(given.dive, given.truth, given.run_context)
    return _table(values, *surface_table(values))


def _compare_links(given: StudyDive) -> StudyResult:
    from hullrecon.studies.matching.comparison import compare_links, link_table

    values = compare_links(given.dive, given.truth, given.run_context)
    return _table(values, *link_table(values))


def _draw_methods(given: StudyDive) -> StudyResult:
    from hullrecon.studies.methods.figures import draw_method_figures

    truth, variants = given.truth, given.variants
    method_variants.find_objects(given.dive, given.run_context)
    objects = method_variants.read_objects(given.dive)
    return StudyResult(figures=tuple(draw_method_figures(variants, given.start, truth, objects)))


def _draw_paths(given: StudyDive) -> StudyResult:
    from hullrecon.studies.paths.path_figures import draw_path_figures

    truth, start = given.truth, given.start
    method_variants.find_objects(given.dive, given.run_context)
    drawn = draw_path_figures(given.dive, start, truth, given.run_context)
    return StudyResult(figures=tuple(drawn))


def _draw_scenes(given: StudyDive) -> StudyResult:
    from hullrecon.studies.scenes.scene_figures import draw_scene_figures

    return StudyResult(figures=tuple(draw_scene_figures()))


def _table(
    values: Mapping[str, object], heads: Sequence[str], rows: Sequence[Sequence[str]]
) -> StudyResult:
    return StudyResult(values=values, heads=tuple(heads), rows=tuple(tuple(row) for row in rows))


STUDIES = (
    Study(
        id="methods",
        source="[Ozog2016 4.2, Figs 4.10, 4.11]",
        shows="naive, geva and maxmix, as published and as weighted by us, in one table",
        run=_compare_methods,
    ),
    Study(
        id="surfaces",
        source="[Ozog2016 3.2.2, 4.3.3 Algorithm 5]",
        shows="the DVL's surface by other kernels, references and interpolation; fusion by rays",
        run=_compare_surfaces,
    ),
    Study(
        id="links",
        source="[KimEustice2009 III-A; SunderhaufProtzel2012]",
        shows="links with corners beside SIFT features, with switches for a guard, and unguarded",
        run=_compare_links,
    ),
    Study(
        id="method-figures",
        source="[Ozog2016 Figs 4.10 to 4.14, 4.16]",
        shows="cost and labels by iteration, cross-sections, ranges' residuals, a height",
        run=_draw_methods,
    ),
    Study(
        id="path-figures",
        source="[KimEustice2009 Figs 4, 5; Ozog2016 Figs 2.22, 2.23, 3.11, 3.12]",
        shows="what links and planes do to the path, and to the sonar mosaic's variance",
        run=_draw_paths,
    ),
    Study(
        id="scene-figures",
        source="[KimEustice2009 Fig. 2; Ozog2016 Figs D.4, C.1, C.2]",
        shows="choice of two-view model by relief, search ellipses, a sphere mapped by planes",
        run=_draw_scenes,
    ),
)
FIGURES = ("method-figures", "path-figures", "scene-figures")  # those that draw


def find_study(name: str) -> Study:
    """Look a study up. Raises UsageError for an unknown id."""
    found = {study.id: study for study in STUDIES}.get(name)
    if found is None:
        raise UsageError(f"no study is called {name!r}", remedy="see `hullrecon study list`")
    return found
