# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every part of [Ozog2016], and where it is here."""

from __future__ import annotations

from hullrecon.studies.catalogue.part import Absence, Chapter, Misprint, Part, Source, Survey

_ONE_DIVE = "hullrecon estimates one dive at a time: sessions share no state"
_NO_PERISCOPE = "no camera above water: the frames of hullrecon/geometry/frames.py end at the tray"
_SONAR_BLENDS = (
    "sonar is blended on a hull that other sensors measured; nothing is estimated from it"
)

_INTRODUCTION = Chapter(
    title="1. Introduction",
    parts=(
        Part(
            "Figs 1.1 to 1.6",
            "imagery, vehicle, sensors, contributions, ships",
            absent=Absence.PICTURE,
        ),
        Part(
            "1.1.2, Table 1.1",
            "sensors on a servoed tray: DVL, IMU, depth, one or two cameras, DIDSON; a periscope",
            printed="sigma of depth 10 cm",
            code=("hullrecon/rig.py:Rig", "hullrecon/geometry/frames.py:Camera"),
            tests=("tests/test_rig.py", "tests/dive/readers/test_didson.py"),
            differs=f"{_NO_PERISCOPE}; sigmas are keys of dive.toml, of a depth `pressure.sigma_m` "
            "(white, 0.02 m unless given) and `pressure.bias_sigma_m` (constant, 0.1 m); the IMU "
            "is no mount of `Rig`: its readings are turned into the vehicle by `imu.mount_deg`",
        ),
        Part(
            "1.2.1, Fig. 1.7",
            "four Janus beams: velocity of the sensor by those along the beams",
            code=(
                "hullrecon/dive/logs/readers/pd0.py:from_beams",
                "hullrecon/navigation/dead_reckoning/reckoning.py:reckon",
            ),
            tests=(
                "tests/dive/readers/test_pd0.py::test_beam_velocities_are_inverted_also_with_one_beam_lost",
            ),
            differs="any beam angle, three beams where one is lost, lever arm and covariance; the "
            "error velocity e(t), M's fourth row, is not used: it is zero where a beam is lost",
        ),
        Part(
            "1.2.2, Fig. 1.8",
            "acoustic beacons beside dead reckoning",
            code=(
                "hullrecon/estimation/position_tables.py:with_positions",
                "hullrecon/dive/logs/positions.py:position_fixes",
            ),
            tests=(
                "tests/navigation/test_positions.py::test_fixes_bound_the_drift_of_a_dive_without_a_camera",
            ),
            differs="positions of USBL or GPS, no ranges to beacons",
        ),
        Part(
            "1.2.3, eq (1.1)",
            "points of the hull that the DVL's ranges meet",
            code=(
                "hullrecon/rig.py:dvl_points",
                "hullrecon/dive/logs/readers/pd0.py:to_sample",
                "hullrecon/dive/logs/dvl_beams.py:tilted_beams",
            ),
            tests=(
                "tests/test_rig.py::test_beam_ends_count_motion_between_node_and_ping",
                "tests/dive/readers/test_pd0.py::test_ranges_along_the_axis_become_ranges_along_the_beams",
            ),
            differs="the four beams of the source's DVL are in `to_sample`, those of other DVLs "
            "by `tilted_beams`: any angle, z of `dvl` out of the transducers (printed: into the "
            "housing), with x and y exchanged. The points are taken on with the lever arm, by "
            "poses of the last adjustment",
        ),
        Part("Fig. 1.9", "SLAM as a factor graph", absent=Absence.PICTURE),
        Part(
            "1.3, eqs (1.2) to (1.4)",
            "squared errors of all factors, and their normal equations",
            studies=("toy-graph",),
            code=(
                "hullrecon/studies/sessions/graph.py:solve",
                "hullrecon/studies/estimates/toy_graph.py:solve_line",
                "native/solve/trust_region.cpp:TrustRegion",
            ),
            tests=("tests/native/test_cores.py",),
            differs="Levenberg-Marquardt in the product, landmarks eliminated (docs/schur.md)",
        ),
        Part(
            "1.3.1, Fig. 1.10",
            "toy graph of three poses and a closure",
            printed="0, 2/3, 4/3",
            code=("hullrecon/studies/estimates/toy_graph.py:solve_line",),
            studies=("toy-graph",),
            tests=("tests/native/test_solve.py::test_the_toy_graph_of_the_source_gives_thirds",),
            differs="nothing",
        ),
        Part(
            "1.3.2, 1.3.2.1, 1.3.2.2, Figs 1.11, 1.12",
            "sessions in one graph, by global poses or anchors",
            printed="low rank before they meet; fewer steps with anchors",
            studies=("sessions/information_matrices",),
            code=(
                "hullrecon/studies/sessions/alignment_study.py:one_frame",
                "hullrecon/studies/sessions/alignment_study.py:draw_information",
                "hullrecon/studies/sessions/anchors.py:Anchored",
            ),
            tests=("tests/studies/sessions/test_anchors.py::test_anchors_leave_no_session_free",),
            differs=f"global localisation (1.3.2.3) is row 2.4.3; {_ONE_DIVE}",
        ),
        Part(
            "1.3.3, Fig. 1.13",
            "robust graphs: switches, dynamic covariance scaling, max-mixtures",
            code=("native/factors/mixture.h:ScalingLoss", "hullrecon/native/links.py:LinkKernel"),
            studies=("links",),
            benchmarks=("benchmarks/false_links.py",),
            tests=(
                "tests/native/test_links.py::test_dynamic_scaling_weighs_links_as_published",
                "tests/native/test_links.py::test_a_switch_multiplies_its_link_and_is_drawn_to_one",
            ),
            differs="max-mixtures for labels of landmarks alone, not for links",
        ),
        Part(
            "1.3.2, incremental solve",
            "smoothing while the vehicle dives",
            studies=("incremental/columns_touched",),
            code=("hullrecon/studies/sessions/incremental.py:SquareRoot",),
            tests=(
                "tests/studies/sessions/test_incremental.py::test_pose_by_pose_ends_where_the_batch_does",
            ),
            differs="dives are processed afterwards, in one batch",
        ),
        Part(
            "1.4, 1.4.1, 1.4.2, eq (1.5), Fig. 1.14",
            "a tank as points, as planes, as an explicit and as an implicit surface",
            studies=("maps/maps_of_one_hull",),
            code=(
                "hullrecon/studies/surfaces/maps.py:dense_map",
                "hullrecon/surface/gaussian.py:regress",
                "hullrecon/navigation/planes/patches.py:find_patches",
            ),
            delivered=("landmarks.ply", "surface.ply"),
            tests=("tests/studies/surfaces/test_maps.py",),
            differs=(
                "the surface is explicit: heights over the CAD model's chart, each with a sigma, "
                "since the CAD model already tells how a hull closes. Nothing is made of (1.5), "
                "which the source defines in its review; dense points are merged by medians"
            ),
        ),
        Part(
            "Figs 1.15 to 1.17",
            "implicit surfaces, bundle adjustment, CAD models, of other works",
            absent=Absence.PICTURE,
        ),
    ),
)
_SINGLE = Chapter(
    title="2.3, 2.5.6. Underwater visual SLAM with planar constraints, in one session",
    parts=(
        Part(
            "2.3.1",
            "poses of six numbers, composed head to tail",
            code=("hullrecon/geometry/poses.py:Poses", "hullrecon/geometry/poses.py:from_rpy"),
            tests=("tests/geometry/test_poses.py",),
            differs="quaternions, perturbed on the right",
        ),
        Part("Figs 2.2, 2.3", "what links compose to; the vehicle's size", absent=Absence.PICTURE),
        Part(
            "2.3, Fig. 2.4",
            "graph of two sessions: anchors, planes, cameras, priors",
            code=(
                "hullrecon/studies/sessions/factors.py:Encounters",
                "hullrecon/studies/sessions/factors.py:PlanePairs",
                "hullrecon/studies/sessions/factors.py:Links",
                "hullrecon/studies/sessions/anchors.py:Anchored",
            ),
            studies=("sessions",),
            tests=("tests/studies/sessions/test_anchors.py",),
            differs="planes are tied within a session only",
        ),
        Part(
            "2.3.2",
            "solver of the graph: incremental, by its square root",
            studies=("incremental",),
            code=(
                "hullrecon/studies/sessions/incremental.py:SquareRoot",
                "native/solve/trust_region.cpp:TrustRegion",
                "native/sparse/selected_inversion.cpp:SelectedInverse",
                "native/solve/pair_covariance.h:pair_covariance",
            ),
            tests=(
                "tests/native/test_pair_covariance.py::test_every_pair_equals_the_dense_inverse",
                "tests/native/test_pair_covariance.py::test_the_innovation_of_a_true_candidate_is_chi_square",
            ),
            differs="the source takes iSAM as it is: here a study has its square root; the product "
            "solves a dive in one batch, and takes covariances of poses and of pairs from the "
            "sparse factor",
        ),
        Part(
            "2.3.3, saliency",
            "only images whose words vary are compared",
            code=("hullrecon/vision/features/extraction.py:local_saliency",),
            tests=(
                "tests/vision/features/test_saliency.py::test_varied_texture_scores_high_and_few_features_low",
            ),
            differs="a vocabulary of 256 random cells, not learnt words",
        ),
        Part(
            "2.3.3, eq (2.1)",
            "camera link of five numbers with dynamic covariance scaling, Phi = 5",
            code=(
                "native/factors/link_residuals.h:BearingLink",
                "native/factors/mixture.h:ScalingLoss",
                "hullrecon/navigation/pose_graph/link_table.py:link_table",
            ),
            tests=(
                "tests/native/test_links.py::test_noisy_links_restore_the_path_despite_wrong_ones",
            ),
            differs="angle between directions and rotation vector in place of azimuth, elevation "
            "and Euler angles; the cost also has Phi (1 - s)² (misprints)",
        ),
        Part(
            "2.3.4, 2.3.4.1, App. B",
            "a plane in three numbers, pi, and its composition with poses, x ⊟ pi and x ⊞ pi",
            code=(
                "native/factors/plane_residuals.h:SeenPlane",
                "hullrecon/studies/sessions/motions.py:plane_in",
                "hullrecon/studies/sessions/motions.py:plane_out",
            ),
            tests=(
                "tests/studies/sessions/test_motions.py::test_points_of_a_plane_stay_on_it_in_another_frame",
                "tests/native/test_planes.py::test_two_parallel_walls_differ_by_the_step_between_them",
            ),
            differs=(
                "as printed, by ⊟ and ⊞, in the studies; in the product planes are held in the "
                "vehicle frame of an anchor node, so that none passes through its origin"
            ),
        ),
        Part(
            "2.3.4.1, eq (2.2)",
            "plane fitted to the DVL's points of a window, tied to its pose",
            code=(
                "native/factors/plane_residuals.h:PlaneSighting",
                "hullrecon/navigation/planes/patch_fit.py:fit_patch",
            ),
            tests=(
                "tests/native/test_planes.py::test_a_sighting_from_the_anchor_compares_the_three_numbers",
            ),
            differs=(
                "patches have curvature and twist; the window's ranges measure the plane one by one"
            ),
        ),
        Part(
            "2.3.4.2, eq (2.3), Fig. 2.5",
            "planes that do not overlap, weighed by the hull's characteristic curvature",
            code=(
                "native/factors/plane_residuals.h:PlanePair",
                "hullrecon/navigation/planes/comparison.py:compare_patches",
                "hullrecon/native/curvature.py",
            ),
            benchmarks=("benchmarks/planes.py",),
            tests=(
                "tests/native/test_planes.py::test_the_weight_counts_the_curvature_the_poses_and_the_floor",
                "tests/navigation/test_planar_graph.py::test_planes_take_a_heading_drift_out_of_the_path",
            ),
            differs="each patch's own curvature, with the characteristic one as prior",
        ),
        Part(
            "2.3.4.3, eqs (2.4), (2.5), Figs 2.6, 2.7",
            "range of a single beam to a plane that is known",
            studies=("lone-beams/lone_beams",),
            code=(
                "native/factors/plane_residuals.h:PlaneRange",
                "hullrecon/studies/sessions/factors.py:Beams",
            ),
            tests=(
                "tests/native/test_planes.py::test_a_beam_meets_a_wall_where_the_corrected_formula_says",
            ),
            differs=(
                "in the product windows whose beams give no patch are left out; with a CAD model "
                "every beam counts"
            ),
        ),
        Part(
            "2.5.6, Figs 2.22, 2.23",
            "the DVL's points on the CAD model without and with planes",
            printed="1.31 ± 1.38 m, 20 % above 1.5 m; 0.45 ± 0.19 m, 0 %",
            code=(
                "hullrecon/studies/paths/path_figures.py:lay_onto_cad_model",
                "hullrecon/studies/paths/path_figures.py:solve_planes",
                "hullrecon/studies/paths/path_figures.py:distance_to_cad_model",
            ),
            studies=("path-figures/distance_to_cad_model",),
            benchmarks=("benchmarks/planes.py",),
            tests=("tests/studies/test_distance_to_cad.py",),
            differs="distance to the surface, not to vertices; hours at sea are minutes here",
        ),
    ),
)
_SESSIONS = Chapter(
    title="2.4, 2.5. Multi-session SLAM, experimental trials",
    parts=(
        Part(
            "2.4, Figs 2.1, 2.8",
            "a ship surveyed, found again, aligned, merged, thinned out, and again",
            studies=("node-removal/graph_complexity", "reacquisition"),
            code=(
                "hullrecon/studies/sessions/removal_study.py:many_sessions",
                "hullrecon/studies/sessions/particles.py:candidates",
            ),
            differs=(
                "two studies that are not chained: the first simulates the links between "
                f"sessions, the particle filter of the second would find them; {_ONE_DIVE}"
            ),
        ),
        Part(
            "2.4.2, Fig. 2.9, eqs (2.7) to (2.9)",
            "sessions aligned by anchors: in one graph (2.7, `join`), in a common frame (2.8, "
            "`in_common_frame`) with its covariance, merged without anchors (2.9, `merged`)",
            printed="without any loss of information",
            studies=("sessions/sessions_aligned",),
            code=(
                "hullrecon/studies/sessions/anchors.py:join",
                "hullrecon/studies/sessions/anchors.py:in_common_frame",
                "hullrecon/studies/sessions/anchors.py:common_frame_derivative",
                "hullrecon/studies/sessions/alignment_study.py:conversion",
                "hullrecon/studies/sessions/anchors.py:merged",
                "hullrecon/studies/sessions/factors.py:Encounters",
            ),
            tests=(
                "tests/studies/sessions/test_anchors.py::test_leaving_anchors_out_keeps_the_sigmas",
            ),
            differs=(
                f"{_ONE_DIVE}; `hullrecon diff` lays two finished dives on one CAD model "
                "(hullrecon/change/offset.py)"
            ),
        ),
        Part(
            "2.4.1, eq (2.6)",
            "nodes removed by generic linear constraints, sparse by a Chow-Liu tree",
            studies=("node-removal",),
            code=(
                "hullrecon/studies/sessions/removal.py:remove_node",
                "hullrecon/studies/sessions/removal.py:linear_factor",
                "hullrecon/studies/sessions/removal.py:tree_of",
            ),
            tests=(
                "tests/studies/sessions/test_removal.py::test_one_factor_of_all_neighbours_is_exact",
                "tests/studies/sessions/test_removal.py::test_a_tree_is_nowhere_surer_by_more_than_a_tenth",
            ),
            differs=_ONE_DIVE,
        ),
        Part(
            "2.4.3, 2.4.3.1, Fig. 2.10",
            "particle filter that finds the vehicle in an old graph by planes",
            printed="cells within 3 m of a plane; search below 250 m²",
            studies=("reacquisition/particles_on_map",),
            code=(
                "hullrecon/studies/sessions/particles.py:plane_distances",
                "hullrecon/studies/sessions/particles.py:weights",
                "hullrecon/studies/sessions/particles.py:spread",
                "hullrecon/studies/sessions/particles_study.py:run",
            ),
            tests=(
                "tests/studies/sessions/test_particles.py::test_the_vehicle_is_among_the_candidates",
            ),
            differs="particles are place and yaw at the measured depth, level; weights as the "
            f"misprints say; {_ONE_DIVE}",
        ),
        Part(
            "2.4.3.2, Algorithm 1",
            "key frames of candidates are matched until one has 12 inliers",
            studies=("reacquisition",),
            code=(
                "hullrecon/studies/sessions/particles.py:candidates",
                "hullrecon/vision/appearance/recognition.py:recognise_places",
            ),
            benchmarks=("benchmarks/outage.py",),
            tests=("tests/vision/appearance/test_recognition.py",),
            differs=(
                "the study finds candidates and takes images of one place to match; the product "
                "finds places again inside one dive, with a control for what looks alike"
            ),
        ),
        Part(
            "2.4.3.3, Fig. 2.11, eq (D.12)",
            "periscope pairs, gated by a plane above water",
            printed="99 % ellipses; similar rows",
            studies=("periscope/periscope_ellipses",),
            code=("hullrecon/studies/sessions/periscope.py:transferred",),
            tests=("tests/studies/sessions/test_periscope.py::test_ellipses_hold_what_is_drawn",),
            differs=_NO_PERISCOPE,
        ),
        Part(
            "2.4.3.4, Algorithm 2, Fig. 2.12",
            "at most three views kept of a place",
            printed="1.5 m, three views",
            studies=("node-removal",),
            code=(
                "hullrecon/studies/sessions/sparsify.py:choose_nodes",
                "hullrecon/studies/sessions/sparsify.py:remove_nodes",
            ),
            tests=(
                "tests/studies/sessions/test_removal.py::test_a_fourth_view_of_a_place_pushes_the_first_out",
            ),
            differs=_ONE_DIVE,
        ),
        Part(
            "Figs 2.13, 2.14",
            "images of different years that are matched, and two that are not",
            absent=Absence.PICTURE,
        ),
        Part(
            "2.5.1, Table 2.1",
            "8 and 12 surveys of two ships",
            printed="2,619 m and 7,540 m",
            absent=Absence.DATA,
            differs="the surveys of two ships by the source's own vehicle",
        ),
        Part(
            "2.5.2, Figs 2.15, 2.18",
            "surveys aligned with a sparsified graph, and the full graph of all",
            studies=("node-removal/ellipses_of_both", "sessions/sessions_aligned"),
            code=("hullrecon/studies/sessions/removal_study.py:many_sessions",),
            differs=f"eight simulated sessions whose links are simulated too; {_ONE_DIVE}",
        ),
        Part(
            "2.5.3, Fig. 2.16",
            "size of the graph by session with and without removal",
            printed="no real time after session 3 without",
            studies=("node-removal/graph_complexity",),
            code=(
                "hullrecon/studies/sessions/removal_study.py:many_sessions",
                "hullrecon/studies/sessions/removal_study.py:draw_sizes",
            ),
            differs=_ONE_DIVE,
        ),
        Part(
            "Algorithm 3",
            "FAB-MAP proposes images of the same place, matching decides",
            code=(
                "benchmarks/fabmap.py:log_likelihoods",
                "benchmarks/appearance.py:retrieval",
            ),
            benchmarks=("benchmarks/appearance.py",),
            tests=(
                "tests/benchmarks/test_appearance.py::test_an_image_is_likeliest_at_its_own_place",
            ),
            differs="line 2 alone: images are ranked by likelihood, without the threshold tau, and "
            "FAB-MAP's candidates are not matched (line 3); the product matches those of its own "
            "words (hullrecon/vision/appearance/recognition.py)",
        ),
        Part(
            "2.5.4, Fig. 2.17, Table 2.2",
            "FAB-MAP beside the particle filter",
            printed=(
                "7.1, 143.2 s, none; 5.2, 20.6, 15.3 s; recall 27.7 and 100 %, precision 12.1 and "
                "3.0 %"
            ),
            studies=("reacquisition",),
            code=(
                "hullrecon/studies/sessions/particles_study.py:run",
                "hullrecon/studies/sessions/particles_study.py:Trial",
            ),
            benchmarks=("benchmarks/appearance.py", "benchmarks/fabmap.py"),
            tests=("tests/benchmarks/test_appearance.py",),
            differs=(
                "the particle filter as a study of a simulated ship, FAB-MAP inside one dive as a "
                "benchmark: not side by side on the same images. Times are of the filter under "
                "water (`Trial.seconds`): no start at the surface, FAB-MAP is not timed"
            ),
        ),
        Part(
            "2.5.5, Figs 2.19 to 2.21",
            "sparsified graph beside the full one",
            printed="well within a metre, 95 % of the nodes removed",
            studies=("node-removal/sparsified_beside_full", "node-removal/ellipses_of_both"),
            code=(
                "hullrecon/studies/sessions/removal_study.py:compare_maps",
                "hullrecon/studies/sessions/removal_study.py:divergence",
                "hullrecon/studies/sessions/removal_study.py:draw_ellipses",
            ),
            differs=_ONE_DIVE,
        ),
    ),
)
_SONAR = Chapter(
    title="3. 3D photomosaicing, sonar mosaics",
    parts=(
        Part(
            "Figs 3.1, 3.4 to 3.6",
            "coverage by camera and sonar; the sonar's geometry",
            absent=Absence.PICTURE,
        ),
        Part(
            "3.2.1",
            "poses of the sonar from SLAM without a camera",
            code=(
                "hullrecon/steps/sonar.py:sonar_poses",
                "hullrecon/navigation/planes/planar_graph.py:PlanarGraph",
            ),
            delivered=("ortho_sonar.tif",),
            tests=("tests/end_to_end/test_no_camera.py",),
            differs="of whatever path the dive has: by images and the CAD model where there are "
            "some, by planes alone without",
        ),
        Part(
            "3.2.2.1, outliers",
            "returns far from their 30 neighbours are left out",
            printed="one sigma",
            code=("hullrecon/surface/from_returns.py:statistical_inliers",),
            tests=(
                "tests/surface/test_from_returns.py::test_a_return_far_from_its_neighbours_is_an_outlier",
            ),
            differs="three sigmas: one cuts what is right",
        ),
        Part(
            "3.2.2, 3.2.2.1, Fig. 3.2",
            "surface by linear interpolation, faces halved down to 0.1 m",
            code=(
                "hullrecon/studies/surfaces/regression.py:by_triangles",
                "hullrecon/geometry/meshes/refinement.py:refine",
            ),
            studies=("maps/surface_meshes", "surfaces"),
            tests=(
                "tests/studies/test_surface_variants.py::test_linear_interpolation_runs_on_the_same_input",
                "tests/geometry/test_refinement.py::test_no_edge_stays_longer_than_wanted_and_the_area_is_kept",
            ),
            differs="on the hull's chart, sides included, between means over quarter cells; the "
            "length is `surface.max_edge_m`; the product regresses",
        ),
        Part(
            "3.2.2.2, Fig. 3.3, eqs (3.1) to (3.3), E.1, E.2",
            "surface by Gaussian process with a sparse kernel",
            printed="lengths 3 and 15 m",
            code=(
                "hullrecon/surface/gaussian.py:Regression",
                "hullrecon/surface/gaussian.py:fit",
                "hullrecon/surface/gaussian.py:Kernel",
                "hullrecon/studies/surfaces/regression.py:RadialKernel",
            ),
            studies=("maps/surface_meshes", "surfaces"),
            delivered=("surface.ply",),
            tests=(
                "tests/surface/test_gaussian.py::test_mean_and_variance_equal_the_textbook_formulas",
                "tests/studies/test_surface_variants.py::test_product_and_wendland_are_covariances",
            ),
            differs=(
                "offsets from the CAD model; a product of kernels, as the printed radial one is "
                "no covariance"
            ),
        ),
        Part(
            "3.2.3",
            "pixel to range and beam, and back by a table of voxels",
            code=(
                "hullrecon/mosaic/sonar.py:SonarFan",
                "hullrecon/mosaic/sonar.py:build_fan",
            ),
            tests=("tests/mosaic/test_sonar_fan.py::test_bins_and_beams_are_those_of_the_image",),
            differs="a point's range bin and beam are computed (`SonarFan.locate`), so that no "
            "table is needed; beams by their logged directions, interpolated, not by a polynomial",
        ),
        Part(
            "3.2.4",
            "the four best pings, blended in three bands",
            printed="k = 5, 10, 50; u = w/2, v = 3h/4",
            code=(
                "hullrecon/mosaic/blend.py:choose_views",
                "hullrecon/mosaic/blend.py:blend",
                "native/mosaic/views.cpp:band_weight",
                "hullrecon/mosaic/sonar.py:SonarFan",
            ),
            tests=("tests/mosaic/test_blend.py",),
            differs="chosen and weighed by texel, not by face, with a cost for slant; r and R in "
            "metres on the fan's display, R to its farthest corner (`SonarFan.locate`)",
        ),
        Part(
            "Fig. 3.7",
            "the mosaic on the CAD model and on the DVL's surface",
            delivered=("mosaic_sonar.glb", "ortho_sonar.tif"),
            studies=("mosaics/sonar_mosaics",),
            code=(
                "hullrecon/mosaic/output/textured_mesh.py:build_textured_mesh",
                "hullrecon/studies/surfaces/mosaics.py:draw_sonar_mosaics",
            ),
            differs="delivered on the hull as found, else on the DVL's surface",
        ),
        Part("3.3.1", "eight surveys in one mosaic", absent=Absence.DATA, differs=_ONE_DIVE),
        Part(
            "3.3.2, Fig. 3.8",
            "four sources of poses; the DVL's points laid on the CAD model",
            code=(
                "hullrecon/studies/surfaces/pose_sources.py:place_paths",
                "hullrecon/adjustment/hull_pose/registration.py:register",
            ),
            studies=("surfaces-by-source/registration",),
            delivered=("alignment.json",),
            differs="dead reckoning is a fifth source; generalised ICP, then a least-squares fit "
            "that knows how wrong a CAD model may be",
        ),
        Part(
            "3.3.3, Figs 3.9, 3.10",
            "distance of either surface to the CAD model, by source of poses",
            printed="colours from 0 to 70 cm",
            code=(
                "hullrecon/studies/surfaces/by_source.py:make_surface",
                "hullrecon/studies/surfaces/by_source.py:measure",
                "hullrecon/studies/surfaces/pose_sources.py:place_paths",
            ),
            studies=("surfaces-by-source/deviation_by_source",),
            delivered=("deviation.tif",),
            tests=("tests/studies/surfaces/test_by_source.py",),
            differs=(
                "heights over a plane, so that the CAD model does not enter; on metres of hull "
                "images hold the form, and linear interpolation is worst at its rim"
            ),
        ),
        Part(
            "Figs 3.11, 3.12",
            "variance of the blended intensities by source of poses",
            printed="tails above 20 heavier without bundle adjustment",
            code=(
                "hullrecon/studies/surfaces/sonar_scene.py:paint_pings",
                "hullrecon/studies/paths/path_figures.py:variance_map",
            ),
            studies=("sonar-variance", "path-figures/sonar_variance"),
            tests=("tests/studies/surfaces/test_sonar_scene.py",),
            differs=(
                "of a dive's own pings speckle outweighs poses; the study paints the hull so that "
                "poses show"
            ),
            delivered=("variance_sonar.tif",),
        ),
        Part(
            "E.3",
            "joint covariance of predictions",
            studies=("joint-predictions",),
            code=(
                "hullrecon/studies/estimates/joint_predictions.py:joint_covariance",
                "hullrecon/surface/gaussian.py",
            ),
            differs="the product gives sigmas of single vertices",
        ),
    ),
)
_MODEL = Chapter(
    title="4.2. Model-assisted bundle adjustment with a CAD model",
    parts=(
        Part(
            "Figs 4.1, 4.2, 4.5, 4.6",
            "overviews and drawings of the factors",
            absent=Absence.PICTURE,
        ),
        Part(
            "4.2.1",
            "poses, hull, landmarks, mounts and hidden labels in one problem",
            code=(
                "hullrecon/native/problem.py:Unknowns",
                "hullrecon/native/problem.py:Problem",
                "hullrecon/native/solver.py:Result",
                "hullrecon/adjustment/problem/assembly.py:assemble",
            ),
            tests=("tests/adjustment/test_assembly.py",),
            differs=(
                "X is `Unknowns`, Z the tables and `priors` of `Problem`, M_prior its `cad_mesh`; "
                "Lambda is `Result.label`: labels follow from X, so that they stand beside it and "
                "not in `Unknowns`. Unknown are also lenses, "
                "systematic errors of the navigation and a field of the CAD model's error"
            ),
        ),
        Part(
            "4.2.2, eqs (4.1) to (4.3)",
            "labels by expectation and maximisation in turns",
            code=(
                "hullrecon/studies/methods/hard_em.py:solve",
                "hullrecon/studies/methods/hard_em.py:likelier_labels",
            ),
            tests=("tests/studies/test_hard_em.py::test_both_ways_reach_the_same_cost_and_labels",),
            differs="step 2(b) is a solve with labels held; the product decides them inside the "
            "solve: same cost, one solve (docs/adr)",
        ),
        Part(
            "4.2.3, Fig. 4.3, eqs (4.4), (4.5)",
            "signed distance of a landmark to the hull with one of two sigmas",
            code=(
                "native/factors/hull_residuals.h:Surface",
                "native/mesh/mesh_index.cpp",
                "native/factors/mixture.h:MixtureLoss",
            ),
            tests=(
                "tests/native/test_factors.py::test_surface_residual_is_distance_less_deviation_field",
            ),
            differs="(4.5) to the nearest point of the mesh, beside edges too, less a field of the "
            "CAD model's error; the two sigmas of (4.4) are in the loss",
        ),
        Part(
            "4.2.4, Fig. 4.4, eqs (4.6), (4.7)",
            "the likelier of two labels inside the solve",
            printed="sigmas 1 and 0.02 m",
            studies=("label-boundary",),
            code=("native/factors/mixture.h:MixtureLoss",),
            tests=(
                "tests/native/test_factors.py::test_label_changes_at_56_mm_and_cost_is_the_winners",
            ),
            differs="equal weights of both labels",
        ),
        Part(
            "4.2.5",
            "the DVL's points registered to the CAD model as first guess",
            code=("hullrecon/adjustment/hull_pose/registration.py:register",),
            tests=(
                "tests/adjustment/test_registration.py::test_a_curved_side_is_found_from_a_wrong_guess",
            ),
            differs="from nine starts; refused where it does not fit",
        ),
        Part(
            "4.2.6, eqs (4.8) to (4.11)",
            "priors (4.8), depth and attitude (4.9), servo (4.10), odometry (4.11)",
            code=(
                "native/factors/navigation_residuals.h:MotionPrior",
                "native/factors/navigation_residuals.h:Attitude",
                "native/factors/navigation_residuals.h:Tray",
                "native/factors/navigation_residuals.h:Odometry",
            ),
            tests=(
                "tests/native/test_factors.py::test_odometry_is_in_the_first_vehicle_less_systematic_part",
            ),
            differs=(
                "and backlash of the servo on both sides, scale and mount of the DVL, drift of "
                "the heading"
            ),
        ),
        Part(
            "4.2.6, eqs (4.12), (4.13)",
            "reprojection in two cameras, or one, through the servo",
            code=(
                "native/factors/image_residuals.h:Stereo",
                "native/factors/image_residuals.h:Mono",
            ),
            tests=(
                "tests/native/test_factors.py::test_stereo_pixels_are_those_of_the_distorted_pinhole",
            ),
            differs="raw pixels with distortion in place of rectified ones; also the pose of one "
            "camera in the other, intrinsics and lenses are unknowns",
        ),
        Part(
            "4.2.6, eq (4.14), Fig. 4.7",
            "range of a beam cast to the CAD model, Huber's loss",
            code=("native/factors/hull_residuals.h:Range", "native/model/association.cpp"),
            tests=(
                "tests/native/test_solve.py::test_a_beam_that_misses_the_hull_is_switched_off_and_counted",
            ),
            differs="the CAD model is moved outward by a field of its error; the DVL's mount is an "
            "unknown; beams that miss the hull or graze it are switched off",
        ),
        Part(
            "4.2.7",
            "SIFT; three points of a stereo pair, or an essential matrix with Sampson's distance",
            code=(
                "hullrecon/vision/pairs/pose_from_points.py:ransac",
                "hullrecon/vision/pairs/two_view.py:fit_both",
                "hullrecon/vision/pairs/two_view.py:sampson_squared",
                "hullrecon/vision/pairs/mono_motion.py:refine",
            ),
            tests=(
                "tests/vision/pairs/test_two_view.py::test_sampson_error_is_distance_to_nearest_pair_that_fits",
            ),
            differs="points of two pairs are compared in pixels, not metres (D.2.3); one camera "
            "may take a homography; no graphics card",
        ),
    ),
)
_SHAPES = Chapter(
    title="4.3, 4.4. Model-assisted visual mapping, results",
    parts=(
        Part(
            "4.3.2, Algorithm 4, Fig. 4.8",
            "features off the hull, clustered, as an alpha shape",
            studies=("shapes/shapes_of_view",),
            code=("hullrecon/detection/as_found/shapes.py:detect_shapes",),
            tests=("tests/detection/test_shapes.py",),
            differs="bumps and recesses apart",
        ),
        Part(
            "4.3.3, Algorithm 5, eq (4.15), Fig. 4.9",
            "shapes move vertices along rays, running mean",
            code=(
                "hullrecon/studies/surfaces/regression.py:fuse_shapes",
                "hullrecon/detection/as_found/shapes.py:find_shape_hits",
            ),
            studies=("shapes/fused_vertex", "surfaces"),
            tests=(
                "tests/studies/test_ray_fusion.py::test_the_first_observation_replaces_the_prior",
            ),
            differs="the product regresses heights robustly, with sigma and p-value",
        ),
        Part(
            "Table 4.1",
            "size of the two datasets",
            printed="9,249 and 44,868 images, 100,597 and 243,536 features",
            benchmarks=("benchmarks/adjustment.py", "benchmarks/problems.py"),
            tests=("tests/benchmarks/test_problems.py",),
            differs="simulated in the same numbers: the field data are not public",
        ),
        Part(
            "4.4.1, Fig. 4.10",
            "cross-sections by naive, Geva's and the proposed method, two cameras",
            printed="growth squeezed by Geva's",
            code=(
                "hullrecon/studies/methods/sections.py:cut_section",
                "hullrecon/studies/methods/adjust_variant.py:strategy_of",
            ),
            studies=("methods", "method-figures/cross_sections"),
            differs="a simulated hull with its truth; each method as published, and as weighted "
            "here",
        ),
        Part(
            "Fig. 4.11",
            "the same with one camera",
            code=("hullrecon/studies/methods/sections.py:cut_section",),
            studies=("method-figures/cross_sections",),
            differs="on a dive with one camera: --dive",
        ),
        Part(
            "Fig. 4.12",
            "share of landmarks on the hull by iteration",
            printed="begins at 0.82 and 0.34, settles after some 20",
            code=("hullrecon/studies/methods/histories.py:label_frequency",),
            studies=("method-figures/label_frequency",),
            delivered=("plots/",),
            differs="a simulated dive; of the rounds of a solve the last one",
        ),
        Part(
            "Fig. 4.13",
            "iterations and time of the methods",
            printed="26, 38, 29 iterations, +50.0 and +22.3 %; 47, 46, 51, +36.8 and +8.9 %",
            code=(
                "hullrecon/studies/methods/histories.py:cost_history",
                "hullrecon/studies/methods/histories.py:label_frequency",
            ),
            studies=("method-figures/cost_history",),
            benchmarks=("benchmarks/adjustment.py",),
            differs="a simulated dive; the solves as published and, below, those of the product, "
            "in rounds",
        ),
        Part(
            "Fig. 4.14",
            "residuals of the DVL's ranges before and after",
            printed="narrower; no number",
            code=("hullrecon/studies/methods/sections.py:range_residuals",),
            studies=("method-figures/range_residuals",),
            tests=("tests/studies/test_dvl_residuals.py",),
            differs="a simulated dive; after the adjustment, the CAD model moved by its field",
        ),
        Part(
            "4.4.2.1, Fig. 4.15",
            "growth beside dense stereo",
            printed="0.06 to 0.18 m, 0.10 to 0.20 m",
            code=("hullrecon/studies/structures/dense_stereo.py:dense_points",),
            studies=("dense-stereo/dense_heights",),
            tests=(
                "tests/studies/structures/test_dense_stereo.py::test_plate_and_wall_lie_at_their_distances",
            ),
            differs=(
                "OpenCV's semi-global matching on single pairs, in the study alone: the product's "
                "heights are of landmarks"
            ),
        ),
        Part(
            "4.4.2.1, Fig. 4.16",
            "height of a cylinder that is known",
            printed="0.10 m for 0.11 m",
            code=("hullrecon/studies/methods/plots.py:structure_heights",),
            studies=("method-figures/structure_height",),
            delivered=("objects.json",),
            differs="a simulated cylinder, else the highest structure that was well seen; by each "
            "method, and as delivered",
        ),
        Part(
            "4.4.2.2, Figs 4.17, 4.18",
            "the remeshed hull at two thresholds",
            printed="0 and 0.06 m",
            code=(
                "hullrecon/studies/structures/thresholds.py:remesh",
                "hullrecon/detection/as_found/hull_as_found.py:estimate_hull_as_found",
            ),
            studies=("thresholds",),
            tests=("tests/studies/structures/test_thresholds.py",),
            delivered=("as_found.ply", "form.tif"),
            differs="simulated, so that structures found, missed and false are counted; the "
            "product decides by p-value, not by one threshold",
        ),
        Part(
            "4.4.2.2, Fig. 4.19",
            "photomosaic on the remeshed hull and on the CAD model",
            code=(
                "hullrecon/studies/surfaces/mosaics.py:close_up",
                "hullrecon/mosaic/optical.py:optical_mosaic",
            ),
            studies=("mosaics/mosaic_relief",),
            delivered=("mosaic_optical.glb",),
            differs="delivered on the hull as found; the page's 3-D view slides between both",
        ),
    ),
)
_FUTURE = Chapter(
    title="5. Future work",
    parts=(
        Part(
            "5.2, active SLAM",
            "where to drive, by planes",
            studies=("next-leg/next_legs",),
            code=("hullrecon/studies/sessions/next_leg.py:foreseen_sigma",),
            tests=(
                "tests/studies/sessions/test_next_leg.py::test_a_leg_that_meets_an_old_one_is_worth_more",
            ),
            differs="dives are processed afterwards; coverage.json names holes",
        ),
        Part(
            "5.2, sonar features",
            "structure from motion by sonar, its servo as an unknown, registered to the CAD model",
            studies=("sonar-structure/sonar_features",),
            code=("hullrecon/studies/sonar/structure.py:estimate",),
            tests=("tests/studies/sonar/test_structure.py::test_the_hull_resolves_elevation",),
            differs=_SONAR_BLENDS,
        ),
        Part(
            "5.2, learning",
            "registered data to learn features from",
            absent=Absence.NOT_BUILT,
            code=("hullrecon/api/export.py:export_colmap",),
            differs=(
                "future work in the source, without a method or a number; `export colmap` gives "
                "images with poses and tracks, pings are not exported"
            ),
        ),
    ),
)
_APPENDICES = Chapter(
    title="Appendices",
    parts=(
        Part(
            "A, Fig. A.1",
            "frames and their composition",
            code=("hullrecon/geometry/poses.py:Poses",),
            tests=("tests/geometry/test_poses.py::test_composition_is_one_after_the_other",),
            differs="quaternions; which way R leads is among the misprints",
        ),
        Part(
            "B.1 to B.5, eq (B.1), Figs B.1, B.2",
            "forms of a plane, and the one that is estimated",
            code=("native/factors/plane_residuals.h:SeenPlane",),
            tests=(
                "tests/native/test_planes.py::test_a_wall_is_led_into_a_frame_by_the_inverse_of_what_leads_it_out",
            ),
            differs="normal and distance inside, their product as the unknown, held at an anchor "
            "(B.4); no spherical form (B.2), which is singular at its poles",
        ),
        Part(
            "B.6",
            "direction of a plane by azimuth and elevation, and its distance",
            code=("hullrecon/native/curvature.py:curvature_difference",),
            tests=("tests/native/test_planes.py",),
            differs="azimuth and elevation serve the curvature alone; its signs are among the "
            "misprints (2.3.4.2)",
        ),
        Part(
            "C, Figs C.1, C.2",
            "a sphere mapped by planes, for several characteristic radii",
            printed="r = 8 m, alike from 4 to 20 m",
            code=(
                "hullrecon/studies/scenes/ellipsoid_dive.py:spiral_around_a_sphere",
                "hullrecon/studies/scenes/sphere.py:fit_sphere",
            ),
            studies=("scene-figures/sphere",),
            tests=(
                "tests/navigation/test_planar_graph.py::test_sphere_is_mapped_alike_for_characteristic_radii",
            ),
            differs=(
                "r = 10 m; planes do not say where on the sphere the vehicle is, and the end of "
                "the path shows it"
            ),
        ),
        Part(
            "D.1, Fig. D.1, eq (D.1)",
            "pinhole with radial distortion",
            code=(
                "native/factors/camera.h:project",
                "hullrecon/geometry/cameras.py:CameraModel",
            ),
            tests=("tests/geometry/test_cameras.py",),
            differs="three radial terms and two tangential",
        ),
        Part(
            "D.1, planes, eq (D.2)",
            "a pixel's ray met with a plane",
            studies=("periscope",),
            code=("hullrecon/studies/sessions/periscope.py:transferred",),
            tests=("tests/studies/sessions/test_periscope.py::test_ellipses_hold_what_is_drawn",),
            differs="in a study alone, as part of (D.12); the printed depth is among the misprints",
        ),
        Part(
            "D.1.1, eqs (D.3) to (D.5)",
            "covariance of a two-view pose",
            code=(
                "hullrecon/vision/pairs/mono_motion.py:covariance_of",
                "hullrecon/vision/pairs/stereo_adjustment.py:adjust_stereo_motion",
            ),
            tests=(
                "tests/vision/pairs/test_mono_motion.py::test_five_numbers_scatter_as_their_covariance_says",
            ),
            differs="points are left out to first order by Sampson's distance (one camera) or "
            "eliminated (two); and what neighbouring features share",
        ),
        Part(
            "D.1.2, eqs (D.6) to (D.8)",
            "calibration's share of it, to first order",
            studies=("uncertain-calibration",),
            code=(
                "hullrecon/studies/calibration/two_views.py:first_order",
                "hullrecon/vision/pairs/stereo_adjustment.py:adjust_stereo_motion",
                "hullrecon/navigation/stereo_odometry/stereo_path.py:by_calibration",
            ),
            tests=(
                "tests/vision/pairs/test_stereo_adjustment.py::test_error_of_rig_moves_motion_as_its_derivative_says",
            ),
            differs="second derivatives times residuals are left out; in the product two cameras, "
            "whose errors are one unknown for the dive, summed in stereo_path.py; lenses are "
            "unknowns of the adjustment",
        ),
        Part(
            "D.1.3, Algorithm 6, eq (D.9)",
            "the same by unscented transform",
            code=(
                "hullrecon/studies/calibration/two_views.py:unscented",
                "hullrecon/studies/calibration/wall.py:sigmas_of_wall",
            ),
            studies=("uncertain-calibration",),
            tests=(
                "tests/studies/calibration/test_two_views.py::test_sigma_points_tell_large_errors_better",
            ),
            differs="lines 5 to 10 are `unscented`; Sigma_HZ of line 4 and the sum of line 11 are "
            "in `sigmas_of_wall`, about the true motion in place of line 2's fit. The five numbers "
            "are about that motion: their mean is no mean of angles. In the product the lens is an "
            "unknown of the adjustment, to first order",
        ),
        Part(
            "D.2",
            "a point in both cameras of a calibrated pair",
            code=("native/factors/image_residuals.h:Stereo",),
            tests=(
                "tests/native/test_factors.py::test_stereo_pixels_are_those_of_the_distorted_pinhole",
            ),
            differs="as (4.12): raw pixels with distortion; the camera's mount and the pose of the "
            "bottom camera in the top one are unknowns",
        ),
        Part(
            "D.2.1, D.2.2, Fig. D.2, eqs (D.10), (D.11)",
            "rectified pairs, triangulation",
            printed="baseline 77.6 mm",
            studies=("dense-stereo/rectified_pair",),
            code=(
                "hullrecon/vision/stereo/matching.py:rectify",
                "hullrecon/vision/stereo/matching.py:triangulate",
                "hullrecon/vision/stereo/matching.py:match_stereo",
                "hullrecon/studies/structures/dense_stereo.py:rectified_pair",
            ),
            tests=(
                "tests/vision/stereo/test_rectification.py::test_point_lies_on_one_column_whatever_way_rig_is_built",
            ),
            differs="columns are compared after rectification; (D.10) is not evaluated, as it is "
            "no distance (misprints)",
        ),
        Part(
            "D.2.3",
            "motion between two stereo pairs from three points",
            code=("hullrecon/vision/pairs/pose_from_points.py:ransac",),
            tests=("tests/vision/pairs/test_pose_from_points.py",),
            differs="in pixels, not metres",
        ),
        Part(
            "D.2.2, Fig. D.3",
            "disparity and range images",
            code=("hullrecon/studies/structures/dense_stereo.py:disparities",),
            studies=("dense-stereo/range_image",),
            tests=(
                "tests/studies/structures/test_dense_stereo.py::test_plate_and_wall_lie_at_their_distances",
            ),
            differs="in a study alone",
        ),
        Part(
            "D.3, Fig. D.4, eq (D.12)",
            "is a transferred point Gaussian?",
            printed="fairly, except where uncertainty is large",
            code=(
                "hullrecon/studies/sessions/periscope.py:transferred",
                "hullrecon/vision/pairs/gating.py:transfer",
                "hullrecon/studies/scenes/search_ellipses.py:search_ellipses",
            ),
            studies=("scene-figures/search_ellipses", "periscope"),
            tests=(
                "tests/studies/test_scene_figures.py::test_transfer_is_gaussian_unless_the_pose_is_hardly_known",
            ),
            differs=(
                "in the product a depth with sigma in place of a plane with covariance; the plane "
                "as printed in the study of the periscope"
            ),
        ),
    ),
)

