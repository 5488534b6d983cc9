# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every part of [KimEustice2009], and where it is here."""

from __future__ import annotations

from hullrecon.studies.catalogue.part import Chapter, Misprint, Part, Source

_STATE = Chapter(
    title="II. State, camera constraint, inference",
    parts=(
        Part(
            "II-A, state",
            "six numbers of the vehicle relative to the hull, moved by a constant velocity",
            code=(
                "native/factors/navigation_residuals.h:Velocity",
                "hullrecon/estimation/navigation_tables.py:velocity_table",
                "hullrecon/native/problem.py:Unknowns",
            ),
            tests=(
                "tests/native/test_planes.py::test_a_vehicle_that_speeds_up_shows_its_change_of_velocity",
            ),
            differs=(
                "a batch estimate with odometry by DVL and gyro between poses; constant velocity "
                "only where the DVL is lost; a pose is place, quaternion and the tray's angle; the "
                "hull's pose is one more unknown"
            ),
        ),
        Part(
            "II-A, key frames",
            "poses kept at regular distances",
            code=("hullrecon/vision/pairs/selection.py:select_keyframes",),
            tests=(
                "tests/vision/pairs/test_selection.py::test_hovering_vehicle_leaves_few_keyframes",
            ),
            differs=(
                "chosen by how little their images overlap, not by metres; every node stays in "
                "the state"
            ),
        ),
        Part(
            "II-A, information form",
            "mean and covariance as information vector and matrix",
            code=(
                "tests/native/test_information_filter.py:InformationFilter",
                "native/schur/small_factors.cpp:linearise",
            ),
            tests=(
                "tests/native/test_information_filter.py::test_its_covariances_are_those_of_the_batch",
            ),
            differs=(
                "the filter is in the tests; of a solve `information_` is the matrix, `gradient_` "
                "the right-hand side of a step from where it was linearised, not of the state; "
                "both anew at every step"
            ),
        ),
        Part(
            "II-B",
            "camera constraint of five numbers, direction of the baseline and relative attitude; "
            "its Jacobian, zero but for two poses",
            code=(
                "native/factors/link_residuals.h:BearingLink",
                "native/factors/link_residuals.h:CameraPair",
            ),
            tests=(
                "tests/native/test_links.py::test_bearing_residual_is_the_angle_whatever_the_length",
            ),
            differs=(
                "angle between directions and rotation vector in place of azimuth, elevation and "
                "Euler angles: no singularity, and a reversed baseline counts. The Jacobian "
                "(`derive_blocks`) is also by the mounts of the cameras; its sparsity is row II-C"
            ),
        ),
        Part(
            "II-C",
            "extended information filter: sparse, nearly linear in the poses",
            studies=("filters",),
            code=(
                "tests/native/test_information_filter.py:InformationFilter",
                "hullrecon/studies/submaps/filters.py:predict_information",
                "hullrecon/studies/submaps/filters.py:update_information",
                "native/sparse/fronts.cpp",
            ),
            benchmarks=("benchmarks/pose_graph.py",),
            tests=(
                "tests/native/test_information_filter.py::test_the_filter_ends_at_the_step_of_the_batch",
                "tests/native/test_information_filter.py::test_each_link_touches_four_blocks_only",
            ),
            differs=(
                "a dive is processed after it: one batch solve by a sparse factor (fronts.cpp), to "
                "which the filter in the tests is equal; no pose is marginalised between key frames"
            ),
        ),
    ),
)
_REGISTRATION = Chapter(
    title="III. Registration of two images",
    parts=(
        Part(
            "Fig. 1",
            "one pair of images from features to the five numbers, stage by stage",
            studies=("pair-stages",),
            code=(
                "hullrecon/vision/pairs/match_worker.py:MatchWorker",
                "hullrecon/vision/link_images.py:link_images",
            ),
            differs="every pair is gated by the joint covariance of its two poses, in rounds",
        ),
        Part(
            "Fig. 1, pose-constrained search",
            "correspondences inside the ellipse that the relative pose predicts",
            code=("hullrecon/vision/pairs/gating.py:transfer", "native/matching/feature_pairs.cpp"),
            studies=("scene-figures/search_ellipses",),
            tests=("tests/vision/pairs/test_gating.py::test_ellipse_is_that_of_many_random_draws",),
            differs="unscented transform of nine numbers, from the first image to the second only",
        ),
        Part(
            "Fig. 1, Horn's method",
            "first relative pose from the inliers and the prior",
            code=(
                "hullrecon/vision/pairs/two_view.py:motions_of",
                "hullrecon/vision/pairs/mono_inliers.py:most_likely_motion",
            ),
            tests=(
                "tests/vision/pairs/test_mono_motion.py::test_surface_normal_settles_motion_of_plane_over_navigation",
            ),
            differs=(
                "the matrix is decomposed, and the normal by DVL, then navigation, choose among "
                "its motions"
            ),
        ),
        Part(
            "III-A",
            "SIFT, helped by Harris corners with Zernike moments; their share by a threshold",
            code=(
                "hullrecon/studies/matching/corners.py:find_corners",
                "hullrecon/studies/matching/corners.py:describe_corners",
            ),
            studies=("links",),
            tests=(
                "tests/studies/matching/test_match_with_corners.py::test_corners_are_share_asked_for",
                "tests/studies/matching/test_zernike.py",
            ),
            differs="the product takes SIFT alone: corners joined no more pairs on the dives tried",
        ),
        Part(
            "III-B, robust fit",
            "essential matrix and homography by random samples of one set of matches",
            code=("hullrecon/vision/pairs/two_view.py:fit_both",),
            tests=("tests/vision/pairs/test_two_view.py::test_wrong_matches_are_no_inliers",),
            differs=(
                "OpenCV's estimators with a fixed seed; navigation helps to choose inliers "
                "afterwards"
            ),
        ),
        Part(
            "III-B, criterion",
            "Torr's geometric information criterion: d 2 or 3, P 8 or 5, weights 2 and 4",
            printed="smaller one wins",
            code=(
                "hullrecon/vision/pairs/two_view.py:criterion",
                "hullrecon/vision/pairs/two_view.py:fit_both",
            ),
            tests=(
                "tests/vision/pairs/test_two_view.py::test_penalties_are_those_of_source",
                "tests/vision/pairs/test_two_view.py::test_one_outlier_cannot_decide",
            ),
            differs=(
                "an outlier counts at most 2 (4 - d), so that one of them cannot decide; the "
                "choice therefore turns at a larger relief than as published. Errors are Sampson's "
                "distance and half the mean transfer error, not of reprojected points; sigma is "
                "half of RANSAC's tolerance: 0.5 px"
            ),
        ),
        Part(
            "Fig. 2(a)",
            "criterion of either model against the relief of a surface with MATLAB's peaks",
            printed="homography below, essential matrix above a relief that is drawn, not printed",
            code=(
                "hullrecon/studies/scenes/scene_figures.py:criterion_trials",
                "hullrecon/vision/pairs/two_view.py:criterion",
                "hullrecon/studies/engine/relief_views.py:relief_views",
            ),
            differs="two curves: outliers in full, as published, and capped, as in the product",
            studies=("scene-figures/gic_by_relief", "relief-views"),
            tests=(
                "tests/studies/test_scene_figures.py::test_published_criteria_cross_once_between_2_and_10_cm",
            ),
        ),
        Part(
            "Fig. 2(b)",
            "inliers of either model on real pairs: false ones along epipolar lines outside "
            "the overlap",
            studies=("pair-overlap",),
            code=(
                "hullrecon/studies/engine/pair_overlap.py:compare_pair",
                "hullrecon/vision/pairs/two_view.py:fit_both",
            ),
            differs="simulated pairs, some forty of two legs, by the search ellipses and over the "
            "whole image",
        ),
        Part(
            "III-C-1",
            "two-view adjustment of a general scene, 3N + 5 unknowns",
            code=(
                "hullrecon/vision/pairs/mono_motion.py:refine",
                "hullrecon/vision/pairs/stereo_adjustment.py:adjust_stereo_motion",
            ),
            tests=(
                "tests/vision/pairs/test_stereo_adjustment.py::test_motions_of_noisy_pairs_scatter_as_covariance_says",
                "tests/vision/pairs/test_mono_motion.py::test_five_numbers_scatter_as_their_covariance_says",
            ),
            differs=(
                "points are eliminated (stereo) or left out to first order by Sampson's distance "
                "(one camera)"
            ),
        ),
        Part(
            "III-C-2",
            "two-view adjustment by a homography, 2N + 8 unknowns",
            studies=("planar-adjustment",),
            code=(
                "hullrecon/studies/engine/planar_adjustment.py:adjust_plane",
                "hullrecon/vision/pairs/two_view.py:motions_of",
            ),
            tests=(
                "tests/studies/engine/test_engine.py::test_a_plane_gives_its_motion_and_normal",
            ),
            differs=(
                "in the product a homography chooses inliers and motion, which is then refined on "
                "epipolar lines: the planar form is better on planes and turns where a hull bends"
            ),
        ),
    ),
)
_RESULTS = Chapter(
    title="IV, V. Results and discussion",
    parts=(
        Part(
            "IV, vehicle",
            "camera and DVL on servos that keep them normal to the hull; 12-bit images, one lamp",
            code=(
                "native/factors/link_residuals.h:CameraPose",
                "hullrecon/adjustment/problem/weighting.py:estimate_sides",
                "hullrecon/mosaic/imagery/radiometry.py:solve_light",
            ),
            tests=(
                "tests/native/test_tray_and_intrinsics.py::test_images_separate_tray_angle_from_backlash",
                "tests/dive/images/test_deep.py",
                "tests/mosaic/test_radiometry.py::test_the_lamp_is_told_from_the_scene",
            ),
            differs="tray angle at every node, two-sided backlash and mounts are unknowns",
        ),
        Part(
            "IV, survey",
            "seven legs of 30 m, 1,300 images, a blank in leg 2, a stern without texture",
            printed="offset of some 2 m without choice of model",
            studies=("one-camera-survey",),
            code=(
                "hullrecon/navigation/pose_graph/start.py:path_along_links",
                "hullrecon/vision/pairs/selection.py:propose_revisits",
            ),
            benchmarks=("benchmarks/mono_survey.py",),
            differs=(
                "simulated, the images of the survey are not public: three legs of 5 m as a "
                "study, seven of 30 m as a benchmark; places found by how they look need two "
                "cameras"
            ),
        ),
        Part(
            "IV, links",
            "between neighbours (green) and across legs (red)",
            code=(
                "hullrecon/vision/link_images.py:link_images",
                "hullrecon/vision/pairs/selection.py:propose_revisits",
            ),
            benchmarks=("benchmarks/false_links.py",),
            studies=("path-figures/links_on_hull",),
            differs=(
                "proposed by the probability that the images overlap, guarded by cycles and "
                "scaled links"
            ),
        ),
        Part(
            "Fig. 3",
            "the dead-reckoned trajectory beside the ship",
            code=(
                "hullrecon/navigation/dead_reckoning/reckoning.py:reckon",
                "hullrecon/studies/paths/link_plots.py:links_on_hull",
            ),
            studies=("path-figures/links_on_hull",),
            differs="the curve `dead reckoned` of the lower panel of Fig. 5(a): a simulated dive, "
            "from above, with the truth and the path with links; no photographs",
        ),
        Part(
            "Fig. 4",
            "uncertainty along the path, dead reckoned and with links",
            printed="grows without bound against bounded; curves alone, no number",
            code=("hullrecon/studies/paths/link_plots.py:sigma_along_path",),
            studies=(
                "path-figures/sigma_along_path",
                "one-camera-survey/sigma_along_path",
            ),
            differs=(
                "horizontal position alone; dead reckoning by white noise alone, as the paper has "
                "it, and with errors that last, whose sigma falls on the way back"
            ),
        ),
        Part(
            "Fig. 5(a)",
            "the graph over the hull, ellipsoids of three sigma, pictures of feature richness",
            code=("hullrecon/studies/paths/link_plots.py:links_on_hull",),
            studies=("path-figures/links_on_hull",),
            differs=(
                "links from the side, ellipses of three sigma from above at some forty nodes; "
                "richness decides which images are compared and is not drawn"
            ),
        ),
        Part(
            "Fig. 5(b)",
            "trajectory without and with choice of model",
            printed="some 2 m apart",
            code=(
                "hullrecon/studies/paths/path_figures.py:by_two_view_model",
                "hullrecon/studies/paths/link_plots.py:two_view_models",
            ),
            studies=("one-camera-survey/two_view_models", "path-figures/two_view_models"),
            tests=(
                "tests/end_to_end/test_path_figures.py::test_path_of_chosen_models_is_the_runs_with_its_true_error",
            ),
            differs=(
                "navigation refuses links that would turn the path: by either model it lies "
                "within its sigma. Of ten draws, of which the study prints the first five, the "
                "essential matrix alone was nearer by 0.5 mm, known to 0.4 mm, and pairs that "
                "both join were as good by either: what the choice brings is nearly twice as many "
                "pairs"
            ),
        ),
        Part(
            "Fig. 6",
            "triangulated points, smooth surface, photomosaic; six targets seen in it",
            printed="6 of 6",
            studies=("fly-through",),
            code=(
                "hullrecon/detection/as_found/hull_as_found.py:estimate_hull_as_found",
                "hullrecon/mosaic/optical.py:optical_mosaic",
            ),
            delivered=("landmarks.ply", "as_found.ply", "mosaic_optical.glb", "objects.json"),
            tests=(
                "tests/end_to_end/test_demo_accuracy.py::test_every_object_is_found_once_and_paint_is_none",
            ),
            differs="targets are found by their height over the hull, not by eye",
        ),
        Part(
            "IV, film",
            "flight over the photomosaic",
            studies=("fly-through",),
            code=(
                "hullrecon/studies/engine/fly_through.py:fly_through",
                "hullrecon/mosaic/output/textured_mesh.py:build_textured_mesh",
            ),
            differs="rays cast by the mesh index; a film where OpenCV has the codec, else frames",
        ),
        Part(
            "V, coverage",
            "share of the hull that was seen, as a number",
            printed="100 % is the goal",
            code=("hullrecon/detection/coverage.py:summarise_coverage",),
            delivered=("coverage.json",),
            tests=("tests/detection/test_coverage.py",),
            differs="with sigma and holes; where to drive again is the row below",
        ),
        Part(
            "V, next focus",
            "perception-driven control: back to feature-rich hull when the sigma gets too large",
            studies=("next-leg",),
            code=("hullrecon/studies/sessions/next_leg.py:foreseen_sigma",),
            differs=(
                "an outlook in the source. Legs are ranked by what they do to the sigma, the way "
                "back to an old leg among them; dives are processed afterwards, so no bound is "
                "kept while driving, and richness does not enter"
            ),
        ),
        Part(
            "V, richness",
            "texture of the hull decides where the path can be tied",
            code=("hullrecon/vision/features/extraction.py:local_saliency",),
            tests=("tests/vision/features/test_saliency.py",),
            differs="images without texture are not compared; no map of it is delivered",
        ),
        Part(
            "V, consistency",
            "no truth at sea: a smooth surface argues for a consistent path",
            code=(
                "hullrecon/adjustment/results/summary.py:residual_figures",
                "hullrecon/vision/pairs/cycles.py:contradicted_links",
            ),
            delivered=("summary.json", "plots/"),
            differs="residuals by sensor in sigmas, cycles of links, contradictions named; no "
            "links held out, no heights between legs",
        ),
    ),
)

KIM = Source(
    key="KimEustice2009",
    title="Pose-graph visual SLAM with geometric model selection for ship hull inspection",
    chapters=(_STATE, _REGISTRATION, _RESULTS),
    misprints=(
        Misprint(
            where="II-B",
            printed="poses are x_v in the measurement and x_p in its Jacobian",
            right="both are the poses of the two key frames",
            tests=(
                "tests/native/test_links.py::test_a_link_moves_with_its_own_poses_and_with_no_other",
            ),
        ),
        Misprint(
            where="III-B",
            printed="what an outlier counts, and sigma, are not said",
            right="a bound of 2 (4 - d) for each match, a fixed sigma of 0.5 px",
            tests=(
                "tests/vision/pairs/test_two_view.py::test_one_outlier_cannot_decide",
                "tests/vision/pairs/test_two_view.py::test_one_match_off_the_wall_decides_where_errors_are_not_bounded",
            ),
        ),
        Misprint(
            where="III-C-2",
            printed="homography with t n' / d, without the convention of its sign",
            right="H = K (R - t n' / d) K^-1 where n' X + d = 0",
            tests=(
                "tests/studies/engine/test_engine.py::test_the_homographys_sign_is_that_of_its_plane",
            ),
        ),
    ),
)
