# SPDX-License-Identifier: Apache-2.0
"""The executables of this package: each imports its node when it is called, so it can be stopped at once."""

from lce_ros.executable import Executable

laser = Executable("lce_drivers.laser.laser_node")
thermal_camera = Executable("lce_drivers.camera.thermal_camera_node")
distance_sensor = Executable("lce_drivers.distance.distance_sensor_node")
simulator = Executable("lce_drivers.simulation.simulator_node")
