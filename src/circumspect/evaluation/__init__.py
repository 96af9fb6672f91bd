"""How good an answer is: accuracy over yaw, confusion, calibration, and figures of them."""
