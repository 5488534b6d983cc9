# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.surface import Surface
from hullrecon.report.content.deviation import weighted_percentiles
from hullrecon.report.figures.hull_map import (
    Extent,
    SigmaEllipse,
    charted_objects,
    extent_of,
    hull_map,
    project_surface,
    sigma_ellipse,
)
from hullrecon.report.figures.map_pictures import ground_png
from hullrecon.report.figures.plan_view import (
    LEFT,
    TOP,
    WIDTH,
    Mark,
    Plan,
    nice_below,
    nice_step,
    plan_svg,
)
from hullrecon.report.survey import Survey

EXTENT = Extent(along=(30.0, 40.0), girth=(2.0, 7.0))
PLAN = Plan(
    extent=EXTENT,
    path=np.array([[31.0, 6.0], [39.0, 6.0], [np.nan, 0], [39.0, 3.0]]),
    path_sigma=(0.5, 0.02),
    marks=[
        Mark(
            label="4",
            along=35.0,
            girth=4.5,
            text="a lump",
            ellipse=SigmaEllipse(half_axes=(0.5, 0.02), angle_rad=0.1),
        )
    ],
)


def circles(svg: str) -> list[tuple[float, float, str]]:
    root = ElementTree.fromstring(svg)
    found = [e for e in root.iter() if e.tag.endswith("circle")]
    return [
        (float(e.get("cx", "nan")), float(e.get("cy", "nan")), e.get("class", "")) for e in found
    ]


def test_the_plan_is_true_to_scale() -> None:
    (mark,) = [c for c in circles(plan_svg(PLAN, "t")) if c[2] == "object"]
    assert mark[:2] == pytest.approx((LEFT + WIDTH / 2, TOP + WIDTH / 4), abs=0.1)


def test_a_flipped_plan_has_forward_to_the_left() -> None:
    flipped = replace(PLAN, extent=replace(EXTENT, flips=(True, True)))
    start, plain = (
        next(c for c in circles(plan_svg(p, "t")) if c[2] == "start") for p in (flipped, PLAN)
    )
    assert plain[0] - LEFT == pytest.approx(0.1 * WIDTH, abs=0.1)
    assert start[0] - LEFT == pytest.approx(0.9 * WIDTH, abs=0.1)
    assert plain[1] - TOP == pytest.approx(0.2 * WIDTH / 2, abs=0.1)
    assert start[1] - TOP == pytest.approx(0.8 * WIDTH / 2, abs=0.1)


def test_a_gap_in_the_path_is_not_bridged() -> None:
    root = ElementTree.fromstring(plan_svg(PLAN, "t"))
    path = next(e for e in root.iter() if e.get("class") == "path")
    assert len(re.findall("M", path.get("d", ""))) == 2


def test_the_uncertainty_is_drawn_and_said() -> None:
    svg = plan_svg(PLAN, "t")
    assert "one sigma of the vehicle: 0.500 m along, 0.020 m in girth" in svg
    ellipse = next(e for e in ElementTree.fromstring(svg).iter() if e.tag.endswith("ellipse"))
    assert float(ellipse.get("rx", "0")) == pytest.approx(0.5 * WIDTH / 10, abs=0.1)


def test_words_in_the_plan_are_escaped() -> None:
    mark = Mark(label="4", along=35.0, girth=4.5, text='a "lump" <of> something')
    texts = {
        e.text
        for e in ElementTree.fromstring(plan_svg(replace(PLAN, marks=[mark]), "a < b & c")).iter()
    }
    assert {"a < b & c", 'a "lump" <of> something'} <= texts


def test_frame_numbers_stand_beside_metres() -> None:
    svg = plan_svg(replace(PLAN, frame_spacing_m=0.6), "t")
    assert ">36 m<" in svg
    assert ">fr 60.0<" in svg


def ticks(svg: str) -> list[str]:
    """The words of the ticks along both axes and of the frames, without the path's ends."""
    texts = [e for e in ElementTree.fromstring(svg).iter() if e.tag.endswith("text")]
    return [
        str(e.text)
        for e in texts
        if e.get("class") in ("tick mid", "tick end") and "sigma" not in str(e.text)
    ]


@pytest.mark.parametrize("spacing_m", [0.55, 0.7, 0.8, 1.2, 2.4])
@pytest.mark.parametrize("half_m", [0.4, 0.45, 1.0, 3.0, 40.0])
def test_no_two_ticks_of_the_plan_read_alike(half_m: float, spacing_m: float) -> None:
    middle = 163.87  # far from AP, where few digits are left
    extent = Extent(
        along=(middle - half_m, middle + half_m), girth=(11.3 - half_m / 2, 11.3 + half_m / 2)
    )
    plan = replace(PLAN, extent=extent, marks=[], frame_spacing_m=spacing_m)
    found = ticks(plan_svg(plan, "t"))
    along, frames = ([t for t in found if ("fr" in t) == is_frame] for is_frame in (False, True))
    assert len(frames) > 3
    assert len(set(frames)) == len(frames), frames
    assert len(set(along)) == len(along), along


