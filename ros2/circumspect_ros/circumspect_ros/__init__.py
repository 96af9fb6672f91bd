"""The circumspect node for ROS 2 installations, on rclpy."""
