"""Compares steps of this package with the same steps in Rust, in turns.

    cargo build --release -p throng-runtime --features rayon --example step_rate
    python step_ratio.py BUNDLE SPACE [ROUNDS]

A thousand people with bodies of the blend space SPACE cross a square, on one thread.
"""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import throng

STEPS = 300
PROGRAM = Path(__file__).resolve().parents[2] / "target/release/examples/step_rate"
SCENE = """
seconds = 60.0
bundle = "{}"

[[groups]]
motion = "blend"
count = 1000
spaces = ["{}"]
place = {{ block = {{ from = [-60.0, -60.0], to = [60.0, 60.0], jitter = 0.3 }} }}
goal = {{ shift = {{ by = [28.0, 0.0] }} }}
"""


def rust(scene):
    ran = subprocess.run([PROGRAM, scene, str(STEPS)], check=True, capture_output=True, text=True)
    seconds, state = ran.stdout.split()
    return float(seconds), int(state)


def python(scene, look=lambda sim: None):
    sim = throng.Simulation(scene)
    begin = time.perf_counter()
    for _ in range(STEPS):
        sim.step(1 / 60)
        look(sim)
    seconds = (time.perf_counter() - begin) / STEPS
    return seconds, int(np.bitwise_xor.reduce(sim.roots.view(np.uint32), axis=None))


def main(bundle, space, rounds=7):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(SCENE.format(Path(bundle).resolve().as_posix(), space))
        poses = np.empty((1000, 22, 3, 4), np.float32)
        ways = {
            "Rust": rust,
            "Python": python,
            "Python, with roots": lambda s: python(s, lambda sim: sim.roots),
            "Python, with poses": lambda s: python(s, lambda sim: sim.poses),
            "Python, with poses into `out`": lambda s: python(s, lambda sim: sim.get_poses(out=poses)),
        }
        times = {name: [] for name in ways}
        states = set()
        for _ in range(int(rounds)):
            for name, way in ways.items():
                seconds, state = way(scene)
                times[name].append(seconds)
                states.add(state)
    assert len(states) == 1, "everybody ends at the same place, bit by bit"
    for name, all_times in times.items():
        ratio = statistics.median(t / r for t, r in zip(all_times, times["Rust"]))
        print(f"{name:30} {1e3 * statistics.median(all_times):7.3f} ms a step, {ratio:.3f} of Rust's")


if __name__ == "__main__":
    main(*sys.argv[1:])
