# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SLAM of two underwater vehicles with submaps [Aulinas2011 5], on simulated missions.

z points down: depth. Attitude is roll, pitch, yaw, R = Rz(yaw) Ry(pitch) Rx(roll).
"""
