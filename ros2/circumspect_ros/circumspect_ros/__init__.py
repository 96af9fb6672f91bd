"""The circumspect node for those who have ROS 2 installed: rclpy carries its messages."""
