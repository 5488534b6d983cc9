# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Each finding, and each error of a run or a command, that says what to do has a test that does it
and sees that it heals.
"""

import ast
import inspect
import re
from functools import cache
from pathlib import Path

import pytest

from hullrecon.findings.finding import WORDS

TESTS = Path(__file__).parents[1]
LIBRARY, COMMANDS = TESTS.parent / "hullrecon", TESTS.parent / "cli"
# Whose errors an operator reads: of a dive package, of a run and its folder
READ_BY_OPERATORS = (
    *("dive", "navigation", "vision", "adjustment", "surface", "geometry", "rig.py"),
    *("steps", "artifacts", "api", "change", "report", "new_folder.py"),
)
# What asks a reader to do something
ADVICE = re.compile(
    r"\b(to fill in|give\b|set dvl|set \{|log (its|one|it as)|leave the|take \[|put it there"
    r"|name it in|write them|add it to|states it|are they in|in metres|says in which|off \(\{key"
    r"|gives the path|by that alone|column altitude|tray\.\w+ =|to tray\."
    r"|said\}: \{remedy|TRAY_READINGS|REMEDIES"
    r"|of this.{0,6}type are|it is \"\{other)",
    re.DOTALL,
)
# By code: the test that applies it
APPLIED = {
    "memory-tight": "api/test_costs.py::"
    "test_a_part_of_the_dive_is_advised_only_where_that_can_heal",
    "memory-over-budget": "api/test_costs.py::test_a_dive_over_its_memory_is_refused_until_it_fits",
    "dvl-without-velocity": "dive/check/test_package_check.py::"
    "test_a_dvl_without_any_velocity_is_in_the_way_of_a_run",
    "hull-unmeasured": "steps/test_navigate.py::test_path_is_reckoned_without_any_range",
    "images-not-logged": "dive/check/test_package_check.py::"
    "test_cameras_that_logged_nothing_are_in_the_way_until_left_out",
    "clocks-apart": "dive/test_ingest.py::test_clocks_apart_are_refused_and_the_remedy_heals",
    "motions-apart": "navigation/test_motion_offset.py::"
    "test_motions_over_a_minute_apart_are_told_and_the_remedy_heals",
    "stamps-in-other-unit": "dive/check/test_time_overlap.py::"
    "test_stamps_of_another_unit_are_no_offset",
    "key-open": "dive/check/test_requirements.py::test_a_key_that_is_given_is_not_asked_for",
    "calibration-open": "dive/check/test_requirements.py::"
    "test_a_camera_without_a_section_needs_a_calibration",
    "question": "dive/logs/test_dvl_beams.py::"
    "test_configured_beams_are_used_for_messages_without_beams",
    "mount-of-dvl-open": "dive/check/test_package_check.py::"
    "test_dvl_mount_and_imu_mount_that_differ_are_warned_of",
    "log-outside": "dive/test_package_files.py::"
    "test_file_outside_package_is_refused_with_key_and_option",
    "stations-off": "dive/check/test_bow.py::test_a_zero_amidships_is_no_aft_perpendicular",
    "stream-shifted": "dive/check/test_time_overlap.py::"
    "test_a_stream_that_is_shifted_is_told_with_its_seconds",
    "heading-of-rates": "dive/logs/test_heading.py::"
    "test_the_drift_that_check_tells_is_that_of_the_rates",
    "imu-upside-down": "dive/check/test_package_check.py::"
    "test_the_simulated_dive_raises_no_suspicion",
    "baseline-implausible": "dive/check/test_consistency_checks.py::"
    "test_a_baseline_in_millimetres_or_of_nothing_is_named",
    "bottom-camera-delayed": "vision/stereo/test_delay.py::test_offset_that_is_advised_heals",
    "pressure-unit-open": "navigation/test_suspects.py::"
    "test_pressure_of_a_dive_at_one_depth_asks_for_its_unit",
    "topics-not-chosen": "dive/check/test_topics.py::"
    "test_a_topic_of_a_type_that_is_read_is_told_as_what",
    "topics-of-depths": "dive/check/test_topics.py::test_types_of_depths_that_are_advised_are_read",
    "hull-on-its-side": "dive/hull/test_symmetry.py::"
    "test_a_ship_on_her_side_is_named_and_upright_again_when_turned",
    "hull-under-water": "dive/hull/test_symmetry.py::"
    "test_a_ship_under_water_is_named_and_afloat_again_when_turned_over",
    "tray-offset": "dive/test_ingest.py::"
    "test_a_tray_that_grows_down_from_another_zero_is_counted_up_from_level",
    "contradiction": "steps/test_links_without_camera.py::"
    "test_positions_in_another_unit_are_named_and_the_remedy_heals",
    "other-tray": "dive/test_ingest.py::"
    "test_a_tray_that_grows_down_from_another_zero_is_counted_up_from_level",
    "sensor-wrong": "navigation/test_suspects.py::"
    "test_convention_of_an_imu_is_named_with_the_keys_that_heal",
    **dict.fromkeys(
        ("sensors-contradict", "sensors-part"),
        "navigation/test_suspects.py::"
        "test_compass_that_turns_twice_as_far_as_the_rates_is_told_with_the_key_that_heals",
    ),
    "tray-still": "dive/test_ingest.py::test_unknown_joint_is_refused_with_all_joints_and_remedy",
    "tray-little": "navigation/test_pieces.py::test_zeros_and_radians_as_degrees_are_doubted",
    **dict.fromkeys(
        ("images-blank", "images-frozen"),
        "dive/check/test_package_check.py::"
        "test_cameras_that_logged_nothing_are_in_the_way_until_left_out",
    ),
    "ranges-unconfirmed": "dive/logs/test_dvl_beams.py::test_ranges_are_as_sure_as_their_altitude",
    "mesh-small": "dive/hull/test_hull.py::test_units_are_converted",
    "angles-in-degrees": "dive/logs/test_streams.py::test_a_sonars_rotator_may_turn_more_than_once",
    "positions-under-water": "dive/logs/test_positions.py::"
    "test_a_topics_name_or_a_key_says_that_positions_are_acoustic",
    "water-linked-offset": "dive/readers/test_water_linked.py::"
    "test_the_mounting_rotation_offset_is_told",
    "water-linked-no-offset": "dive/readers/test_water_linked.py::"
    "test_the_mounting_rotation_offset_is_told",
}


# By the function that raises the error
FOLLOWED = {
    "adjustment/cad_placement.py::_points_to_register": "adjustment/test_bundle_inputs.py::"
    "test_nothing_to_register_is_refused_and_the_remedy_heals",
    "adjustment/rounds.py::_choose": "adjustment/test_bundle_inputs.py::"
    "test_too_few_landmarks_are_refused_and_the_remedy_heals",
    "dive/check/hull_checks.py::check_length": "dive/hull/test_length.py::"
    "test_the_unit_that_gives_the_stated_length_heals",
    "dive/check/hull_checks.py::refuse_far_hull": "dive/check/test_bow.py::"
    "test_pose_that_leaves_the_ship_at_its_berth_is_refused",
    "dive/config/calibration.py::read_camera": "dive/config/test_calibration.py::"
    "test_rectified_pictures_are_not_rectified_once_more",
    "dive/config/calibration.py::_refuse_foreign": "dive/config/test_calibration.py::"
    "test_calibration_of_another_program_is_named",
    "dive/config/calibration.py::_require": "dive/config/test_calibration.py::"
    "test_a_key_that_lacks_is_asked_for_until_it_is_there",
    "dive/config/camchain.py::camera_info_of": "dive/config/test_camchain.py::"
    "test_other_models_of_a_camchain_are_refused_by_their_name",
    **dict.fromkeys(
        (
            "dive/config/calibration.py::_crop_to_region",
            "dive/config/calibration.py::_add_distortion",
            "dive/config/calibration.py::_read_numbers",
            "dive/config/calibration.py::_refuse_folded",
            "dive/config/camera_matrix.py::read_pinhole",
            "dive/config/lens_models.py::convert_rational",
            "dive/config/lens_models.py::_as_plumb_bob",
        ),
        "dive/config/test_calibration.py::test_what_is_no_pinhole_is_refused_with_its_key",
    ),
    "dive/config/yaml_files.py::read_yaml": "dive/config/test_calibration.py::"
    "test_a_missing_file_is_refused_by_name",
    "dive/config/load.py::_read_toml": "dive/config/test_load.py::"
    "test_a_folder_or_a_coding_that_is_corrected_is_read",
    **dict.fromkeys(
        (
            "dive/config/config_errors.py::_unknown_key",
            "dive/config/load.py::_check_whole",
            "dive/config/load.py::_check_topics",
            "dive/config/load.py::_check_regions",
            "dive/config/load.py::_check_units",
            "dive/config/load.py::_check_tilt",
            "dive/config/mount_units.py::refuse_lever_arm",
            "dive/config/mount_units.py::refuse_one_place",
            "dive/config/mount_units.py::refuse_radians",
        ),
        "dive/config/test_load.py::test_what_is_printed_to_do_about_dive_toml_heals",
    ),
    "dive/config/config_errors.py::explain_error": "dive/config/test_load.py::"
    "test_the_smallest_file_gives_every_section_its_defaults",
    "dive/config/mounts.py::refuse_mounts": "dive/config/test_mounts.py::"
    "test_a_place_of_which_tf_static_says_two_has_to_be_given",
    "dive/config/mounts.py::_refuse_parted_tray": "dive/config/test_mounts.py::"
    "test_camera_on_servo_beside_fixed_dvl_is_refused",
    "dive/hull/load.py::_check_extent": "dive/hull/test_hull.py::"
    "test_cad_model_in_wrong_units_is_refused_with_likely_ones",
    "dive/hull/load.py::_refuse_stray": "dive/hull/test_hull.py::"
    "test_a_body_far_from_the_ship_is_refused",
    "dive/hull/load.py::_check_step": "dive/hull/test_precision.py::"
    "test_what_the_refusal_asks_for_is_read",
    "dive/hull/mesh_files.py::load_mesh": "dive/hull/test_hull.py::"
    "test_unread_mesh_format_is_refused_with_the_formats_read",
    "dive/hull/mesh_files.py::_parse_mesh": "dive/hull/test_hull.py::"
    "test_a_file_that_is_cut_off_is_read_once_it_is_whole",
    "dive/hull/mesh_files.py::_refuse_other_kind": "dive/hull/test_hull.py::"
    "test_a_binary_stl_that_is_cut_off_is_named",
    "dive/images/logged_calibrations.py::check_constant": "dive/images/"
    "test_logged_calibrations.py::test_a_calibration_that_changes_within_the_log_is_refused",
    "dive/images/logged_calibrations.py::_build_camera": "dive/images/test_logged_calibrations.py::"
    "test_rectified_images_are_refused_with_raw_camera_info",
    "dive/images/sink.py::finish": "dive/images/test_images.py::"
    "test_images_of_which_none_is_whole_are_refused_until_they_are",
    "dive/images/sink.py::_check_size": "dive/images/test_images.py::"
    "test_images_unlike_calibration_are_refused_early_with_sizes",
    "dive/images/sink.py::_refuse_order_of_text": "dive/images/test_images.py::"
    "test_stamps_in_the_order_of_names_as_text_are_refused",
    "dive/images/sink.py::_refuse_still": "dive/check/test_package_check.py::"
    "test_a_camera_that_shows_one_picture_all_dive_is_refused_until_left_out",
    "dive/images/store.py::_bytes": "dive/images/test_images.py::"
    "test_an_image_file_that_is_gone_is_an_input_error",
    "dive/ingest/refusals.py::refuse_same_files": "dive/images/test_images.py::"
    "test_two_cameras_that_name_the_same_pictures_are_refused",
    "dive/ingest/refusals.py::_nothing_read": "dive/test_ingest.py::"
    "test_nothing_readable_is_an_input_error",
    "dive/ingest/refusals.py::_check_silence": "dive/check/test_package_check.py::"
    "test_several_dives_are_refused_until_one_is_given",
    "dive/ingest/refusals.py::check_topics": "dive/test_ingest.py::"
    "test_absent_topic_is_refused_with_a_list_of_topics",
    "dive/ingest/refusals.py::check_joints": "dive/test_ingest.py::"
    "test_unknown_joint_is_refused_with_all_joints_and_remedy",
    "dive/logs/dvl_beams.py::ask_for_beams": "dive/logs/test_dvl_beams.py::"
    "test_configured_beams_are_used_for_messages_without_beams",
    "dive/logs/formats/csv_rows.py::_find_header": "dive/formats/test_csv_rows.py::"
    "test_a_missing_column_is_named",
    "dive/logs/formats/csv_rows.py::_check_header": "dive/formats/test_csv_rows.py::"
    "test_a_column_that_is_there_twice_is_refused",
    "dive/logs/formats/csv_rows.py::_refuse_decimal_commas": "dive/readers/test_plain.py::"
    "test_decimal_commas_between_commas_are_refused_until_semicolons_part_them",
    "dive/logs/heading.py::heading_by_rates": "dive/logs/test_heading.py::"
    "test_without_rates_the_heading_stays_the_orientations",
    "dive/logs/positions.py::_refuse_other_units": "dive/logs/test_positions.py::"
    "test_places_in_another_unit_than_degrees_are_refused_until_they_are",
    "dive/logs/quaternion_forms.py::complete_quaternions": "dive/logs/test_quaternion_forms.py::"
    "test_parts_of_quaternions_without_rates_are_refused_until_whole",
    "dive/logs/read_streams.py::refuse_two": "dive/logs/test_read_streams.py::"
    "test_two_sensors_on_one_topic_are_refused",
    "dive/logs/read_streams.py::_translate": "dive/logs/test_read_streams.py::"
    "test_topic_of_wrong_type_is_refused_with_both_types",
    "dive/logs/readers/file_log.py::require_regular_file": "dive/readers/test_open.py::"
    "test_pipes_sockets_devices_are_refused_without_waiting",
    "dive/logs/readers/oculus/log.py::_first_item": "dive/readers/test_oculus.py::"
    "test_an_encrypted_log_is_refused_with_what_to_do",
    "dive/logs/readers/open.py::open_log": "dive/readers/test_open.py::"
    "test_a_path_of_windows_is_refused_with_how_to_write_it",
    "dive/logs/readers/open.py::_not_read": "dive/readers/test_open.py::"
    "test_what_is_no_log_is_an_input_error_that_lists_the_formats",
    "dive/logs/readers/plain.py::_refuse": "dive/readers/test_plain.py::"
    "test_stamps_in_other_units_are_refused_with_likely_unit",
    "dive/logs/readers/scratch.py::_no_space": "dive/readers/test_rosbag2.py::"
    "test_no_room_to_unpack_is_one_line_and_leaves_nothing",
    "dive/logs/readers/water_linked.py::_read": "dive/readers/test_water_linked.py::"
    "test_file_of_timeless_reports_is_refused_with_remedy",
    "dive/logs/sonar_geometry.py::evenly_spaced": "dive/logs/test_sonar_geometry.py::"
    "test_ranges_that_are_no_sonars_are_refused",
    "dive/logs/sonar_geometry.py::choose_directions": "dive/logs/test_sonar_geometry.py::"
    "test_angles_that_do_not_fit_the_beams_are_refused",
    "dive/logs/sonar_geometry.py::ask_for_azimuths": "dive/logs/test_sonar_geometry.py::"
    "test_beams_that_nothing_describes_are_asked_for",
    "dive/logs/streams/sonar.py::_refuse_decibels": "dive/logs/test_ping_spool.py::"
    "test_decibels_are_refused_and_amplitudes_read",
    "dive/logs/streams/dvl.py::_refuse_far": "dive/logs/test_streams.py::"
    "test_ranges_in_millimetres_are_refused",
    "dive/logs/streams/dvl.py::_refuse_coarse": "dive/logs/test_streams.py::"
    "test_velocities_rounded_to_tenths_are_refused_until_they_have_more_digits",
    "dive/logs/streams/dvl.py::_refuse_flat": "dive/logs/test_streams.py::"
    "test_velocities_without_one_axis_are_refused_until_it_is_there",
    "dive/logs/streams/dvl.py::_refuse_fast": "dive/logs/test_streams.py::"
    "test_velocities_of_another_unit_are_refused_until_it_is_given",
    "dive/logs/streams/imu.py::_no_attitude": "dive/logs/test_streams.py::"
    "test_an_imu_without_any_attitude_is_refused",
    "dive/logs/streams/imu.py::_refuse_unfilled": "dive/logs/test_streams.py::"
    "test_an_orientation_that_is_never_filled_in_is_refused",
    "dive/logs/streams/imu.py::_require_mount_of_dvl": "dive/logs/test_attitude_depth.py::"
    "test_dvl_attitude_needs_its_mount_and_is_noted",
    "dive/logs/readers/pd0.py::_without_ensembles": "dive/readers/test_pd0.py::"
    "test_hexadecimal_text_is_refused_until_it_is_binary",
    "dive/logs/streams/pressure.py::_above_water": "dive/logs/test_streams.py::"
    "test_a_pressure_of_another_unit_is_refused_with_one_that_heals",
    "dive/logs/read_streams.py::_note_unusable": "dive/logs/test_read_streams.py::"
    "test_damaged_definition_costs_only_its_own_messages",
    "dive/logs/streams/pressure.py::_refuse_unclear_numbers": "dive/logs/test_streams.py::"
    "test_hectopascals_logged_as_depths_are_asked_for",
    "dive/logs/streams/joints.py::joint_samples": "dive/logs/test_streams.py::"
    "test_joint_angles_in_degrees_are_refused_until_their_unit_is_given",
    "dive/logs/time_window.py::time_window": "dive/test_ingest.py::"
    "test_a_window_that_ends_before_it_begins_is_an_input_error",
    "dive/logs/timeline.py::put_in_order": "dive/logs/test_timeline.py::"
    "test_a_clock_that_stands_still_is_refused",
    "dive/logs/timeline.py::_refuse_coarse": "dive/logs/test_timeline.py::"
    "test_stamps_in_steps_of_seconds_are_refused_until_finer",
    "dive/logs/timeline.py::_refuse_open_step": "dive/logs/test_timeline.py::"
    "test_stamps_that_fall_back_to_before_the_log_are_refused_until_one_part_is_given",
    "dive/logs/timeline.py::_refuse_two_bases": "dive/logs/test_timeline.py::"
    "test_a_clock_that_is_set_amid_a_table_is_refused_with_the_way_to_use_the_rest",
    "dive/logs/two_sensors.py::refuse_two_sensors": "dive/logs/test_two_sensors.py::"
    "test_depths_of_two_sensors_are_refused_and_one_of_them_is_taken",
    "dive/package_files.py::_check_file": "dive/test_package_files.py::"
    "test_file_outside_package_is_refused_with_key_and_option",
    "geometry/charts/section_casting.py::_wrong_bow": "cli/test_dive.py::"
    "test_a_bow_across_the_ship_is_one_line_and_code_three",
    "navigation/dead_reckoning/dead_reckon.py::finite_attitude": "navigation/"
    "test_dead_reckoning.py::test_imu_with_single_orientation_is_refused_as_such",
    "navigation/navigate.py::choose_path": "steps/test_navigate.py::"
    "test_neither_dvl_nor_stereo_is_an_error_in_words",
    "rig.py::tray_from": "test_rig.py::test_sensors_that_were_not_carried_are_told_and_not_guessed",
    "rig.py::sonar_poses": "test_rig.py::"
    "test_sensors_that_were_not_carried_are_told_and_not_guessed",
    "surface/build.py::build_surface": "surface/test_build.py::"
    "test_returns_too_sparse_are_refused_and_the_remedy_heals",
    # a dive without its cameras
    "vision/match_images.py::join_images": "adjustment/test_bundle_inputs.py::"
    "test_too_few_landmarks_are_refused_and_the_remedy_heals",
    "vision/stereo/pose_conventions.py::_conventions": "vision/stereo/test_pose_conventions.py::"
    "test_pose_of_another_convention_is_read_as_meant",
    "vision/stereo/baseline_check.py::check_baseline": "vision/stereo/test_rig_check.py::"
    "test_baseline_of_another_length_is_named_and_corrected",
    "vision/stereo/rig_causes.py::find_shift": "vision/stereo/test_rig_check.py::"
    "test_offset_that_is_advised_heals_stamps",
    "vision/stereo/rig_causes.py::find_wrong_part": "vision/stereo/test_rig_check.py::"
    "test_pairs_that_are_wrong_for_a_part_of_the_dive_are_told_from_a_wrong_rig",
    "vision/stereo/rig_causes.py::_name_cause": "vision/stereo/test_pose_conventions.py::"
    "test_pose_of_another_convention_is_read_as_meant",
    "vision/stereo/rig_causes.py::_miswritten_calibration": "vision/stereo/test_rig_check.py::"
    "test_exchanged_calibrations_are_named_and_exchanging_them_heals",
    "vision/stereo/rig_causes.py::_fitted_cause": "vision/stereo/test_rig_check.py::"
    "test_pictures_that_stand_on_their_head_are_no_wrong_pose",
}


# Errors of commands, runs and their folders, by the function that raises them
FOLLOWED_IN_RUNS = {
    "api/change.py::write_change": "api/test_change.py::"
    "test_a_folder_with_anything_else_in_it_is_left_alone",
    "api/dive_run.py::package_of": "cli/test_run.py::"
    "test_a_runs_folder_stands_for_the_package_that_it_read",
    "api/dive_run.py::_refuse_script_without_guard": "api/test_notebook.py::"
    "test_a_script_without_a_main_guard_is_told_of_it",
    "api/dive_run.py::_refuse_full_disk": "cli/test_run.py::"
    "test_too_little_space_is_said_before_anything_is_done",
    "api/export.py::encoded": "api/test_export.py::test_an_image_that_is_gone_leaves_no_folder",
    "api/fleet/fleet.py::_lock": "api/test_fleet.py::test_a_second_fleet_gives_way_to_the_first",
    "api/fleet/packages.py::require_packages": "api/test_fleet.py::"
    "test_runs_may_lie_beside_the_packages",
    "api/fleet/packages.py::dive_names": "api/test_fleet.py::"
    "test_package_taking_a_delivered_name_changes_nothing",
    "api/package.py::init": "cli/test_dive.py::test_init_does_not_replace_a_configuration_unasked",
    "api/package.py::_require_utf8": "cli/test_dive.py::"
    "test_init_of_a_log_whose_name_is_not_utf8_is_an_input_error",
    "artifacts/chain.py::unknown_step": "artifacts/test_plan.py::"
    "test_an_unknown_step_is_refused_with_the_nearest_or_all",
    "artifacts/disk.py::storage_errors": "artifacts/test_full_disk.py::"
    "test_a_disk_that_is_full_from_any_call_on_loses_nothing",
    "artifacts/disk.py::make_folder": "artifacts/test_claim.py::"
    "test_a_place_that_takes_no_folders_is_said",
    "artifacts/executor.py::_refuse_address": "artifacts/test_cluster.py::"
    "test_a_cluster_with_tls_needs_certificates",
    **dict.fromkeys(
        (
            "artifacts/executor.py::_refuse_unreachable",
            "artifacts/executor.py::_no_scheduler",
        ),
        "artifacts/test_cluster.py::test_no_scheduler_at_the_address_is_said",
    ),
    "artifacts/executor.py::map": "artifacts/test_executor.py::"
    "test_work_that_kills_two_workers_is_a_stage_error_and_the_next_map_works",
    "artifacts/machine.py::refuse_small_address_space": "cli/test_error_reporting.py::"
    "test_a_small_address_space_is_one_line",
    "artifacts/processes.py::clean_context": "artifacts/test_processes.py::"
    "test_processes_start_once_tmpdir_may_be_written",
    "artifacts/recipe.py::external_files": "artifacts/test_recipe.py::"
    "test_impossible_file_name_in_external_is_an_input_error",
    "artifacts/recipe.py::_external_record": "artifacts/test_recipe.py::"
    "test_a_missing_file_is_an_input_error_that_names_it",
    "artifacts/recipe.py::_refuse": "artifacts/test_source_watch.py::"
    "test_the_next_run_reads_the_changed_package_as_a_whole",
    "artifacts/stage.py::resolve_settings": "artifacts/test_stage_settings.py::"
    "test_a_number_that_is_not_finite_is_refused_until_it_is",
    **dict.fromkeys(
        ("artifacts/step_call.py::_call", "artifacts/step_process.py::_ended_early"),
        "artifacts/test_step_process.py::test_work_of_a_killed_worker_is_done_again",
    ),
    "artifacts/workspace.py::removed_meanwhile": "artifacts/test_chain_runner.py::"
    "test_a_run_whose_folder_was_removed_ends_in_one_line",
    "artifacts/workspace.py::_acquire": "artifacts/test_lock.py::"
    "test_a_writer_that_waits_gets_its_turn",
    **dict.fromkeys(
        (
            "artifacts/workspace.py::_refuse_foreign",
            "artifacts/workspace.py::refuse_package",
        ),
        "artifacts/test_claim.py::test_a_folder_of_somebody_else_is_not_adopted",
    ),
    **dict.fromkeys(
        ("change/compare_surveys.py::compare_surveys", "change/offset.py::_too_little_error"),
        "change/test_compare_surveys.py::test_changing_places_of_the_dives_turns_new_into_gone",
    ),
    **dict.fromkeys(
        ("new_folder.py::_is_there", "new_folder.py::_refuse_content", "new_folder.py::new_folder"),
        "test_new_folder.py::test_a_folder_with_something_in_it_is_refused_before_any_work",
    ),
    "report/logo.py::read_logo": "report/test_about.py::"
    "test_a_logo_that_is_no_picture_is_refused_in_one_line",
    "steps/artifacts.py::missing": "steps/test_matches.py::test_links_that_are_damaged_are_named",
    "steps/change.py::read_survey": "steps/test_hull_survey.py::"
    "test_a_run_without_a_cad_model_cannot_be_compared",
    "steps/change.py::compare_runs": "steps/test_hull_survey.py::"
    "test_cad_models_of_one_hull_may_differ_by_rounding",
    "steps/change.py::_refuse_damaged": "steps/test_hull_survey.py::"
    "test_a_file_that_is_gone_is_damage_too",
    "steps/change.py::_compare": "steps/test_change.py::"
    "test_once_the_earlier_run_is_back_the_chapter_is_too",
    "steps/change.py::_earlier_dive": "steps/test_change.py::"
    "test_a_dive_is_not_compared_with_itself",
    # a dive without its cameras
    "steps/features.py::run": "dive/check/test_package_check.py::"
    "test_cameras_that_logged_nothing_are_in_the_way_until_left_out",
    "steps/finished_run.py::workspace_of": "steps/test_hull_survey.py::"
    "test_a_folder_that_is_no_run_is_refused",
    "steps/finished_run.py::finished_steps": "steps/test_hull_survey.py::"
    "test_a_run_that_did_not_come_to_its_objects_is_not_finished",
    "steps/finished_run.py::failed_delivery": "steps/test_report_step.py::"
    "test_failed_deliverable_is_warned_of_and_reported_by_run",
    "steps/matches.py::run": "steps/test_matches.py::test_links_that_are_damaged_are_named",
    "steps/navigate.py::_by_dvl": "steps/test_navigate.py::"
    "test_neither_dvl_nor_stereo_is_an_error_in_words",
    "cli/commands/clean.py::_ask": "cli/test_clean.py::"
    "test_clean_without_terminal_or_steps_removes_nothing",
    "cli/commands/package.py::_check_run": "cli/test_check.py::"
    "test_what_check_found_a_run_that_reads_data_makes_anew",
    "cli/commands/study.py::_sample": "studies/test_study_run.py::"
    "test_the_sample_dive_is_taken_where_no_dive_is_given",
    "cli/error_reporting.py::_as_known": "cli/test_error_reporting.py::"
    "test_a_small_address_space_is_one_line",
    "cli/state.py::_file_handler": "cli/test_error_reporting.py::"
    "test_a_log_file_that_cannot_be_is_one_line",
}


def raising_functions() -> set[str]:
    """The functions that raise or make an error with a remedy of their own."""
    found = set()
    for path in (*sorted(LIBRARY.rglob("*.py")), *sorted(COMMANDS.rglob("*.py"))):
        is_command = path.is_relative_to(COMMANDS)
        place = path.relative_to(COMMANDS.parent if is_command else LIBRARY)
        if not is_command and place.parts[0] not in READ_BY_OPERATORS:
            continue
        text = path.read_text()
        for function in ast.walk(ast.parse(text)) if "remedy" in text else ():
            if isinstance(function, ast.FunctionDef) and any(
                isinstance(call, ast.Call)
                and any(key.arg == "remedy" and says_what(key.value) for key in call.keywords)
                for call in ast.walk(function)
            ):
                found.add(f"{place.as_posix()}::{function.name}")
    return found


@cache
def functions_of(file: str) -> set[str]:
    tree = ast.walk(ast.parse((TESTS / file).read_text()))
    return {found.name for found in tree if isinstance(found, ast.FunctionDef)}


def says_what(remedy: ast.expr) -> bool:
    """False of none, and of that of another error, which is passed on."""
    is_passed_on = isinstance(remedy, ast.Attribute) and remedy.attr == "remedy"
    return not is_passed_on and not (isinstance(remedy, ast.Constant) and not remedy.value)


def words_of(code: str) -> str:
    words = WORDS[code]
    return words if isinstance(words, str) else inspect.getsource(words)


def test_each_finding_with_advice_has_a_test_that_follows_it():
    advising = {code for code in WORDS if ADVICE.search(words_of(code))}
    assert advising == set(APPLIED)


def test_each_error_with_advice_has_a_test_that_does_what_it_says():
    assert raising_functions() == {*FOLLOWED, *FOLLOWED_IN_RUNS}


@pytest.mark.parametrize(
    "node", sorted({*APPLIED.values(), *FOLLOWED.values(), *FOLLOWED_IN_RUNS.values()})
)
def test_the_test_that_follows_advice_exists(node):
    file, _, name = node.partition("::")
    assert name in functions_of(file)
