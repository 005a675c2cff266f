"""Figure 3: the recipe beside this script in, archives and picture out, in the current folder."""

from pathlib import Path

from nlds_vines.reproduce.command import draw_recipe

if __name__ == "__main__":
    draw_recipe(Path(__file__).with_suffix(".toml"))
