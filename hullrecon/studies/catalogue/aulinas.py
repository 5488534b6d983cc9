# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every part of [Aulinas2011], and where it is here."""

from __future__ import annotations

from hullrecon.studies.catalogue.part import Absence, Chapter, Misprint, Part, Source, Survey

_ONE_PROBLEM = (
    "a dive is one problem: no information between parts is dropped, and none is counted twice"
)
_NO_SONAR_OBJECTS = "in the product objects are found by images; sonar is blended, not searched"
_SIMULATED_SONAR = f"simulated side-scan images; {_NO_SONAR_OBJECTS}"

_NO_LASER = "no laser and no land vehicle in the product"

_INTRODUCTION = Chapter(
    title="1, 2. Introduction, state of the art",
    parts=(
        Part("Figs 1.1 to 1.6", "structures, vehicles, laboratories", absent=Absence.PICTURE),
        Part("Fig. 2.1", "what SLAM is", absent=Absence.PICTURE),
        Part("Table 2.1", "filters: strengths and weaknesses", absent=Absence.LITERATURE),
        Part(
            "Fig. 2.2",
            "consistency index of EKF and of submaps over a loop",
            printed="EKF rises above 1, submaps stay below; curves alone",
            studies=("submap-consistency",),
            code=("hullrecon/studies/submaps/consistency_study.py:study_consistency",),
            differs="laps around a square in place of one loop, mean of ten runs, no ellipses; our "
            "submaps take Jacobians at first estimates, as in the row of Fig. 3.6, and the study "
            "also gives the index of the printed ones, with finer sensors too, and with a laser "
            "that reads what the car runs over",
        ),
        Part(
            "Fig. 2.3",
            "tree of joins (divide and conquer)",
            studies=("joining-schemes/tree_of_joins",),
            code=("hullrecon/studies/schemes/schemes_study.py:tree_of_joins",),
            tests=(
                "tests/studies/schemes/test_schemes.py::test_a_tree_of_joins_ends_with_every_landmark_once",
            ),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "Fig. 2.4",
            "graph of submaps (hierarchical)",
            studies=("joining-schemes/graph_of_submaps",),
            code=("hullrecon/studies/schemes/schemes_study.py:graph_over_time",),
            tests=(
                "tests/studies/schemes/test_schemes.py::test_a_closed_loop_shrinks_the_last_frame",
            ),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "Fig. 2.5",
            "submaps that share variables (conditionally independent)",
            studies=("joining-schemes/shared_variables",),
            code=("hullrecon/studies/schemes/shared_variables.py:in_two_submaps",),
            tests=(
                "tests/studies/schemes/test_schemes.py::test_two_submaps_that_share_variables_are_one_estimate",
            ),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "Table 2.2",
            "submapping methods: memory and time",
            absent=Absence.LITERATURE,
            differs="below, with ours as a row; those of LMJ, HS, DCS and CIS are built: Table 3.2",
        ),
        Part("Figs 2.6 to 2.9", "results of other groups", absent=Absence.PICTURE),
        Part(
            "Table 2.3",
            "underwater SLAM: sensor, map, filter",
            absent=Absence.LITERATURE,
            differs="below, with ours as a row",
        ),
        Part(
            "Table 2.4",
            "detection in side-scan sonar",
            absent=Absence.LITERATURE,
            differs="below, with ours as a row",
        ),
        Part(
            "Fig. 2.10",
            "artefacts of underwater images: scatter, blur, uneven light",
            studies=("regions-of-interest",),
            code=(
                "hullrecon/studies/targets/sea_floor.py:look",
                "hullrecon/synthetic/texture.py",
                "hullrecon/synthetic/rendering.py",
            ),
            tests=("tests/synthetic/sensors/test_photographs.py",),
            differs="lamp and attenuation are simulated, sun flicker is not",
        ),
        Part(
            "Table 2.5",
            "features of optical images",
            absent=Absence.LITERATURE,
            differs="below, with ours as a row",
        ),
        Part(
            "2.4, smoothing",
            "Rauch-Tung-Striebel: backward over a filter's states",
            studies=("filters",),
            code=("hullrecon/studies/submaps/filters.py:smooth",),
            tests=(
                "tests/studies/submaps/test_filters.py::test_smoother_is_the_batch_for_every_state",
            ),
            differs="in the product a batch solve smooths",
        ),
        Part(
            "2.4, positioning",
            "long, short and ultra-short baselines, GPS",
            code=(
                "hullrecon/estimation/position_tables.py:with_positions",
                "hullrecon/dive/logs/positions.py:position_fixes",
            ),
            tests=(
                "tests/navigation/test_positions.py::test_fixes_bound_the_drift_of_a_dive_without_a_camera",
            ),
            differs="positions of USBL or GPS; no ranges to beacons",
        ),
    ),
)
_FILTERS = Chapter(
    title="3.2. Filters",
    parts=(
        Part(
            "3.2.1, Table 3.1",
            "notation: its letters stand in the filters' docstrings",
            code=("hullrecon/studies/submaps/filters.py",),
            studies=("filters",),
            differs="x and z are `mean` and `observed`, F and H both `by_state`, u is `offset`; "
            "letters stand in comments",
        ),
        Part(
            "3.2.2, 3.2.3, eqs (3.1) to (3.3)",
            "a Gaussian state; motion and observation that are linear with Gaussian noise",
            studies=("filters",),
            code=(
                "hullrecon/studies/submaps/filters.py:Gaussian",
                "hullrecon/studies/submaps/filters.py:LinearStep",
            ),
            tests=("tests/studies/submaps/test_filters.py",),
            differs="the density (3.1) is kept as its mean and covariance; B u is one vector",
        ),
        Part(
            "3.2.4, Algorithm 1",
            "Kalman filter",
            studies=("filters",),
            code=(
                "hullrecon/studies/submaps/filters.py:filter_steps",
                "hullrecon/studies/submaps/filters.py:predict",
                "hullrecon/studies/submaps/filters.py:update",
            ),
            tests=("tests/studies/submaps/test_filters.py",),
            differs=(
                "covariance in Joseph's form, as line 8 is a misprint (below); the product solves "
                "in one batch, to which an information filter is equal "
                "(tests/native/test_information_filter.py)"
            ),
        ),
        Part(
            "3.2.5 to 3.2.7, Algorithm 2, eqs (3.4) to (3.6)",
            "extended Kalman filter",
            studies=("filters", "submap-world"),
            code=(
                "hullrecon/studies/submaps/filters.py:predict",
                "hullrecon/studies/submaps/filters.py:update",
                "hullrecon/studies/submaps/ekf_slam.py:EkfMap",
            ),
            tests=("tests/studies/submaps/test_filters.py",),
            differs="`predict` and `update` are given values and Jacobians of g and h; study "
            "`filters` is linear, `submap-world` is not: there `EkfMap` has both, of a car and its "
            "laser; the product solves in one batch, linearised anew at every step",
        ),
    ),
)
_SUBMAPS = Chapter(
    title="3.3. Selective submap joining",
    parts=(
        Part(
            "3.3, Algorithm 3",
            "selective submap joining: main loop",
            studies=("submap-world",),
            code=("hullrecon/studies/submaps/selective.py:SelectiveJoining",),
            tests=("tests/studies/submaps/test_joining.py",),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "3.3.1, Algorithm 4, eqs (3.7) to (3.11)",
            "a submap by EKF-SLAM: prediction and update",
            printed="at most 15 landmarks",
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/ekf_slam.py:build_map",
                "hullrecon/studies/submaps/ekf_slam.py:EkfMap",
                "hullrecon/studies/submaps/ekf_slam.py:update_state",
                "hullrecon/studies/submaps/models.py:observe_jacobians",
            ),
            tests=(
                "tests/studies/submaps/test_joining.py::test_our_submaps_end_as_surely_as_they_say_and_the_printed_ones_do_not",
                "tests/studies/submaps/test_joining.py::test_a_car_that_stands_learns_its_heading_only_as_printed",
            ),
            differs="(3.7) is `EkfMap.predict`, F of (3.8) in `Car.move_steps`, H of (3.9) "
            "`observe_jacobians`, (3.10) `EkfMap.update`, (3.11) `update_state`; rows of zeros are "
            f"left out unless its time is compared; {_ONE_PROBLEM}",
        ),
        Part(
            "3.3.2, eq (3.12), Fig. 3.1",
            "global map of transforms between submaps",
            code=(
                "hullrecon/studies/submaps/global_map.py:GlobalMap",
                "hullrecon/navigation/pose_graph/graph.py:relative_covariance",
            ),
            studies=("submap-world",),
            tests=(
                "tests/studies/submaps/test_joining.py::test_chained_transforms_have_their_derivatives",
            ),
            differs=(
                "relative poses with joint covariance by the pose graph, for nodes instead of "
                "submaps"
            ),
        ),
        Part(
            "3.3.3, eqs (3.13) to (3.15)",
            "two submaps joined and fused",
            code=(
                "hullrecon/studies/submaps/join.py:refer_to_base",
                "hullrecon/studies/submaps/join.py:landmarks_in_one_frame",
                "hullrecon/studies/submaps/join.py:fuse",
                "native/solve/joined_problem.cpp",
                "hullrecon/change/offset.py:estimate_offset",
            ),
            tests=(
                "tests/studies/submaps/test_joining.py::test_fused_maps_are_as_sure_as_they_say",
                "tests/native/test_parts.py",
            ),
            studies=("submap-world",),
            differs=(
                "(3.13), (3.14) are `refer_to_base`; selective joining takes "
                "`landmarks_in_one_frame`, with what both maps' transforms have in common. (3.15) "
                "is `fuse`, linearised up to three times, not once. In the product a problem "
                "solved in parts gives the whole one's numbers; two dives are laid on each other "
                "by one offset"
            ),
        ),
        Part(
            "3.3.4, Fig. 3.2",
            "a loop is closed where submaps share enough; time by threshold",
            printed="least at 40 to 50 % of the landmarks of a submap",
            code=(
                "hullrecon/studies/submaps/loops.py:Proximity",
                "hullrecon/vision/pairs/selection.py:propose_revisits",
            ),
            studies=("submap-threshold",),
            tests=(
                "tests/studies/submaps/test_joining.py::test_no_two_maps_are_fused_that_share_too_little",
            ),
            differs=(
                "images are compared where they probably overlap; every link that stands counts"
            ),
        ),
    ),
)
_EXPERIMENTS = Chapter(
    title="3.4. Experiments",
    parts=(
        Part(
            "Fig. 3.3, eqs (3.16) to (3.20)",
            "car with steering wheel, laser range and bearing",
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/models.py:Car",
                "hullrecon/studies/submaps/models.py:observe",
                "hullrecon/studies/submaps/models.py:observe_jacobians",
                "hullrecon/studies/submaps/ekf_slam.py:EkfMap",
            ),
            tests=("tests/studies/submaps/test_models.py",),
            differs="(3.16) is the state of `EkfMap`, (3.17) `Car.move`, (3.18) in "
            "`Car.move_steps`, (3.19) `observe`, (3.20) `observe_jacobians`; sizes of the car are "
            "Victoria Park's, as none is printed; no land vehicle in the product",
        ),
        Part(
            "3.4.1, Fig. 3.4",
            "441 landmarks, surveyed in lines",
            printed="dead reckoning off by 25 %, joined below 2.5 %",
            studies=("submap-world",),
            code=("hullrecon/studies/submaps/worlds.py:simulate_survey",),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "Fig. 3.5",
            "two submaps before and after fusion",
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/join.py:fuse",
                "hullrecon/studies/submaps/world_figures.py:draw_fusion",
            ),
            differs=_ONE_PROBLEM,
        ),
        Part(
            "Fig. 3.6, eq (3.21)",
            "normalised error squared (NEES) of the selective map against truth",
            printed="inside the bound throughout",
            benchmarks=("benchmarks/dives.py",),
            tests=(
                "tests/studies/submaps/test_joining.py::test_our_submaps_end_as_surely_as_they_say_and_the_printed_ones_do_not",
                "tests/studies/submaps/test_joining.py::test_a_car_that_stands_learns_its_heading_only_as_printed",
                "tests/benchmarks/test_dives.py::test_errors_of_three_and_four_sigma_are_a_nees_of_25",
            ),
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/missions.py:nees",
                "hullrecon/studies/submaps/end_errors.py:compare_ends",
                "hullrecon/studies/submaps/repeated.py:repeat_world",
                "hullrecon/studies/submaps/world_figures.py:draw_consistency",
            ),
            differs="the mean of twenty missions; the benchmark has that of simulated dives. Our "
            "submaps are inside the band of where they end, in their own frames: NEES 2.95, band "
            "2.89 to 3.11. They take Jacobians at first estimates [Huang2010], in place of the "
            "newest, (3.8) and (3.9), by which the filter seems to learn its heading from readings "
            "that do not tell it. As printed, submaps are outside, at 3.19, and one filter over a "
            "whole mission many times. By first estimates the mission is below the bound at 99 % "
            "of the scans, by one filter at 96 %",
        ),
        Part(
            "Table 3.2",
            "time of six methods",
            printed="EKF 2,028 s; LMJ 92.48, DCS 83.73, HS 78.37, CIS 85.26, SSJS 78.88 s",
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/shared.py:SharedSeparators",
                "hullrecon/studies/submaps/hierarchy.py:Hierarchy",
                "hullrecon/studies/submaps/sequence.py:JoinedSequence",
                "hullrecon/studies/submaps/world_study.py:table",
            ),
            tests=(
                "tests/studies/submaps/test_joining.py::test_maps_that_share_their_borders_are_one_filter",
                "tests/studies/submaps/test_joining.py::test_one_filter_multiplies_ten_times_as_often_on_more_landmarks",
                "tests/studies/submaps/test_joining.py::test_whole_matrices_as_printed_are_the_same_filter_at_more_work",
            ),
            differs=(
                "the filter multiplies F and H with their zeros, as (3.7) and (3.20) print them; "
                "one that leaves them out stands in a row of its own. " + _ONE_PROBLEM
            ),
        ),
        Part(
            "Table 3.3",
            "error of map and localisation of six methods",
            printed="SSJS mean 0.196 m and 0.537 m, EKF 0.589 m and 0.727 m",
            studies=("submap-world",),
            code=(
                "hullrecon/studies/submaps/world_study.py:table",
                "hullrecon/studies/submaps/repeated.py:compare_repeated",
            ),
            differs="also in twenty worlds: a submap begins without what the one before had in "
            f"view, so most worlds end nearer by one filter, a few metres off; {_ONE_PROBLEM}",
        ),
        Part(
            "3.4.2, Fig. 3.7",
            "Victoria Park: track and trees beside GPS",
            printed="197 x 93 m, 4 km, 26 min",
            studies=("submap-park",),
            code=(
                "hullrecon/studies/submaps/park.py:read_victoria_park",
                "hullrecon/studies/submaps/park_study.py:draw_track",
            ),
            tests=("tests/studies/submaps/test_park.py",),
            differs="a simulated park, unless `victoria-park/` holds the three public files; "
            + _NO_LASER,
        ),
        Part("Fig. 3.8", "the car", absent=Absence.PICTURE),
        Part(
            "Fig. 3.9, eq (3.22)",
            "normalised innovation without truth",
            printed="EKF leaves the bound, submaps do not",
            code=(
                "hullrecon/studies/submaps/ekf_slam.py:update_state",
                "hullrecon/studies/submaps/park_study.py:within",
                "hullrecon/studies/submaps/park_study.py:draw_innovations",
                "hullrecon/adjustment/results/summary.py:residual_figures",
            ),
            delivered=("summary.json", "plots/"),
            tests=(
                "tests/native/test_pair_covariance.py::test_the_innovation_of_a_true_candidate_is_chi_square",
            ),
            studies=("submap-park",),
            differs="a simulated park, a tenth as long, for one filter and the submaps; the "
            "public files, where `victoria-park/` holds them, give the share within the bound. "
            "Simulated readings are as noisy as the filter believes, so that one filter need not "
            "leave the bound. In the product residuals in sigmas by sensor",
        ),
        Part(
            "Fig. 3.10",
            "time over the mission by method",
            studies=("submap-park",),
            code=(
                "hullrecon/studies/submaps/park_study.py:drive",
                "hullrecon/studies/submaps/park_study.py:draw_costs",
            ),
            differs="a simulated park; " + _ONE_PROBLEM,
        ),
    ),
)
_FEATURES = Chapter(
    title="4. Features and association",
    parts=(
        Part("Figs 4.1 to 4.3", "maps of points and of lines; a laser", absent=Absence.PICTURE),
        Part(
            "4.2, 4.2.1, 4.2.3, Figs 4.4, 4.5, 4.7",
            "centre of a tree trunk from a laser scan",
            printed="returns from 3 to 40 m",
            studies=("tree-trunks",),
            code=("hullrecon/studies/association/trunks.py:find_trunks",),
            tests=("tests/studies/association/test_trunks.py",),
            differs="simulated scans; tangents lie half a beam outside of the beams that hit. The "
            f"park's map (4.2.3, Fig. 4.1) is study `submap-park`; {_NO_LASER}",
        ),
        Part(
            "4.2.2, Fig. 4.6",
            "association: nearest neighbour, joint compatibility, randomised",
            code=(
                "hullrecon/studies/association/methods.py:nearest_neighbours",
                "hullrecon/studies/association/methods.py:joint_compatibility",
                "hullrecon/studies/association/methods.py:randomised_compatibility",
                "hullrecon/change/objects.py:match_objects",
                "hullrecon/vision/appearance/consistency.py:largest_group",
            ),
            studies=("association",),
            tests=("tests/studies/association/test_methods.py",),
            differs=(
                "by place alone, as printed, on simulated sets; in the product objects of two "
                "dives by best pairs inside a gate, links of one place by the largest group that "
                "agrees"
            ),
        ),
        Part(
            "4.3, 4.3.1, Fig. 4.9",
            "objects in side-scan sonar by two thresholds: bright spot and shadow",
            studies=("side-scan-thresholds",),
            code=("hullrecon/studies/targets/thresholds.py:detect_by_thresholds",),
            tests=("tests/studies/targets/test_side_scan.py",),
            differs=f"the floor is levelled over range first; {_SIMULATED_SONAR}",
        ),
        Part(
            "Figs 4.8, 4.17 to 4.19", "a side-scan image; how sensors look", absent=Absence.PICTURE
        ),
        Part(
            "Figs 4.10 to 4.13",
            "Haar features and the integral image",
            studies=("side-scan-cascade",),
            code=(
                "hullrecon/studies/targets/haar.py:Rectangles",
                "hullrecon/studies/targets/haar.py:integral_images",
                "hullrecon/studies/targets/haar.py:sum_in",
            ),
            tests=("tests/studies/targets/test_side_scan.py::test_four_look_ups_sum_a_rectangle",),
            differs="windows cut in two alone; means of both parts are compared, not sums, which "
            f"move with the floor's level; {_SIMULATED_SONAR}",
        ),
        Part(
            "Figs 4.14, 4.15",
            "which features tell objects from ground",
            printed="8 dark to 1 bright is best",
            studies=("side-scan-cascade",),
            code=("hullrecon/studies/targets/haar.py:separation",),
            tests=(
                "tests/studies/targets/test_side_scan.py::test_first_feature_is_some_8_to_1_dark_to_bright",
            ),
            differs=_SIMULATED_SONAR,
        ),
        Part(
            "4.3.2, 4.3.3, Fig. 4.16, Table 4.1",
            "cascade of classifiers: what each layer has to reach",
            printed="99.9 % at 50 % to 99 % at 0.05 %, with 1 to 30 features",
            studies=("side-scan-cascade",),
            code=("hullrecon/studies/targets/cascade.py:train_cascade",),
            tests=("tests/studies/targets/test_side_scan.py",),
            differs=_SIMULATED_SONAR,
        ),
        Part(
            "4.3.4, Table 4.2",
            "cascade: what was reached",
            printed="99.5 and 53 %, 99.3 and 6 %, 99.2 and 1 % with 1, 2, 4 features",
            studies=("side-scan-cascade",),
            code=("hullrecon/studies/targets/detector_trials.py:try_cascade",),
            tests=(
                "tests/studies/targets/test_side_scan.py::test_cascade_detects_99_percent_at_1_percent_false_with_4_features",
            ),
            differs=_SIMULATED_SONAR,
        ),
        Part(
            "4.3, targets on the map",
            "targets of several passes paired by joint compatibility, placed, with covariance",
            studies=("sonar-targets",),
            code=("hullrecon/studies/targets/sonar_targets.py:place_targets",),
            tests=("tests/studies/targets/test_sonar_targets.py",),
            differs="no section of the source: it places targets by its filter alone (5.2); here "
            f"by least squares over passes and mount, with a p-value; {_NO_SONAR_OBJECTS}",
        ),
        Part(
            "4.4, 4.4.1, Fig. 4.20",
            "images evened out, undistorted",
            studies=("regions-of-interest",),
            code=(
                "hullrecon/studies/targets/regions.py:even_out",
                "hullrecon/geometry/undistortion.py:undistortion",
                "hullrecon/vision/features/extraction.py:_level",
                "hullrecon/mosaic/imagery/radiometry.py:solve_light",
            ),
            tests=(
                "tests/mosaic/test_radiometry.py::test_a_corrected_image_of_an_even_plate_is_even",
            ),
            differs="light is divided by a wide blur of itself, not as the source cites; "
            "in the product the lamp's field is solved for from overlaps; sun flicker is "
            "not taken out; the study's images have no distortion",
        ),
        Part(
            "4.4.1, Fig. 4.21",
            "regions of interest by edges and by hue",
            printed="627 of 3,199 frames have one",
            studies=("regions-of-interest",),
            code=("hullrecon/studies/targets/regions.py:find_regions",),
            tests=("tests/studies/targets/test_regions.py",),
            differs=(
                "objects are found by their height; paint and rust without relief are no objects"
            ),
        ),
        Part(
            "4.4.2, Fig. 4.22",
            "features matched over a quarter turn, gated by the map's uncertainty",
            studies=("regions-of-interest",),
            code=(
                "hullrecon/vision/pairs/matching.py:_within_ellipses",
                "hullrecon/vision/features/descriptors.py:best_of_pairs",
            ),
            tests=("tests/vision/pairs/test_gating.py::test_ellipse_is_that_of_many_random_draws",),
            differs="SIFT in place of SURF",
        ),
        Part(
            "4.4.3, Fig. 4.23",
            "calibration from images of a board",
            printed="principal point known to some 10 px",
            studies=("board-calibration/board_views",),
            tests=(
                "tests/studies/calibration/test_board.py::test_sigmas_are_those_of_the_scatter",
            ),
            code=(
                "hullrecon/studies/calibration/board.py:calibrate",
                "hullrecon/adjustment/problem/intrinsics.py:free_intrinsics",
                "hullrecon/dive/config/calibration.py",
            ),
            differs="simulated views of the board; the other results of 4.4.3 are rows 4.4.1 "
            "(frames with a region) and 5.3.3; in the product calibrations are read, and the "
            "adjustment corrects them",
        ),
    ),
)
_VEHICLES = Chapter(
    title="5. Underwater vehicles",
    parts=(
        Part(
            "Figs 5.1 to 5.3, 5.8 to 5.11",
            "mosaics of others, vehicles, frames, sensor drawings",
            absent=Absence.PICTURE,
        ),
        Part(
            "5.2, 5.3, eq (5.1)",
            "one state of vehicle, depth of the floor and landmarks",
            studies=("remus-run", "sparus-run"),
            code=(
                "hullrecon/studies/vehicles/local_map.py:LocalMap",
                "hullrecon/studies/vehicles/sensors.py:VEHICLE",
            ),
            tests=("tests/studies/vehicles/test_models.py",),
            differs="each submap has its own; SPARUS' has nine numbers without the floor, and six "
            "of each landmark; the tenth is the floor's depth, not its distance. In the product "
            "poses, hull and landmarks are one batch (hullrecon/native/problem.py)",
        ),
        Part(
            "5.2.1, 5.3.1, eqs (5.2), (5.3), (5.15)",
            "constant velocity in six or four degrees of freedom",
            code=(
                "hullrecon/studies/vehicles/motion.py:move",
                "hullrecon/studies/vehicles/motion.py:move_level",
                "hullrecon/estimation/navigation_tables.py:velocity_table",
            ),
            studies=("remus-run", "sparus-run"),
            tests=(
                "tests/studies/vehicles/test_models.py::test_motion_jacobian_is_the_numeric_one",
                "tests/native/test_planes.py::test_a_vehicle_that_speeds_up_shows_its_change_of_velocity",
            ),
            differs="both runs move in six, the form of four is held by a test alone; in the "
            "product odometry by DVL and gyro wherever there is a DVL",
        ),
        Part(
            "5.2.2, Fig. 5.4, eqs (5.4) to (5.14)",
            "IMU, DVL, pressure, altitude, side-scan point",
            studies=("remus-run",),
            code=(
                "hullrecon/studies/vehicles/sensors.py:navigation_rows",
                "hullrecon/studies/vehicles/sensors.py:see_target",
                "hullrecon/studies/vehicles/sensors.py:place_target",
                "hullrecon/studies/vehicles/sensors.py:Sigmas",
                "native/factors/navigation_residuals.h",
                "native/factors/hull_residuals.h",
            ),
            tests=(
                "tests/native/test_factors.py",
                "tests/native/test_residual_twins.py",
                "tests/studies/vehicles/test_models.py::test_target_is_placed_where_it_was_seen",
            ),
            differs=(
                "R by `Sigmas`, assumed, as the thesis prints no number; (5.4) is "
                "`navigation_rows` and `see_target` one after the other; `see_target` inverts the "
                "transform of (5.11) (misprints) and measures forward too; no offset of the "
                "heading is subtracted. In the product altitude is four ranges to the hull; no "
                "side-scan point; a compass is of no use beside steel"
            ),
        ),
        Part(
            "5.3.2, Fig. 5.12, eqs (5.16) to (5.24)",
            "pinhole, landmarks by inverse depth",
            printed="0.1 as a new landmark's inverse depth",
            studies=("inverse-depth", "sparus-run"),
            code=(
                "hullrecon/studies/vehicles/inverse_depth.py:Pinhole",
                "hullrecon/studies/vehicles/inverse_depth.py:to_point",
                "hullrecon/studies/vehicles/inverse_depth.py:direction",
                "hullrecon/studies/vehicles/inverse_depth.py:see_landmark",
                "hullrecon/studies/vehicles/inverse_depth.py:new_landmark",
                "native/factors/image_residuals.h",
                "hullrecon/adjustment/problem/triangulation.py:triangulate",
            ),
            tests=(
                "tests/adjustment/test_triangulation.py",
                "tests/studies/vehicles/test_runs.py::test_inverse_depth_converges_from_a_hundredth_of_the_depth",
            ),
            differs=(
                "one focal length, f k_u = f k_v, no skew; in the product landmarks are points: at "
                "1 m from a hull parallax is large, and what has less than 0.3° is left out"
            ),
        ),
        Part(
            "5.2.3, Fig. 5.5",
            "REMUS-100: sonar image, map, views from above and from the side",
            printed="300 x 400 m, 4 h",
            studies=("remus-run",),
            code=("hullrecon/studies/vehicles/remus.py:run_slam",),
            tests=("tests/studies/vehicles/test_runs.py",),
            differs="simulated: the mission's sonar was never published",
        ),
        Part(
            "Fig. 5.6",
            "short pieces of track by the acoustic reference, dead reckoning and submaps",
            studies=("remus-run",),
            code=(
                "hullrecon/studies/vehicles/remus.py:run_slam",
                "hullrecon/studies/vehicles/remus_figures.py:draw_pieces",
            ),
            differs="simulated: the acoustic reference was never published",
        ),
        Part(
            "Fig. 5.7",
            "discrepancy to the acoustic reference, with its bound",
            printed="always inside; outside with larger submaps",
            studies=("remus-run",),
            code=(
                "hullrecon/studies/vehicles/remus.py:discrepancy",
                "hullrecon/studies/vehicles/remus_figures.py:draw_discrepancy",
            ),
            tests=(
                "tests/studies/vehicles/test_runs.py::test_discrepancy_to_lbl_stays_inside_its_bound",
                "tests/studies/vehicles/test_runs.py::test_noise_stated_too_small_leaves_the_bound",
            ),
            differs=(
                "simulated: the acoustic reference was never published; one large map stays "
                "consistent, as attitude is measured in the world"
            ),
        ),
        Part(
            "5.3.3, Fig. 5.13",
            "SPARUS: dead-reckoned and corrected track",
            printed="20 x 20 m, 3,199 frames",
            studies=("sparus-run",),
            code=("hullrecon/studies/vehicles/sparus.py:run_slam",),
            benchmarks=("benchmarks/mono_survey.py",),
            tests=(
                "tests/studies/vehicles/test_runs.py::test_sparus_ends_nearer_than_dead_reckoning",
            ),
            differs="simulated: the images of SPARUS are not public",
        ),
        Part(
            "Figs 5.14, 5.15",
            "texture on the map; a mosaic",
            code=("hullrecon/mosaic/optical.py:optical_mosaic",),
            delivered=("ortho_optical.tif", "mosaic_optical.glb"),
            differs="the whole mosaic, no patches on single landmarks",
        ),
        Part(
            "Fig. 5.16",
            "ellipses of landmarks seen again shrink",
            studies=("sparus-run",),
            code=(
                "hullrecon/studies/vehicles/sparus.py:Prediction",
                "hullrecon/studies/vehicles/sparus_figures.py:draw_frames",
                "hullrecon/estimation/landmark_variance.py",
            ),
            delivered=("landmarks.ply",),
            tests=(
                "tests/estimation/test_landmark_variance.py",
                "tests/studies/vehicles/test_runs.py::test_predicted_ellipses_shrink_as_a_landmark_is_seen_again",
            ),
            differs="in the product sigma of each landmark after the batch",
        ),
        Part(
            "Figs 5.17, 5.18",
            "map and track in three views",
            studies=("sparus-run",),
            code=(
                "hullrecon/studies/vehicles/sparus.py:run_slam",
                "hullrecon/studies/vehicles/sparus_figures.py:draw_map",
                "hullrecon/studies/vehicles/sparus_figures.py:draw_tracks",
                "hullrecon/report/figures/plan_view.py",
                "hullrecon/report/scene_view.py",
            ),
            delivered=("report/",),
            differs="simulated; two views of the map and one in space of the tracks",
        ),
    ),
)
_APPENDIX = Chapter(
    title="6, A. Conclusions, transformations",
    parts=(
        Part("6, 6.1, 6.2", "conclusions, publications", absent=Absence.LITERATURE),
        Part(
            "6.3, vision",
            "stereo cameras for better landmarks, bundle adjustment",
            code=(
                "hullrecon/vision/stereo/matching.py:match_stereo",
                "hullrecon/adjustment/bundle_adjustment.py:adjust",
            ),
            tests=("tests/end_to_end/test_demo_accuracy.py",),
            differs="future work of the source, without method or number",
        ),
        Part(
            "6.3, the rest",
            "comparisons in 6-DOF, C++ on board, PHD filters, other vehicles",
            absent=Absence.LITERATURE,
            differs="future work of the source, without method or number",
        ),
        Part(
            "A.1, A.2, Fig. A.1, eqs (A.1), (A.2)",
            "poses in the plane: composition and inverse with derivatives",
            code=(
                "hullrecon/studies/submaps/models.py:compose",
                "hullrecon/studies/submaps/models.py:compose_jacobians",
                "hullrecon/studies/submaps/models.py:invert",
                "hullrecon/studies/submaps/models.py:invert_jacobian",
            ),
            tests=(
                "tests/studies/submaps/test_models.py::test_jacobians_of_composition_are_its_derivatives",
            ),
            differs="the product's poses are in space alone",
        ),
        Part(
            "A.3, eqs (A.3) to (A.6)",
            "poses in space: composition and inverse with derivatives",
            code=(
                "hullrecon/studies/vehicles/transforms.py:transform",
                "hullrecon/studies/vehicles/transforms.py:inverse_transform",
                "hullrecon/studies/vehicles/transforms.py:rotation",
                "hullrecon/geometry/poses.py:Poses",
                "hullrecon/vision/pairs/gating.py:Motion",
                "native/factors/motion.h",
            ),
            tests=(
                "tests/geometry/test_poses.py",
                "tests/vision/pairs/test_gating.py::test_inverse_carries_covariance_as_random_draws_do",
            ),
            differs="quaternions in the product",
        ),
    ),
)

