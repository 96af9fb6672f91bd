"""RGB-D frames, cameras, depth noise, odometry and segmentation."""

from circumspect.sensing.box_segmentation import BoxSegmentation
from circumspect.sensing.depth_blocks import DepthBlocks
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_plane import FloorPlane, FloorProblem
from circumspect.sensing.ground_segmentation import GroundSegmentation
from circumspect.sensing.odometry import Odometry
from circumspect.sensing.pixel_rays import pixel_rays
from circumspect.sensing.rgbd_frame import RgbdCamera, RgbdFrame
from circumspect.sensing.segmentation import Segmentation, continuous_pixels

__all__ = [
    "BoxSegmentation",
    "DepthBlocks",
    "DepthNoise",
    "FloorPlane",
    "FloorProblem",
    "GroundSegmentation",
    "Odometry",
    "RgbdCamera",
    "RgbdFrame",
    "Segmentation",
    "continuous_pixels",
    "pixel_rays",
]
