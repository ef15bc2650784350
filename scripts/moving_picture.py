"""Writes the moving picture of README: `python scripts/moving_picture.py docs/images/dome.gif docs/images/dome.png`.

A hand glides over a ball of set-up 1 and lifts twice a turn; what is drawn is what the run recorded: where the tip was,
the force that was measured on it and the force that was rendered to the hand. The second file is one picture of it.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrow

import mmt_drake as mmt
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

RADIUS = 0.06  # of the ball [m]
SHOWN = (16.0, 20.0)  # [s]: one turn, so that the end leads to the beginning
TURN = 4.0  # to and fro [s]
FPS = 15
STILL = 18.6  # [s]
DENT = 0.16  # half width at which it is drawn [rad]; its depth is the recorded one
MM, MM_PER_N = 1e3, 6.0
MEASURED, RENDERED, BALL, INK = "#1f77b4", "#e8710a", "#dfe5ec", "#2b2f36"


def main(moving: Path, still: Path) -> None:
    """Run, and draw."""
    scenario = mmt.load_scenario("setup1-free-running", [f"environment.surface=!Sphere {{radius: {RADIUS}}}"])
    recording = mmt.run(scenario, operator=hand())
    mpl.rcParams |= {"font.size": 11, "axes.edgecolor": INK, "text.color": INK, "axes.labelcolor": INK}
    figure, (scene, chart) = plt.subplots(
        1, 2, figsize=(8.6, 3.5), dpi=100, width_ratios=(1.15, 1.0), layout="constrained", facecolor="white"
    )
    draw = prepared(recording, scene, chart)
    times = np.arange(*SHOWN, 1.0 / FPS)
    FuncAnimation(figure, draw, frames=times).save(moving, writer=PillowWriter(fps=FPS))
    smaller(moving, FPS)
    draw(STILL)
    figure.savefig(still)


def hand() -> Recording:
    """A motion over a level surface, which set-up 1 lays over the ball: sideways to and fro, lifted near the ends."""
    time = np.arange(0.0, SHOWN[1], 1e-3)
    phase = 2.0 * np.pi * time / TURN
    lifted = np.clip(3.0 * np.abs(np.cos(phase)) - 2.1, 0.0, 1.0)
    columns = {
        "position_x": 0.034 * np.cos(phase),
        "position_y": 0.002 * np.sin(0.7 * phase),
        "position_z": -0.006 - 0.002 * np.sin(5.0 * phase) + 0.016 * lifted**2 * (3.0 - 2.0 * lifted),
    }
    return Recording(time, columns, "hand")


def prepared(recording: Recording, scene: Axes, chart: Axes) -> Callable[[float], list[Artist]]:
    """Draw what stands still; returns what draws the rest at a time [s]."""
    time, tip = recording.time, recording.vector("position") * MM
    forces = {"measured": recording.vector("force"), "rendered": recording.vector("rendered_force")}
    colours = {"measured": MEASURED, "rendered": RENDERED}
    scene.add_patch(Circle((0.0, -RADIUS * MM), RADIUS * MM, fill=False, edgecolor=INK, lw=0.6, ls=(0, (4, 4))))
    (body,) = scene.fill([0.0], [0.0], facecolor=BALL, edgecolor=INK, lw=1.2)
    scene.set(xlim=(-66, 66), ylim=(-44, 62), aspect="equal")
    scene.axis("off")
    scene.set_title("a hand glides over a ball", loc="left", fontsize=11)
    arrows: list[FancyArrow] = []
    (stylus,) = scene.plot([], [], color=INK, lw=5, solid_capstyle="round", zorder=3)
    (trail,) = scene.plot([], [], color=INK, lw=0.8, alpha=0.4, zorder=2)
    (ball,) = scene.plot([], [], "o", color="white", mec=INK, mew=1.6, ms=8, zorder=5)
    size = {name: np.linalg.norm(force, axis=1) for name, force in forces.items()}
    shown = (time >= SHOWN[0]) & (time <= SHOWN[1])
    for name, width in (("measured", 3.2), ("rendered", 1.4)):
        chart.plot(time[shown], size[name][shown], color=colours[name], lw=width, alpha=0.25)
    lines = {
        name: chart.plot([], [], color=colours[name], lw=width, label=f"{name} force")[0]
        for name, width in (("measured", 3.2), ("rendered", 1.4))
    }
    now = chart.axvline(SHOWN[0], ymax=0.86, color=INK, lw=0.8)
    chart.set(
        xlim=SHOWN, ylim=(0.0, 1.28 * size["measured"][shown].max()), xlabel="time [s]", ylabel="size of the force [N]"
    )
    chart.spines[["top", "right"]].set_visible(False)
    chart.legend(loc="upper left", ncols=2, frameon=False)

    def draw(at: float) -> list[Artist]:
        i = int(np.searchsorted(time, at))
        x, z = tip[i, 0], tip[i, 2]
        body.set_xy(outline(x, z))
        stylus.set_data([x, x + 9.0], [z, z + 34.0])
        ball.set_data([x], [z])
        last = slice(max(i - 600, 0), i)
        trail.set_data(tip[last, 0], tip[last, 2])
        for arrow in arrows:
            arrow.remove()
        arrows.clear()
        for name, width in (("measured", 3.4), ("rendered", 1.4)):
            fx, fz = MM_PER_N * forces[name][i, [0, 2]]
            if np.hypot(fx, fz) > 1.0:
                arrow = scene.arrow(
                    x, z, fx, fz, width=width, head_width=3.0 * width, head_length=2.4 * width,
                    length_includes_head=True, color=colours[name], lw=0, zorder=4,
                )  # fmt: skip
                arrows.append(arrow)
            done = (time >= SHOWN[0]) & (time <= at)
            lines[name].set_data(time[done], size[name][done])
        now.set_xdata([at, at])
        return [body, stylus, ball, trail, now, *arrows, *lines.values()]

    return draw


def outline(x: float, z: float) -> Array:
    """(n, 2) of the ball, pressed in by a tip at x, z [mm]."""
    radius, angles = RADIUS * MM, np.linspace(-np.pi, np.pi, 721)
    depth = max(radius - np.hypot(x, z + radius), 0.0)
    r = radius - depth * np.exp(-0.5 * ((angles - np.arctan2(x, z + radius)) / DENT) ** 2)
    return np.column_stack([r * np.sin(angles), r * np.cos(angles) - radius])


def smaller(moving: Path, fps: int) -> None:
    """Write it again with one palette for all frames."""
    from PIL import Image, ImageSequence

    with Image.open(moving) as read:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(read)]
    palette = frames[len(frames) // 3].quantize(48, dither=Image.Dither.NONE)
    made = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    made[0].save(moving, save_all=True, append_images=made[1:], duration=1000 // fps, loop=0, optimize=True, disposal=1)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
