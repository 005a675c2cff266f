"""The look of a picture, as options of commands state it."""

from __future__ import annotations

from dataclasses import dataclass

from nlds_vines.errors import checked_width, choice


@dataclass(frozen=True)
class Look:
    """The page of a picture; validated when made.

    Attributes
    ----------
    columns : int or str
        1 for a picture as wide as a column of a paper, 2 for both.
    width : float, optional
        Its width [cm] in place of that of the columns.
    title : str, optional
        Its title, an empty one for none; by default that of the request.
    """

    columns: int | str = 2
    width: float | None = None
    title: str | None = None

    def __post_init__(self) -> None:
        choice("columns", str(self.columns), ("1", "2"))
        if self.width is not None:
            object.__setattr__(self, "width", checked_width(self.width))


USUAL_LOOK = Look()
