"""Where the camera is: the tracker and its estimator."""
