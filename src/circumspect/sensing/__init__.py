"""RGB-D frames, the cameras that make them, their noise, and the object's pixels in them."""

from circumspect.sensing.box_segmentation import BoxSegmentation
from circumspect.sensing.depth_blocks import DepthBlocks
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_check import FloorFault
from circumspect.sensing.floor_plane import FloorPlane
from circumspect.sensing.flying_pixels import continuous_pixels
from circumspect.sensing.ground_segmentation import GroundSegmentation
from circumspect.sensing.odometry import Odometry
from circumspect.sensing.pixel_rays import pixel_rays
from circumspect.sensing.rgbd_camera import RgbdCamera
from circumspect.sensing.rgbd_frame import RgbdFrame
from circumspect.sensing.segmentation import Segmentation

__all__ = [
    "BoxSegmentation",
    "DepthBlocks",
    "DepthNoise",
    "FloorFault",
    "FloorPlane",
    "GroundSegmentation",
    "Odometry",
    "RgbdCamera",
    "RgbdFrame",
    "Segmentation",
    "continuous_pixels",
    "pixel_rays",
]
