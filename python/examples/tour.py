# A tour of the package, cell by cell: editors that know `# %%` run them one by one, as a notebook.
#
#     python tour.py walk.throng
# %% A bundle: tables of motion, as arrays that share its memory
import sys

import numpy as np

import throng

bundle = throng.Bundle(sys.argv[1] if len(sys.argv) > 1 else "walk.throng")
segments = bundle.section("SEGM")
print(bundle)
print(f"{len(segments)} segments of {segments['num_frames'].mean() / bundle.rate_hz:.2f} s on average")

# %% What the policy does in one state, with the target all around (X left, Y up, Z ahead; m)
angles = np.linspace(-np.pi, np.pi, 9)
targets = 3.0 * np.stack([np.sin(angles), np.zeros(9), np.cos(angles)], axis=1)
answer = bundle.query(np.zeros(9, int), targets)
for angle, segment in zip(angles, answer["segment"]):
    x, _, z = segments["displacement"][segment]
    print(f"target at {np.degrees(angle):6.1f} deg: segment {segment}, which leads {x:.2f} m and {z:.2f} m away")

# %% Two hundred people on a square. The scene is text here; a file does as well
SCENE = """
seconds = 10.0

[[groups]]
motion = "none"
count = 200
place = { block = { from = [-20.0, -20.0], to = [20.0, 20.0], jitter = 0.3 } }
goal = { wander = { from = [-22.0, -22.0], to = [22.0, 22.0] } }
"""
sim = throng.Simulation("square.toml", text=SCENE)
start = sim.roots
saved = sim.snapshot()
while sim.time_s < 5.0:
    sim.step(1 / 60, parallel=True)
print(f"after {sim.time_s:.1f} s they are {np.linalg.norm(sim.roots - start, axis=1).mean():.1f} m away on average")

# %% Back to the start, and the same again
seen = sim.hash()
sim.restore(saved)
while sim.time_s < 5.0:
    sim.step(1 / 60)
assert sim.hash() == seen

# %% Characters with bodies: each is sent to a target of its own
places = np.zeros((100, 3), np.float32)
places[:, 0] = np.arange(100) % 10
places[:, 1] = np.arange(100) // 10
people = throng.Characters(bundle, places)
people.aim(np.tile(np.float32([20.0, 0.0, 20.0]), (100, 1)))
for _ in range(120):
    people.step()
head = bundle.joints.index("head")
print(f"heads are {people.poses[:, head, 1, 3].mean():.2f} m above the ground")

# %% Learning: the baked policy is what to beat
try:
    from throng.gym import WalkToTargets
except ImportError as missing:
    sys.exit(f"the last cell needs gymnasium ({missing})")
env = WalkToTargets(bundle, num_envs=16)
observed, _ = env.reset(seed=1)
total = sum(env.step(env.baseline())[1] for _ in range(60))
print(f"in 30 s the policy earns {total.mean():.2f} on average")