def test_steps_are_one_two_or_five_times_a_power_of_ten() -> None:
    assert [nice_step(s) for s in (10.0, 11.0, 180.0, 0.4)] == pytest.approx([1.0, 2.0, 20.0, 0.05])
    assert [nice_below(s) for s in (0.3, 0.5, 1.9, 70.0)] == pytest.approx([0.2, 0.5, 1.0, 50.0])


def test_the_extent_has_a_margin_and_leaves_lost_points_out() -> None:
    extent = extent_of(
        np.array([[1.0, 2.0], [3.0, 5.0], [np.nan, 9.0]]), (False, False), margin_m=0.5
    )
    assert (extent.along, extent.girth) == ((0.5, 3.5), (1.5, 5.5))


def test_percentiles_go_by_weight() -> None:
    values, weights = np.array([3.0, 1.0, 2.0]), np.array([1.0, 98.0, 1.0])
    assert weighted_percentiles(values, weights, (50,))[0] == pytest.approx(1.0, abs=0.03)
    even = weighted_percentiles(np.arange(1001.0), np.ones(1001), (5, 95))
    np.testing.assert_allclose(even, [50, 950], atol=1)


def test_only_seen_faces_are_painted(survey: Survey, plate: Surface) -> None:
    view = hull_map(survey)
    assert view is not None
    assert view.found is not None
    assert len(view.found.seen_faces()) == 8
    picture = np.asarray(
        Image.open(
            BytesIO(ground_png(view.found, Extent(along=(-1.0, 3.0), girth=(-2.0, 0.0)), 400))
        )
    )
    assert (picture[20:-20, 10:180, 3] == 255).all()  # x from -1 to 1 was seen
    assert (picture[:, 220:, 3] == 0).all()


def test_faces_across_the_seam_of_the_chart_are_left_out(plate: Surface) -> None:
    class Seam:
        def to_chart(self, points: np.ndarray) -> np.ndarray:
            return np.column_stack(
                [
                    points[:, 0],
                    np.where(points[:, 1] < -0.5, points[:, 1] + 40, points[:, 1]),
                    points[:, 2],
                ]
            )

    assert len(project_surface(plate, Seam()).faces) == 8  # type: ignore[arg-type]


def test_a_chart_seen_from_inside_is_drawn_flipped(survey: Survey) -> None:
    view = hull_map(survey)
    assert view is not None
    assert view.extent.flips == (True, False)


def test_an_ellipse_has_the_axes_of_its_covariance() -> None:
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    ellipse = sigma_ellipse(turn @ np.diag([0.09, 0.0004]) @ turn.T)
    assert ellipse.half_axes == pytest.approx((0.3, 0.02))
    assert np.tan(ellipse.angle_rad) == pytest.approx(np.tan(0.3))


@pytest.mark.parametrize(
    ("flips", "degrees"), [((False, False), -10.0), ((True, False), -170.0), ((False, True), 10.0)]
)
def test_an_ellipse_turns_with_the_picture(flips: tuple[bool, bool], degrees: float) -> None:
    mark = replace(
        PLAN.marks[0], ellipse=SigmaEllipse(half_axes=(0.5, 0.02), angle_rad=np.radians(10))
    )
    svg = plan_svg(replace(PLAN, marks=[mark], extent=replace(EXTENT, flips=flips)), "t")
    drawn = next(e for e in ElementTree.fromstring(svg).iter() if e.tag.endswith("ellipse"))
    assert float(re.findall(r"rotate\(([-0-9.]+)", drawn.get("transform", ""))[0]) == pytest.approx(
        degrees
    )


def test_each_object_has_the_ellipse_of_its_own_place(
    survey: Survey, found: ReportedObject
) -> None:
    unknown = replace(found, position_covariance=None)
    assert survey.surfaces.chart is not None
    placed = charted_objects([found, unknown], survey.surfaces.chart)
    ellipse, none = (one.ellipse for one in placed)
    assert ellipse is not None
    assert ellipse.half_axes == pytest.approx((0.3, 0.02))
    assert none is None


def test_the_vehicles_sigma_is_given_along_and_in_girth(survey: Survey) -> None:
    chart = survey.surfaces.chart
    assert chart is not None
    np.testing.assert_allclose(survey.track.sigma_on_chart(chart), (0.5, 0.02), rtol=1e-6)