_MISPRINTS = (
    Misprint(
        where="1.2.1",
        printed="b = 1 / cos 30° = 0.2887",
        right="1 / (4 cos 30°); and the velocity is the sensor's with its sign changed",
        tests=(
            "tests/dive/readers/test_pd0.py::test_velocity_is_opposite_to_bottom_with_z_into_housing",
            "tests/dive/readers/test_pd0.py::test_beam_velocities_are_inverted_also_with_one_beam_lost",
            "tests/dive/readers/test_pd0.py::test_factor_of_all_beams_is_the_printed_number_not_the_printed_formula",
        ),
    ),
    Misprint(
        where="(2.1)",
        printed="cost scaled by s² alone",
        right="and Phi (1 - s)², else s = 0 costs nothing",
        tests=(
            "tests/native/test_links.py::test_dynamic_scaling_weighs_links_as_published",
            "tests/native/test_links.py::test_scale_alone_as_printed_makes_the_worse_link_cheaper",
        ),
    ),
    Misprint(
        where="(2.3)",
        printed="norm without square; W called a weight",
        right="squared; W is a covariance",
        tests=(
            "tests/native/test_planes.py::test_a_pair_costs_the_square_in_the_inverse_of_its_covariance",
        ),
    ),
    Misprint(
        where="2.3.4.2",
        printed="the misfit to the curved surface stands in W",
        right="what curvature explains: a misfit would widen its own covariance",
        tests=(
            "tests/native/test_planes.py::test_the_weight_counts_the_curvature_the_poses_and_the_floor",
            "tests/native/test_planes.py::test_a_misfit_in_its_own_covariance_as_printed_costs_the_same_however_large",
        ),
    ),
    Misprint(
        where="2.3.4.2",
        printed="t_y / r_a and t_z / r_e whatever the normal",
        right="signs by the normal's direction",
        tests=(
            "tests/native/test_planes.py::test_curvature_radii_by_azimuth_and_elevation_have_signs",
            "tests/native/test_planes.py::test_lean_by_the_step_along_y_as_printed_is_right_for_a_hull_astern_alone",
        ),
    ),
    Misprint(
        where="(2.4)",
        printed="|x ⊖ pi| / (r' (x ⊖ pi))",
        right="-|pi|² / (r' pi) with pi = x ⊟ pi",
        tests=(
            "tests/native/test_planes.py::test_a_beam_meets_a_wall_where_the_corrected_formula_says",
            "tests/native/test_planes.py::test_length_of_a_beam_as_printed_is_negative_and_the_same_from_any_distance",
        ),
    ),
    Misprint(
        where="(2.5)",
        printed="sigma called a variance inside the square",
        right="standard deviation",
        tests=(
            "tests/native/test_planes.py::test_a_ray_from_elsewhere_is_as_long_as_the_corrected_formula_says",
        ),
    ),
    Misprint(
        where="2.4.3.1",
        printed="w = d²(z, x_gi ⊟ x_gi')",
        right="the particle's own pose, pi_gi', and exp(-d²/2): else the worst fit weighs most",
        tests=(
            "tests/studies/sessions/test_particles.py::test_the_right_pose_has_the_largest_weight_and_not_as_printed",
            "tests/studies/sessions/test_particles.py::test_the_print_takes_the_nodes_pose_for_the_particles_own",
        ),
    ),
    Misprint(
        where="2.4.3.1, Fig. 2.10",
        printed="cells outside the nearest plane are free; cells within 3 m of a plane",
        right="both together",
        tests=(
            "tests/studies/sessions/test_particles.py::test_particles_start_before_the_hull_within_three_metres",
            "tests/studies/sessions/test_particles.py::test_each_of_the_two_rules_for_free_cells_alone_as_printed_leaves_too_many",
        ),
    ),
    Misprint(
        where="Fig. 2.16",
        printed="SS Curtiss, sessions 5 to 12 three years after 1 to 4",
        right="by Table 2.1 sessions 9 to 12 are of 2011, three years before",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_no_session_comes_three_years_after_the_first_as_printed_four_come_before",
        ),
    ),
    Misprint(
        where="Figs 2.19, 2.20",
        printed="2014 USS Saratoga, USS Curtiss",
        right="2013, SS Curtiss",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_the_saratoga_was_surveyed_in_2013_not_in_2014_as_printed",
            "tests/studies/catalogue/test_printed_tables.py::test_no_ship_is_called_uss_curtiss_as_printed",
        ),
    ),
    Misprint(
        where="2.5.6",
        printed="range factors from (2.4)",
        right="(2.5)",
        tests=(
            "tests/studies/sessions/test_next_leg.py::test_a_length_alone_as_printed_is_no_factor_at_the_truth",
        ),
    ),
    Misprint(
        where="(3.3)",
        printed="variance with 1/beta always added",
        right="that is the next return's; the surface's is without it",
        tests=(
            "tests/surface/test_gaussian.py::test_the_next_return_is_less_certain_than_the_surface",
        ),
    ),
    Misprint(
        where="3.2.2.2, kernel",
        printed="compact kernel of the distance in the plane",
        right="no covariance there: product of two, or Wendland's",
        tests=(
            "tests/studies/test_surface_variants.py::test_radial_kernel_that_is_no_covariance_is_refused",
        ),
    ),
    Misprint(
        where="3.2.2.2",
        printed="training pairs (x_i, y_i); r without transpose",
        right="(x_i, z_i); (x - x')'",
        tests=(
            "tests/studies/test_surface_variants.py::test_training_by_the_second_coordinate_as_printed_makes_no_surface",
            "tests/studies/test_surface_variants.py::test_radius_of_the_kernel_needs_the_transpose_that_is_not_printed",
        ),
    ),
    Misprint(
        where="3.2.3",
        printed="n_b from range, n_r from bearing; M_4 of fourth degree",
        right="the other way about; third degree",
        tests=(
            "tests/mosaic/test_sonar_fan.py::test_bins_and_beams_are_those_of_the_image",
            "tests/mosaic/test_sonar_fan.py::test_beam_by_range_and_bin_by_bearing_as_printed_are_outside_the_image",
            "tests/mosaic/test_sonar_fan.py::test_four_coefficients_of_beams_are_of_third_degree_not_of_fourth_as_printed",
        ),
    ),
    Misprint(
        where="3.3.2.1",
        printed="this deviation measures the orthogonal distance",
        right="belongs to 3.3.3",
        tests=(
            "tests/native/test_planes.py::test_planes_are_not_compared_by_an_orthogonal_distance_as_printed",
        ),
    ),
    Misprint(
        where="(4.5)",
        printed="plane of the closest triangle",
        right="nearest point: the plane is wrong beside edges",
        tests=(
            "tests/geometry/test_casting.py::test_beside_an_edge_the_distance_is_not_that_to_the_triangles_plane",
        ),
    ),
    Misprint(
        where="(4.6)",
        printed="log p proportional to the log of a product",
        right="equal up to a constant",
        tests=(
            "tests/studies/estimates/test_toy_graph.py::test_the_posterior_is_its_product_up_to_a_constant_not_a_factor",
        ),
    ),
    Misprint(
        where="Fig. 4.8",
        printed="deviation along a ray",
        right="Algorithm 4 and 4.1.1: orthogonal distance",
        tests=(
            "tests/detection/test_landmarks.py::test_offset_is_orthogonal_and_not_along_the_ray_as_printed",
        ),
    ),
    Misprint(
        where="Algorithm 5, line 4",
        printed="Algorithm 1",
        right="Algorithm 4",
        tests=(
            "tests/studies/test_ray_fusion.py::test_rays_meet_the_shapes_of_algorithm_4_not_the_key_frames_of_1_as_printed",
        ),
    ),
    Misprint(
        where="(4.15)",
        printed="v_0 = prior with n = 0",
        right="so the first observation replaces the prior",
        tests=("tests/studies/test_ray_fusion.py::test_the_first_observation_replaces_the_prior",),
    ),
    Misprint(
        where="4.4.1",
        printed="Geva's is slower by more iterations",
        right="one camera: 46 against 47 iterations, yet +36.8 %",
        tests=(
            "tests/studies/catalogue/test_printed_tables.py::test_iterations_explain_the_time_of_two_cameras_and_not_as_printed_of_one",
        ),
    ),
    Misprint(
        where="App. A",
        printed="X_j = R X_i + t",
        right="X_i = R X_j + t",
        tests=(
            "tests/geometry/test_poses.py::test_composition_is_one_after_the_other",
            "tests/geometry/test_poses.py::test_pose_of_j_in_i_brings_points_to_i_not_to_j_as_printed",
        ),
    ),
    Misprint(
        where="App. B",
        printed="with respect to frame j: pi_ik = x_ij ⊞ pi_jk",
        right="frame i; ⊟ for the way back",
        tests=(
            "tests/native/test_planes.py::test_a_wall_seen_from_the_side_is_turned_and_nearer",
            "tests/native/test_planes.py::test_a_wall_is_led_into_a_frame_by_the_inverse_of_what_leads_it_out",
        ),
    ),
    Misprint(
        where="D.1",
        printed="depth -|pi|² / (v' pi) for a camera anywhere",
        right="-(|pi|² + pi' t_gc) / (v' pi)",
        tests=(
            "tests/native/test_planes.py::test_a_ray_from_elsewhere_is_as_long_as_the_corrected_formula_says",
        ),
    ),
    Misprint(
        where="D.1.1",
        printed="Theta has P_1 to P_(M-5); S_X in the third line",
        right="(M - 5) / 3 points; its inverse",
        tests=(
            "tests/studies/calibration/test_two_views.py::test_unknowns_of_two_views_hold_a_third_as_many_points_as_printed",
            "tests/studies/calibration/test_two_views.py::test_covariance_of_a_fit_has_the_inverse_in_every_line_unlike_the_print",
        ),
    ),
    Misprint(
        where="D.2.1",
        printed="u' F u is a squared distance to the epipolar line",
        right="algebraic: neither squared nor normalised",
        tests=(
            "tests/vision/pairs/test_two_view.py::test_sampson_error_is_distance_to_nearest_pair_that_fits",
            "tests/vision/pairs/test_two_view.py::test_product_with_the_essential_matrix_is_no_squared_distance",
        ),
    ),
    Misprint(
        where="D.2.2",
        printed="q14, q24 are the camera centre",
        right="minus the principal point; q43 is 1 / baseline",
        tests=(
            "tests/studies/structures/test_dense_stereo.py::test_depth_by_q_takes_one_over_the_baseline",
        ),
    ),
    Misprint(
        where="D.3",
        printed="<u_i, v_j>; Sigma_0 for two things",
        right="u_i, v_i; Sigma_x",
        tests=(
            "tests/studies/sessions/test_periscope.py::test_a_column_and_a_row_of_two_images_as_printed_lead_elsewhere",
            "tests/studies/sessions/test_periscope.py::test_the_covariance_of_all_as_printed_is_none_of_a_pose",
        ),
    ),
    Misprint(
        where="E.3",
        printed="p(y, z_t), with the returns' noise on test values too",
        right="p(z, z_t), noise on the returns alone",
        tests=(
            "tests/studies/estimates/test_joint_predictions.py::test_it_is_the_conditional_of_the_joint_normal",
        ),
    ),
)

