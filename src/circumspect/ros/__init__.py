"""A ROS 2 node that needs no ROS installation, and its DDS transport."""