_MISPRINTS = (
    Misprint(
        where="Algorithms 1, 2, eq (3.11)",
        printed="P = P - W S P",
        right="P = P - W S W'",
        tests=(
            "tests/studies/submaps/test_filters.py::test_update_is_least_squares_and_not_as_printed",
        ),
    ),
    Misprint(
        where="eq (3.10)",
        printed="innovation from f and P of the step before",
        right="from h and the predicted P",
        tests=(
            "tests/studies/submaps/test_filters.py::test_innovation_needs_the_predicted_covariance_not_as_printed",
            "tests/studies/submaps/test_filters.py::test_innovation_by_the_motion_as_printed_misses_the_mean",
        ),
    ),
    Misprint(
        where="eq (3.13)",
        printed="covariance of the chain of transforms left out",
        right="J_T P_T J_T' added",
        tests=(
            "tests/studies/submaps/test_joining.py::test_landmarks_behind_an_unsure_chain_are_unsure_not_as_printed",
        ),
    ),
    Misprint(
        where="eq (3.17)",
        printed="tan(phi) in the first two rows",
        right="tan(alpha), the steering angle",
        tests=(
            "tests/studies/submaps/test_models.py::test_car_moves_by_its_steering_not_by_its_heading_as_printed",
        ),
    ),
    Misprint(
        where="eq (3.19)",
        printed="bearing by the arc tangent of a quotient, which folds what is behind",
        right="atan2(dy, dx)",
        tests=(
            "tests/studies/submaps/test_models.py::test_what_lies_behind_the_car_is_not_folded_as_printed",
        ),
    ),
    Misprint(
        where="eq (3.20)",
        printed="range falls by the landmark's x: -dx/D",
        right="+dx/D",
        tests=(
            "tests/studies/submaps/test_models.py::test_range_grows_with_the_landmarks_x_ahead_not_as_printed",
        ),
    ),
    Misprint(
        where="eq (3.22)",
        printed="S without saying of which state",
        right="S = H P H' + R with the predicted P",
        tests=(
            "tests/studies/submaps/test_filters.py::test_innovation_squared_is_chi_square_by_the_predicted_covariance_alone",
        ),
    ),
    Misprint(
        where="3.4.1",
        printed="441 landmarks on 100 m²",
        right="100 m x 100 m: 21 x 21 landmarks at 5 m",
        tests=(
            "tests/studies/submaps/test_joining.py::test_441_landmarks_at_five_metres_take_100_metres_square_not_100_square_metres",
        ),
    ),
    Misprint(
        where="3.4.1",
        printed="selective joining is the fastest",
        right="hierarchical takes 78.37 s, selective 78.88 s, by Table 3.2",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_hierarchical_joining_is_printed_as_faster_than_the_fastest",
        ),
    ),
    Misprint(
        where="Table 3.3",
        printed="mean and deviation of the hierarchical map both 0.5761 m",
        right="perhaps one of them is a copy; which, and of what, cannot be computed",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_no_printed_figure_refutes_that_a_map_has_one_number_for_mean_and_deviation",
        ),
        checked="the print does not fail: errors up to the printed 5.5558 m may have both, and "
        "nothing else is printed to compute either from. No other method has two equal ones",
    ),
    Misprint(
        where="3.4.2, 4.2",
        printed="a laser scan of 360°; 360 values over 180°",
        right="180° in steps of 0.5°",
        tests=("tests/studies/association/test_trunks.py::test_a_tree_behind_the_car_is_not_seen",),
    ),
    Misprint(
        where="2.4",
        printed="Leonard 2001 is divide and conquer",
        right="decoupled stochastic mapping, as in Table 2.3",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_leonard_2001_is_not_divide_and_conquer_as_printed",
        ),
    ),
    Misprint(
        where="4.3.4, Table 4.2",
        printed="twice as many negatives as positives; useful until its fourth layer",
        right="2,000 and 5,000 were used; the fourth has more false positives than the third",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_negatives_are_printed_as_two_and_a_half_times_the_positives_not_twice",
            "tests/studies/catalogue/test_printed_tables.py::test_the_fourth_layer_as_printed_lets_more_pass_than_the_third",
        ),
    ),
    Misprint(
        where="eq (5.2)",
        printed="roll, roll, yaw",
        right="roll, pitch, yaw",
        tests=(
            "tests/studies/vehicles/test_models.py::test_pitch_stays_where_the_print_puts_roll",
        ),
    ),
    Misprint(
        where="eq (5.9)",
        printed="eight columns before the landmarks",
        right="ten, as the state has",
        tests=(
            "tests/studies/vehicles/test_models.py::test_row_of_depth_has_as_many_columns_as_the_state",
        ),
    ),
    Misprint(
        where="eq (5.11)",
        printed="derivatives of W_T_V, which leads from the vehicle to the world",
        right="of V_T_W, its inverse: what is measured is in the vehicle's frame",
        tests=(
            "tests/studies/vehicles/test_models.py::test_target_is_seen_by_the_inverse_of_the_printed_transform",
        ),
    ),
    Misprint(
        where="eq (5.12)",
        printed="labelled R_v",
        right="R_s",
        tests=(
            "tests/studies/vehicles/test_models.py::test_noise_of_a_target_is_sonar_noise_not_velocity_noise",
        ),
    ),
    Misprint(
        where="eq (5.13)",
        printed="d_ss is the distance of vehicle and floor",
        right="H reads d_ss - z: it is the floor's depth",
        tests=(
            "tests/studies/vehicles/test_models.py::test_altitude_reads_the_depth_of_the_floor",
        ),
    ),
    Misprint(
        where="eq (5.15)",
        printed="z + v_z dt yaw, one row for z and yaw",
        right="z + v_z dt, and yaw",
        tests=(
            "tests/studies/vehicles/test_models.py::test_level_motion_is_the_full_one_without_roll_and_pitch",
        ),
    ),
    Misprint(
        where="eq (5.20)",
        printed="direction m by alpha, beta",
        right="m = (cos b sin a, -sin b, cos b cos a)",
        tests=(
            "tests/studies/vehicles/test_models.py::test_direction_is_a_unit_vector_unlike_the_printed_one",
        ),
    ),
    Misprint(
        where="eq (5.21)",
        printed="R (rho c - r) + m",
        right="R (rho (c - r) + m)",
        tests=(
            "tests/studies/vehicles/test_models.py::test_landmark_is_seen_where_its_point_is_unlike_the_printed_one",
        ),
    ),
    Misprint(
        where="eq (5.23)",
        printed="ray of a pixel without K^-1",
        right="R K^-1 (u, v, 1)",
        tests=(
            "tests/studies/vehicles/test_models.py::test_new_landmark_lies_on_its_ray_unlike_the_printed_one",
        ),
    ),
    Misprint(
        where="A.2",
        printed="derivative of the inverse, row 1, by phi: -x sin phi - y cos phi",
        right="x sin phi - y cos phi",
        tests=(
            "tests/studies/submaps/test_models.py::test_inverse_has_x_sin_minus_y_cos_not_as_printed",
        ),
    ),
    Misprint(
        where="A.3",
        printed="a stray Delta in the inverse; rotz(phi) with two equal cosines as last factor",
        right="-R' t; rotx(phi)",
        tests=(
            "tests/studies/vehicles/test_models.py::test_inverse_transform_has_the_translation_turned_back",
            "tests/studies/vehicles/test_models.py::test_last_factor_of_a5_as_printed_is_no_rotation",
            "tests/studies/vehicles/test_models.py::test_inverse_with_the_stray_factor_as_printed_leads_elsewhere",
        ),
    ),
)

