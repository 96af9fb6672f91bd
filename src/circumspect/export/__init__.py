"""Trained networks for the robot."""

from circumspect.export.onnx_export import export_onnx

__all__ = ["export_onnx"]
