"""Figure 4: from the request file beside this script, in the current folder."""

from pathlib import Path

from nlds_vines.reproduce.command import draw_figure

if __name__ == "__main__":
    draw_figure(Path(__file__).with_suffix(".toml"))
