"""A ROS 2 node that needs no ROS installation: its logic, and the wire it speaks over."""
