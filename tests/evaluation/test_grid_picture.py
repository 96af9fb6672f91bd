"""`circumspect grid`'s picture can be read: every colour has its key, no text lies on another."""

from __future__ import annotations

import itertools

import pytest

from circumspect.classification import GridSpec
from circumspect.evaluation.grid_picture import draw_grid
from circumspect.furniture import make_furniture


@pytest.mark.parametrize("kind", ["cylindrical", "rectangular"])
@pytest.mark.parametrize(("cells", "unit"), [(1, "m"), (32, "file units"), (200, "m")])
def test_titles_labels_and_keys_do_not_overlap(kind: str, cells: int, unit: str) -> None:
    input_spec = GridSpec(kind=kind, shape=(cells,) * 3)
    cloud = make_furniture("chair", 3).sampled(5000, 0)
    figure = draw_grid(input_spec.bounds(cloud).hits(cloud.points_xyz), unit)
    figure.canvas.draw()
    assert f"[{unit}]" in figure.axes[0].get_ylabel()
    panels = [axes for axes in figure.axes if axes.get_title()]
    keys = [axes for axes in figure.axes if not axes.get_title()]
    assert len(panels) == len(keys) == 3
    boxes = []
    for axes in figure.axes:
        texts = [axes.title, axes.xaxis.label, axes.yaxis.label]
        boxes += [text.get_window_extent() for text in texts if text.get_text()]
        if axes in keys:
            low, high = axes.get_ylim()
            ticks = [
                tick for tick in axes.get_yticklabels() if low <= tick.get_position()[1] <= high
            ]
            boxes += [tick.get_window_extent() for tick in ticks]
    width, height = figure.get_size_inches() * figure.dpi
    for box in boxes:
        assert min(box.x0, box.y0, width - box.x1, height - box.y1) >= 0, "text is cut off"
    for one, other in itertools.combinations(boxes, 2):
        across = min(one.x1, other.x1) - max(one.x0, other.x0)
        up = min(one.y1, other.y1) - max(one.y0, other.y0)
        assert across < 1 or up < 1, "texts lie on each other"
