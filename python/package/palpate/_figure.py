"""A figure that shows itself in a notebook, whether pyplot is there or not."""

from __future__ import annotations

import io

from matplotlib.figure import Figure


class Drawn(Figure):
    """A matplotlib figure of one's own: to be changed, saved, shown."""

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=96)
        return picture.getvalue()
