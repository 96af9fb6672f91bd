"""Export of trained networks for the robot."""

from circumspect.export.onnx_export import Fidelity, export_onnx

__all__ = ["Fidelity", "export_onnx"]
