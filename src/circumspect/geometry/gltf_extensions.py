"""Extensions of glTF: which change geometry, which do not, and which are not read."""

from __future__ import annotations

from circumspect.errors import InputError
from circumspect.geometry.gltf_document import GltfDocument

DRACO = "KHR_draco_mesh_compression"
INSTANCING = "EXT_mesh_gpu_instancing"
VISIBILITY = "KHR_node_visibility"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression", "MESHOPT_compression")

_HONOURED = {"KHR_mesh_quantization", DRACO, INSTANCING, VISIBILITY}
# They change colours, pictures, lights, cameras, animations or remarks, never a surface.
_WITHOUT_GEOMETRY = (
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_xmp", "KHR_animation_", "KHR_audio",
    "KHR_techniques_webgl", "EXT_texture_", "EXT_lights_", "EXT_materials_", "EXT_mesh_features",
    "EXT_structural_metadata", "MSFT_texture_", "MSFT_packing_", "ADOBE_materials_", "AGI_",
    "CESIUM_primitive_outline", "FB_materials_", "GOOGLE_texture_", "NV_materials_", "VRM", "MPEG_",
)  # fmt: skip
DECODE = "decode it: gltf-transform copy IN.glb OUT.glb"
"""What turns compressed geometry into plain buffers."""


def require_known_extensions(document: GltfDocument) -> None:
    """Check that every extension which the file requires is one that is honoured here.

    Raises:
        InputError: It requires another one; the message names it.
    """
    required = document.header.get("extensionsRequired", [])
    if not isinstance(required, list) or not all(isinstance(name, str) for name in required):
        raise ValueError("extensionsRequired is no list of names")
    for name in required:
        if name in MESHOPT:
            raise InputError(f"is compressed by {name}, which is not read; {DECODE}")
        if name not in _HONOURED and not name.startswith(_WITHOUT_GEOMETRY):
            raise InputError(
                f"requires the extension {name[:60]}, which is not read; export it without"
            )
