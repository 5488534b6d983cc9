# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Definitions of message types that logs may use without carrying their text, as published."""

from __future__ import annotations

DVL = """
uint8 DVL_MODE_BOTTOM=1
uint8 DVL_MODE_WATER=2
uint8 DVL_TYPE_PISTON=0
uint8 DVL_TYPE_PHASED_ARRAY=1
std_msgs/Header header
uint8 velocity_mode
uint8 dvl_type
geometry_msgs/Vector3 velocity
float64[9] velocity_covar
float64 altitude
float64 course_gnd
float64 speed_gnd
uint8 num_good_beams
float32 sound_speed
bool beam_ranges_valid
bool beam_velocities_valid
geometry_msgs/Vector3[4] beam_unit_vec
float64[4] range
float32[4] range_covar
float32[4] beam_quality
float32[4] beam_velocity
float32[4] beam_velocity_covar
"""

PING_INFO = """
float32 frequency
float32 sound_speed
float32[] tx_beamwidths
float32[] rx_beamwidths
"""

SONAR_IMAGE_DATA = """
uint32 DTYPE_UINT8=0
uint32 DTYPE_INT8=1
uint32 DTYPE_UINT16=2
uint32 DTYPE_INT16=3
uint32 DTYPE_UINT32=4
uint32 DTYPE_INT32=5
uint32 DTYPE_UINT64=6
uint32 DTYPE_INT64=7
uint32 DTYPE_FLOAT32=8
uint32 DTYPE_FLOAT64=9
bool is_bigendian
uint32 dtype
uint32 beam_count
uint8[] data
"""

PROJECTED_SONAR_IMAGE = """
std_msgs/Header header
marine_acoustic_msgs/PingInfo ping_info
geometry_msgs/Vector3[] beam_directions
float32[] ranges
marine_acoustic_msgs/SonarImageData image
"""

DVL_BEAM = """
int64 id
float64 velocity
float64 distance
float64 rssi
float64 nsd
bool valid
"""

WATERLINKED_DVL = """
std_msgs/Header header
float64 time
geometry_msgs/Vector3 velocity
float64 fom
float64 altitude
{package}/DVLBeam[] beams
bool velocity_valid
int64 status
string form
"""

DVL_MSGS_DVL = """
std_msgs/Header header
float64 time
geometry_msgs/Vector3 velocity
float64 fom
float64[] covariance
float64 altitude
dvl_msgs/DVLBeam[] beams
bool velocity_valid
int64 status
int64 time_of_validity
int64 time_of_transmission
string form
"""

COLA2_DVL_BEAM = """
float64 range
float64 range_covariance
float64 velocity
float64 velocity_covariance
geometry_msgs/PoseStamped pose
"""

COLA2_DVL = """
std_msgs/Header header
geometry_msgs/Vector3 velocity
float64[9] velocity_covariance
float64 altitude
cola2_msgs/DVLBeam[] beams
"""

HEAD_UP_DISPLAY = """
std_msgs/Header header
float32 airspeed
float32 groundspeed
int16 heading
float32 throttle
float32 altitude
float32 climb
"""

SONAR_IMAGE = """
std_msgs/Header header
float32 frequency
float32 sound_speed
float32 azimuth_beamwidth
float32 elevation_beamwidth
float32[] azimuth_angles
float32[] elevation_angles
float32[] ranges
bool is_bigendian
uint8 data_size
uint8[] intensities
"""

GEO_POINT = """
float64 latitude
float64 longitude
float64 altitude
"""

GEO_POSE = """
geographic_msgs/GeoPoint position
geometry_msgs/Quaternion orientation
"""

BUNDLED: dict[str, str] = {
    "marine_acoustic_msgs/msg/Dvl": DVL,
    "marine_acoustic_msgs/msg/PingInfo": PING_INFO,
    "marine_acoustic_msgs/msg/SonarImageData": SONAR_IMAGE_DATA,
    "marine_acoustic_msgs/msg/ProjectedSonarImage": PROJECTED_SONAR_IMAGE,
    "waterlinked_a50_ros_driver/msg/DVLBeam": DVL_BEAM,
    "waterlinked_a50_ros_driver/msg/DVL": WATERLINKED_DVL.format(
        package="waterlinked_a50_ros_driver"
    ),
    "dvl_msgs/msg/DVLBeam": DVL_BEAM,
    "dvl_msgs/msg/DVL": DVL_MSGS_DVL,
    "cola2_msgs/msg/DVLBeam": COLA2_DVL_BEAM,
    "cola2_msgs/msg/DVL": COLA2_DVL,
    "mavros_msgs/msg/VfrHud": HEAD_UP_DISPLAY,
    "acoustic_msgs/msg/SonarImage": SONAR_IMAGE,
    "geographic_msgs/msg/GeoPoint": GEO_POINT,
    "geographic_msgs/msg/GeoPointStamped": "std_msgs/Header header\ngeographic_msgs/GeoPoint "
    "position\n",
    "geographic_msgs/msg/GeoPose": GEO_POSE,
    "geographic_msgs/msg/GeoPoseStamped": "std_msgs/Header header\ngeographic_msgs/GeoPose pose\n",
    "geographic_msgs/msg/GeoPoseWithCovariance": "geographic_msgs/GeoPose pose\nfloat64[36] "
    "covariance\n",
    "geographic_msgs/msg/GeoPoseWithCovarianceStamped": (
        "std_msgs/Header header\ngeographic_msgs/GeoPoseWithCovariance pose\n"
    ),
}