_TRIALS = Survey(
    number="2.5.1, Table 2.1",
    about="Sessions on two ships; length of the way in m",
    heads=("ship", "session", "date", "cameras", "survey", "length"),
    rows=(
        ("USS Saratoga", "1", "2013-05-21", "periscope", "surface", "239"),
        ("USS Saratoga", "2", "2013-05-21", "periscope", "surface", "136"),
        ("USS Saratoga", "3", "2013-05-21", "both", "both", "334"),
        ("USS Saratoga", "4", "2013-05-22", "both", "both", "490"),
        ("USS Saratoga", "5", "2013-05-22", "both", "both", "528"),
        ("USS Saratoga", "6", "2013-05-23", "both", "both", "493"),
        ("USS Saratoga", "7", "2013-05-23", "both", "both", "256"),
        ("USS Saratoga", "8", "2013-08-08", "both", "both", "143"),
        ("SS Curtiss", "1", "2014-03-08", "periscope", "surface", "341"),
        ("SS Curtiss", "2", "2014-03-08", "both", "both", "367"),
        ("SS Curtiss", "3", "2014-03-08", "both", "both", "768"),
        ("SS Curtiss", "4", "2014-03-08", "both", "both", "719"),
        ("SS Curtiss", "5", "2014-03-08", "both", "both", "497"),
        ("SS Curtiss", "6", "2014-03-09", "both", "both", "587"),
        ("SS Curtiss", "7", "2014-03-10", "both", "both", "449"),
        ("SS Curtiss", "8", "2014-03-11", "both", "both", "934"),
        ("SS Curtiss", "9", "2011-02-09", "periscope", "surface", "148"),
        ("SS Curtiss", "10", "2011-02-09", "periscope", "both", "1125"),
        ("SS Curtiss", "11", "2011-02-05", "underwater", "underwater", "426"),
        ("SS Curtiss", "12", "2011-02-05", "underwater", "underwater", "1179"),
    ),
    ours=("hullrecon", "1 to 8", "simulated", "links simulated", "underwater", "15 each"),
)

OZOG = Source(
    key="Ozog2016",
    title="Advances in SLAM in confined underwater environments using sonar and optical imaging",
    chapters=(_INTRODUCTION, _SINGLE, _SESSIONS, _SONAR, _MODEL, _SHAPES, _FUTURE, _APPENDICES),
    misprints=_MISPRINTS,
    surveys=(_TRIALS,),
)
