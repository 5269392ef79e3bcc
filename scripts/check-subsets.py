#!/usr/bin/env python3
"""Draws subsets of folders of motion, builds each, and prints who reaches targets and stands there.

    scripts/check-subsets.py --motion FOLDER [--throng PROGRAM] [--draws N] [--only NAME] [--seed S]

Draws by performer, by manner, of walks and idles alone, of cycles alone, of runs alone, and at random. A draw is met if
95 % reach their targets, alone and with others, and 90 % of those who arrive stand. `starts` are captured ones."""
import argparse, json, os, random, re, shutil, subprocess, sys, tempfile
from pathlib import Path

args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
args.add_argument("--motion", required=True, type=Path, help="folder of motion capture")
args.add_argument("--throng", default="target/debug/throng")
args.add_argument("--draws", type=int, default=24)
args.add_argument("--seed", type=int, default=1)
args.add_argument("--only", default="", help="draws whose name holds this")
args.add_argument("--keep", type=Path, help="folder for the bundles")
args = args.parse_args()

motion = sorted(p for p in args.motion.rglob("*") if p.suffix in (".bvh", ".amc", ".fbx", ".glb"))
rng = random.Random(args.seed)


def named(pattern):
    return [p for p in motion if re.search(pattern, str(p.relative_to(args.motion)))]


def draw(pattern, count, also=None, also_count=0):
    found, more = named(pattern), named(also) if also else []
    return rng.sample(found, min(count, len(found))) + rng.sample(more, min(also_count, len(more)))


walks, idles = r"bandai.*_walk_", r"bandai.*_(bow|bye|byebye|guide|call|respond)_"
fixed = [
    ("walks alone", lambda: draw(walks, 30)),
    ("walks and gestures", lambda: draw(walks, 20, idles, 10)),
    ("walks of all directions", lambda: draw(r"bandai.*_walk(-back|-left|-right)?_", 40)),
    ("old, tired, sad", lambda: named(r"bandai.*_(old|tired|sad)_")),
    ("active, happy, childish", lambda: named(r"bandai.*_(active|happy|childish)_")),
    ("proud and masculine", lambda: named(r"bandai.*_(walk|bow|guide|bye)_(proud|masculinity|giant)_")),
    ("runs alone", lambda: named(r"bandai.*_(run|dash)_")),
    ("runs and gestures", lambda: draw(r"bandai.*_(run|dash)_", 20, idles, 10)),
    ("straight walks of one", lambda: named(r"snu/single/walk_straight")),
    ("walks of one", lambda: named(r"snu/single/walk_(straight|left|right|clock|counter)")),
    ("runs of one", lambda: named(r"snu/single/run_")),
    ("things to do of one", lambda: draw(r"snu/single/", 30)),
    ("walks of three performers", lambda: draw(walks, 8, r"snu/single/walk_(straight|left|right)", 8) + named(r"02_0[12]\.")),
]
sizes = [20, 30, 45, 60]
cases = fixed + [(f"random {k + 1}", lambda k=k: draw(r"bandai|snu/single|02/02_0[1-3]", sizes[k % 4])) for k in range(args.draws - len(fixed))]


def run(*what):
    done = subprocess.run([args.throng, *map(str, what)], capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode == 0 else done.stderr.strip().replace("\n", " ")[-110:]


met, most = 0, 0.0
print(f"{'draw':26}{'clips':>6}{'walk s':>8}{'alone':>7}{'others':>8}{'stand':>7}{'starts':>7}{'made':>6}{'of it':>7}{'slip x':>7}{'knee x':>7}{'s':>6}")
num = 0
for name, of in cases:
    files = of()
    num += 1
    if args.only and not re.search(args.only, name):
        continue
    with tempfile.TemporaryDirectory() as folder:
        # Skeletons lie beside the motion of ASF/AMC.
        for file in files + [s for f in {f.parent for f in files if f.suffix == ".amc"} for s in f.glob("*.asf")]:
            to = Path(folder) / file.relative_to(args.motion)
            to.parent.mkdir(parents=True, exist_ok=True)
            os.symlink(file.resolve(), to)
        bundle = Path(folder) / "set.throng"
        built = run("build", folder, "--out", bundle, "--no-cache", "--json")
        if isinstance(built, str):
            print(f"{name:26}{len(files):6}  {built}", flush=True)
            continue
        crowd = run("run", bundle, "--characters", 200, "--json", "--no-cache")
        if args.keep:
            args.keep.mkdir(exist_ok=True)
            shutil.copy(bundle, args.keep / (re.sub(r"\W+", "-", name) + ".throng"))
    trial, verdict, made = built.get("trial"), built.get("verdict"), built.get("made") or {}
    if not trial:
        why = "; ".join(n["part"] + ": " + n["why"] for n in built["not_made"])
        print(f"{name:26}{len(files):6}  no policy: {why[:110]}", flush=True)
        continue
    if isinstance(crowd, str):
        print(f"{name:26}{len(files):6}  {crowd}", flush=True)
        continue
    crowd = crowd.get("trial", crowd)
    alone, others = trial["reached_fraction"], crowd["reached_fraction"]
    stand = crowd["standing_fraction"] * crowd["stayed_fraction"] / max(others, 1e-6)
    ok = alone >= 0.95 and others >= 0.95 and stand >= 0.9
    met += ok
    figures = crowd.get("made") or {}
    if made.get("captured_starts"):
        most = max(most, figures.get("share_of_moving", 0.0))
    walking = verdict["motion"]["walking_s"] + verdict["walking_unused_s"]
    print(f"{name:26}{len(files):6}{walking:8.0f}{alone:7.1%}{others:8.1%}{stand:7.1%}{made.get('captured_starts', 0):7}{made.get('clips', 0):6}"
          f"{figures.get('share_of_moving', 0.0):7.0%}{figures.get('slip_p95_ratio', 0.0):7.2f}{figures.get('knee_rate_p999_ratio', 0.0):7.2f}"
          f"{built['seconds_total']:6.0f}{'' if ok else '  missed'}", flush=True)
print(f"{met} of {num} draws met; made motion is at most {most:.0%} of the moving time where clips start and stop")
