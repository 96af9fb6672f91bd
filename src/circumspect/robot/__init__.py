"""The mobile robot: its interface, its kinematics, its odometry, and how it follows a path."""
