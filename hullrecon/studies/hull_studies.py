# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies that are run on a simulated dive, and those of scenes around a hull."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from hullrecon.studies.methods import variants as method_variants
from hullrecon.studies.study import DiveStudy, SceneStudy, StudyDive, StudyResult


def _compare_methods(given: StudyDive) -> StudyResult:
    """Solve the dive by every method, and tabulate and compare the figures."""
    from hullrecon.studies.methods.comparison import (
        compare_heights,
        compare_solutions,
        comparison_table,
    )

    truth = given.truth  # first: without it nothing is solved
    values = compare_solutions(given.variants, given.start, truth)
    return replace(_table(values, *comparison_table(values)), compared=compare_heights(values))


def _compare_surfaces(given: StudyDive) -> StudyResult:
    """Tabulate the scores of the surfaces of a dive, by variant."""
    from hullrecon.studies.surfaces.comparison import compare_surfaces, surface_table

    values = compare_surfaces(given.dive, given.truth, given.run_context)
    return _table(values, *surface_table(values))


def _compare_links(given: StudyDive) -> StudyResult:
    """Tabulate the scores of the paths by links of a dive, by variant."""
    from hullrecon.studies.matching.comparison import compare_links, link_table

    values = compare_links(given.dive, given.truth, given.run_context)
    return _table(values, *link_table(values))


def _draw_methods(given: StudyDive) -> StudyResult:
    """Draw the figures of the methods, with the heights of objects that are delivered."""
    from hullrecon.studies.methods.figures import draw_method_figures

    truth, variants = given.truth, given.variants
    method_variants.run_to_detect(given.dive, given.run_context)
    objects = method_variants.read_objects(given.dive)
    figures = draw_method_figures(variants, given.start, truth, objects)
    return StudyResult(figures=tuple(figures))


def _draw_paths(given: StudyDive) -> StudyResult:
    """Draw the figures of paths, for which the chain has to have run as far as `detect`."""
    from hullrecon.studies.paths.path_figures import draw_path_figures

    truth, start = given.truth, given.start
    method_variants.run_to_detect(given.dive, given.run_context)
    figures = draw_path_figures(given.dive, start, truth, given.run_context)
    return StudyResult(figures=tuple(figures))


def _draw_scenes() -> StudyResult:
    from hullrecon.studies.scenes.scene_figures import draw_scene_figures

    return StudyResult(figures=tuple(draw_scene_figures()))


def _table(
    values: Mapping[str, object], heads: Sequence[str], rows: Sequence[Sequence[str]]
) -> StudyResult:
    return StudyResult(values=values, heads=tuple(heads), rows=tuple(tuple(row) for row in rows))


HULL_STUDIES: tuple[DiveStudy | SceneStudy, ...] = (
    DiveStudy(
        id="methods",
        source="[Ozog2016 4.2, Fig. 4.10]",
        shows="naive, geva and maxmix, as published and as weighted by us, in one table",
        run=_compare_methods,
    ),
    DiveStudy(
        id="surfaces",
        source="[Ozog2016 3.2.2, 4.3.3 Algorithm 5]",
        shows="the DVL's surface by other kernels, references and interpolation; fusion by rays",
        run=_compare_surfaces,
    ),
    DiveStudy(
        id="links",
        source="[KimEustice2009 III-A; SunderhaufProtzel2012]",
        shows="links with corners beside SIFT features, with switches for a guard, and unguarded",
        run=_compare_links,
    ),
    DiveStudy(
        id="method-figures",
        source="[Ozog2016 Figs 4.10 to 4.14, 4.16]",
        shows="cost and labels by iteration, cross-sections, ranges' residuals, a height",
        run=_draw_methods,
    ),
    DiveStudy(
        id="path-figures",
        source="[KimEustice2009 Figs 3, 4, 5; Ozog2016 Figs 2.22, 2.23, 3.11, 3.12]",
        shows="what links and planes do to the path, and to the sonar mosaic's variance",
        run=_draw_paths,
    ),
    SceneStudy(
        id="scene-figures",
        source="[KimEustice2009 Fig. 2; Ozog2016 Figs D.4, C.1, C.2]",
        shows="choice of two-view model by relief, search ellipses, a sphere mapped by planes",
        run=_draw_scenes,
    ),
)
