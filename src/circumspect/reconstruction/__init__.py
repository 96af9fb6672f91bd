"""The object model: fused from frames, and from submaps that follow corrected keyframes."""

from circumspect.reconstruction.frame_contribution import FrameContribution
from circumspect.reconstruction.frame_surface import FrameSurface
from circumspect.reconstruction.object_model import ModelSettings, ObjectModel
from circumspect.reconstruction.occupancy import GrowingOccupancy
from circumspect.reconstruction.sight_rays import SightRays
from circumspect.reconstruction.submap import Submap, SubmapCollection
from circumspect.reconstruction.submap_fusion import SubmapFusion
from circumspect.reconstruction.view_density import ViewDensity

__all__ = [
    "FrameContribution",
    "FrameSurface",
    "GrowingOccupancy",
    "ModelSettings",
    "ObjectModel",
    "SightRays",
    "Submap",
    "SubmapCollection",
    "SubmapFusion",
    "ViewDensity",
]