_SURVEYS = (
    Survey(
        number="Table 2.2",
        about="Submapping: order of memory, of time inside a map and at a loop, in landmarks n; "
        "the thesis's remarks for and against are left out",
        heads=("method", "memory", "time inside", "time at a loop"),
        rows=(
            ("EKF (Smith 1986)", "n²", "n²", "n²"),
            ("CEKF (Guivant 2001)", "n²", "n", "n²"),
            ("CLSF (Williams 2002)", "n²", "1", "n²"),
            ("LMJ (Tardós 2002)", "n²", "1", "n²"),
            ("CTS (Newman 2003)", "n", "1", "–"),
            ("Atlas (Bosse 2004)", "n", "1", "–"),
            ("HS (Estrada 2005)", "n", "1", "n"),
            ("DCS (Paz 2008)", "n²", "1", "n"),
            ("CIS (Piniés 2009)", "n", "1", "n"),
        ),
        ours=("hullrecon", "n (sparse factor)", "– (batch)", "one sparse solve of the dive"),
    ),
    Survey(
        number="Table 2.3",
        about="Underwater SLAM",
        heads=("work", "vehicle", "sensor", "map", "estimator"),
        rows=(
            ("Leonard 2001", "–", "imaging sonar", "points", "DSM"),
            ("Williams 2001", "Oberon", "imaging sonar", "points", "EKF"),
            ("Newman 2003", "Caribou", "imaging sonar", "points", "CTS"),
            ("Tena-Ruiz 2004", "REMUS", "side-scan", "points", "EKF, smoothed backward"),
            ("Williams 2004", "Oberon", "camera, sonar", "points", "EKF"),
            ("Fairfield 2007", "DEPTHX", "sonar beams", "evidence grid", "PF"),
            ("Roman 2007", "JASON", "multibeam", "bathymetry", "EKF"),
            ("Eustice 2008", "SeaBED", "camera", "vehicle poses", "EIF"),
            ("Fairfield 2008", "MBAUV", "sonar beams", "evidence grid", "PF"),
            ("Ribas 2008", "Ictineu", "imaging sonar", "lines", "EKF"),
            ("Walter 2008", "HAUV", "imaging sonar", "points", "SEIF"),
            ("Barkby 2009", "Sirius", "multibeam", "bathymetry", "PF"),
            ("Mallios 2009", "Ictineu", "imaging sonar", "vehicle poses", "EKF"),
        ),
        ours=(
            "hullrecon",
            "hovering, on a servoed tray",
            "one or two cameras, DVL",
            "poses, points, planes, the hull",
            "batch least squares",
        ),
    ),
    Survey(
        number="Table 2.4",
        about="Objects in side-scan sonar",
        heads=("work", "features", "matching"),
        rows=(
            ("Ciany 2000", "threshold", "–"),
            ("Ruiz 2001", "threshold", "multiple hypothesis tracking"),
            ("Bell 2002", "cooperating snakes", "Markov chain Monte Carlo"),
            ("Reed 2003", "Markov random field", "–"),
            ("Perry 2004", "geometry, moments", "neural network"),
            ("Reed 2006", "texture", "Markov random field, voting"),
            ("Coiras 2007", "shape, texture", "–"),
            ("Lianantonakis 2007", "texture, active contour", "–"),
            ("Saisan 2008", "texture", "eigenanalysis"),
        ),
        ours=("hullrecon", "none in the product: sonar is blended", "–"),
    ),
    Survey(
        number="Table 2.5",
        about="Features of underwater images",
        heads=("work", "cameras", "features", "matching"),
        rows=(
            ("Balasuriya 2002", "one", "lines", "Hough transform"),
            ("Cufi 2002", "one", "corners", "correlation, texture"),
            ("Ortiz 2002", "one", "contours", "correlation"),
            ("Gracias 2003", "one", "Harris corners", "correlation, Lucas and Kanade"),
            ("Pizarro 2003", "one", "Harris at scales, Zernike moments", "distance of descriptors"),
            ("Gracias 2005", "one", "Harris, texture", "cross-correlation"),
            ("Sáez 2006", "three", "disparity, texture", "correlation"),
            ("Nicosevici 2007", "one", "geometric features, SIFT", "distance of descriptors"),
            ("Eustice 2008", "one", "Harris, SIFT", "pose, epipolar geometry"),
            ("Ortiz 2008", "one", "lines", "correlation in time"),
            ("Salvi 2008", "two", "SIFT, SURF, structure", "distance of descriptors"),
            ("Wirth 2008", "one", "lines", "particle filter"),
        ),
        ours=("hullrecon", "one or two", "SIFT", "pose's ellipse, then E, H or three points"),
    ),
)

AULINAS = Source(
    key="Aulinas2011",
    title="Selective submap joining SLAM for autonomous vehicles",
    chapters=(_INTRODUCTION, _FILTERS, _SUBMAPS, _EXPERIMENTS, _FEATURES, _VEHICLES, _APPENDIX),
    misprints=_MISPRINTS,
    surveys=_SURVEYS,
)
