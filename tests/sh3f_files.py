"""Furniture catalogues made by the tests."""

import io
import zipfile
from pathlib import Path

PROPERTIES = "PluginFurnitureCatalog.properties"
# A seat with a back, as the program has it: x to the right, y up, the front at +z, the back at -z.
CHAIR = """# 1 m wide, 2 m high, 1 m deep
v 0 0 0
v 1 0 0
v 1 0 1
v 0 0 1
v 0 2 0
v 1 2 0
v 9 9 9
f 1 2 3 4
f 1/1/1 2/1/1 6//1 5
"""


def piece(number=1, **changes):
    """The lines of a chair; None leaves a key out."""
    values = {
        "name": "Chair", "category": "Living room", "model": "/folder/chair.obj",
        "width": "50", "depth": "60", "height": "90", "creator": "Somebody", **changes,
    }  # fmt: skip
    return "".join(f"{k}#{number}={v}\n" for k, v in values.items() if v is not None)


def write_sh3f(
    path, properties=None, models=None, licence="CC-BY 3.0 \xa9 Somebody", name=PROPERTIES
):
    """A catalogue of given properties (one chair by default) and member names to bytes or text."""
    path = Path(path)
    text = f"id=test\nlicense={licence}\n\n" + (piece() if properties is None else properties)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, text.encode("latin-1"))
        for member, content in ({"folder/chair.obj": CHAIR} if models is None else models).items():
            archive.writestr(member, content)
    return path


def zipped(**members):
    """The bytes of a zip; dots in names are written as double underscores."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in members.items():
            archive.writestr(name.replace("__", "."), content)
    return stream.getvalue()
