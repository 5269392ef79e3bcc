"""The package against the promises of its documentation."""

import inspect
import logging
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import throng

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = sorted((ROOT / "data/golden").glob("*.throng"), key=lambda p: int(p.stem.split("_v")[1]))[-1]
SQUARE = ROOT / "data/scenes/square.toml"
# Two minutes of walks that are made up, which blend.
WALKS = """
name = "walks"
synth = { set = "locomotion", minutes = 2.0 }
behaviours = []
[resample]
rate_hz = 60.0
mirror = false
[annotate.ends]
still = false
[graph]
enabled = false
[blend.ahead]
axes = [{ kind = "speed" }, { kind = "gyration" }]
examples = [{ clip = "walk_neutral_*" }]
"""
CROWD = """
[[groups]]
motion = "blend"
count = 3
spaces = ["ahead"]
place = { block = { from = [-4.0, -3.0], to = [4.0, 3.0] } }
goal = { shift = { by = [8.0, 0.0] } }
"""


@pytest.fixture(scope="session")
def bundle():
    return throng.Bundle(GOLDEN)


def test_sections_are_read_only_views_that_outlive_the_bundle():
    bundle = throng.Bundle(GOLDEN)
    for tag, (rows, size) in bundle.sections().items():
        assert bundle.section(tag).nbytes == rows * size
    segments = bundle.section("SEGM")
    assert np.shares_memory(segments, bundle.section("SEGM"))
    assert not segments.flags.writeable
    with pytest.raises(ValueError):
        segments["end"] = 0
    with pytest.raises(ValueError):
        bundle.section("ASEG").setflags(write=True)
    ends, states = segments["end"], bundle.num_states
    del bundle, segments
    assert ends.max() < states


def test_a_query_gives_segments_of_the_states(bundle):
    out = bundle.query([0, 1], [[0, 0, 4], [3, 0, 0]])
    offsets, segments = bundle.section("AOFF"), bundle.section("ASEG")
    for state in (0, 1):
        assert out["segment"][state] == segments[offsets[state] + out["best"][state]]
    assert (np.diff(out["scores"], axis=1) <= 0).all()


def test_wrong_input_is_told_clearly(bundle, tmp_path):
    with pytest.raises(throng.FileError, match="nowhere.throng") as told:
        throng.Bundle("nowhere.throng")
    assert isinstance(told.value, OSError) and isinstance(told.value, throng.Error)
    bad = tmp_path / "bad.throng"
    bad.write_bytes(b"no bundle" * 20)
    with pytest.raises(ValueError, match="bad.throng.*not a Throng"):
        throng.Bundle(bad)
    with pytest.raises(throng.InputError, match="there is no section"):
        bundle.section("NONE")
    with pytest.raises(throng.InputError, match="state"):
        bundle.query([10**6], [[0, 0, 1]])
    with pytest.raises(throng.InputError, match="0 to 4294967295"):
        bundle.query([2**32], [[0, 0, 1]])
    with pytest.raises(throng.InputError, match="behaviour"):
        bundle.query([0], [[0, 0, 1]], "fly")
    with pytest.raises(throng.InputError, match="dt_s"):
        throng.Simulation(SQUARE).step(-1.0)


def test_starts_and_targets_are_lists_and_arrays_of_any_numbers(bundle):
    starts, targets = [[0, 0, 0], [4, 0, 1.5]], [[2, 0, 2], [6, 0, -3]]
    kinds = [
        lambda rows: rows,
        lambda rows: np.array(rows, np.float32),
        lambda rows: np.array(rows, np.float64),
        lambda rows: np.asfortranarray(np.array(rows, np.float32)),
    ]
    hashes = set()
    for made in kinds:
        characters = throng.Characters(bundle, made(starts))
        characters.aim(made(targets))
        for _ in range(5):
            characters.step()
        hashes.add(characters.hash())
    assert len(hashes) == 1
    for wrong in ("here", [0, 0, 0], [["a", 0, 0]], [[0, 0], [0]]):
        with pytest.raises(throng.InputError, match="roots"):
            throng.Characters(bundle, wrong)
        with pytest.raises(throng.InputError, match="targets"):
            characters.aim(wrong)


def test_roots_of_a_moment_stay_as_they_were():
    sim = throng.Simulation(SQUARE)
    first = sim.roots
    kept = first.copy()
    assert first is sim.roots and not first.flags.writeable and first.shape == (200, 3)
    for _ in range(30):
        sim.step()
    assert (first == kept).all() and (sim.roots != kept).any()
    out = np.empty((200, 3), np.float32)
    assert sim.get_roots(out=out) is out
    np.testing.assert_array_equal(out, sim.roots)
    with pytest.raises(throng.InputError, match="shape"):
        sim.get_roots(out=np.empty((199, 3), np.float32))
    with pytest.raises(throng.InputError, match="C order"):
        sim.get_roots(out=np.empty((200, 3), np.float32, order="F"))
    with pytest.raises(throng.InputError, match="C order"):
        sim.get_poses(out=np.empty((200, 22, 3, 4), np.float32, order="F"))
    assert sim.poses.shape == (200, 22, 3, 4) and np.isnan(sim.poses).all()


def test_people_of_a_scene_take_orders():
    sim = throng.Simulation(SQUARE)
    for _ in range(30):
        sim.step()
    goal = sim.roots[0, :2] + [4.0, 0.0]
    sim.go(0, (goal[0], 0.0, goal[1]), speed=1.5, facing=1.0)
    sim.stop(1)
    sim.follow(2, 0, keeping=2.0)
    sim.steer(3, (0.0, 1.0))
    for _ in range(300):
        sim.step()
    assert np.linalg.norm(sim.roots[0, :2] - goal) < 1.0
    assert "agent 0 of" in sim.explain(0)
    for wrong, why in [
        (lambda: sim.go(0, (float("nan"), 0.0, 0.0)), "finite"),
        (lambda: sim.follow(4, 4), "somebody else"),
        (lambda: sim.stop(900), "900"),
        (lambda: sim.set_value(0, "pluck", 1.0), "pluck"),
        (lambda: sim.raise_event("gong", who=1), "gong"),
    ]:
        with pytest.raises(throng.InputError, match=why):
            wrong()


def test_a_pickled_snapshot_has_the_same_future_on_any_threads():
    sim, other = throng.Simulation(SQUARE), throng.Simulation(SQUARE)
    for _ in range(30):
        sim.step()
    saved = pickle.loads(pickle.dumps(sim.snapshot()))
    other.restore(saved)
    for _ in range(30):
        sim.step()
        other.step(parallel=True)
    assert sim.hash() == other.hash()
    np.testing.assert_array_equal(sim.roots, other.roots)
    with pytest.raises(throng.InputError, match="snapshot"):
        sim.restore(saved[:-1])


def test_other_threads_run_while_it_steps():
    sim, ticks, going = throng.Simulation(SQUARE), [0], threading.Event()

    def count():
        while not going.is_set():
            ticks[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    seen = []
    try:
        for _ in range(10):
            before = ticks[0]
            sim.step_to(sim.time_s + 1.0)
            seen.append(ticks[0] - before)
    finally:
        going.set()
        thread.join()
    assert max(seen) > 0


def test_characters_pose(bundle):
    people = throng.Characters(bundle, np.zeros((3, 3), np.float32))
    people.aim(np.array([[0, 0, 5]] * 3, np.float32))
    for _ in range(60):
        people.step()
    assert np.isfinite(people.poses).all() and np.isfinite(people.roots).all()
    assert np.abs(people.poses).max() > 0
    people.stop(0)
    people.turn_to(1, 3.0)
    for _ in range(240):
        people.step()
    stands = people.roots[0].copy()
    people.step()
    assert np.abs(people.roots[0] - stands)[:2].max() < 0.01
    with pytest.raises(throng.InputError, match="3"):
        people.stop(3)
    with pytest.raises(throng.InputError, match='no manner "merry"; there is none'):
        people.set_manner(0, "merry")


def test_characters_wave_walk_and_report_their_steps(bundle):
    people, plain = (throng.Characters(bundle, np.array([[3 * k, 0, 0] for k in range(3)], np.float32)) for _ in range(2))
    steps = []
    for k in range(240):
        people.set_layers(0, arms=[None, "wave"], look_at=(3.0, 1.5, 4.0))
        people.set_layers(1, arms=["phone", {"point": np.array([3.0, 1.5, 9.0])}], lean=[0.2, 0.0])
        for group in (people, plain):
            group.aim(np.array([[3 * c, 0, 8] for c in range(3)], np.float32))
            group.step()
        steps += [event for event in people.events if event["kind"] == "footstep"]
        # Hips, legs and feet, and all of whoever does nothing beside walking, are the same.
        np.testing.assert_array_equal(people.poses[:, [0, *range(14, 22)]], plain.poses[:, [0, *range(14, 22)]])
        np.testing.assert_array_equal(people.poses[2], plain.poses[2])
    assert people.poses[0, 13, 1, 3] > plain.poses[0, 13, 1, 3] + 0.3, "its hand is up"
    for group in (people, plain):
        group.stop(0)
        group.turn_to(1, 0.5)
        for _ in range(90):
            group.step()
    assert people.poses[0, 13, 1, 3] > plain.poses[0, 13, 1, 3] + 0.3, "its hand stays up"
    assert np.abs(people.poses[1, 6:14, :, 3] - plain.poses[1, 6:14, :, 3]).max() > 0.2, "it telephones on"
    assert {event["who"] for event in steps} == {0, 1, 2} and {event["number"] for event in steps} == {16, 20}
    with pytest.raises(throng.InputError, match="dance"):
        people.set_layers(0, arms=["dance", None])
    with pytest.raises(throng.InputError, match="frame"):
        people.set_layers(0, clip={"first_frame": 0, "num_frames": 1 << 30, "joints": 2, "loops": True})


def test_characters_go_back_to_a_snapshot(bundle):
    people, others = (throng.Characters(bundle, np.zeros((3, 3), np.float32)) for _ in range(2))
    people.aim(np.array([[0, 0, 5], [5, 0, 0], [3, 0, 3]], np.float32))
    for _ in range(30):
        people.step()
    others.restore(pickle.loads(pickle.dumps(people.snapshot())))
    for _ in range(30):
        people.step()
        others.step()
    assert people.hash() == others.hash()
    np.testing.assert_array_equal(people.poses, others.poses)
    with pytest.raises(throng.InputError, match="snapshot"):
        throng.Characters(bundle, np.zeros((2, 3), np.float32)).restore(people.snapshot()[:-1])


def test_characters_make_way(bundle):
    # They walk towards each other.
    starts = np.array([[-4, 0, np.pi / 2], [4, 0, -np.pi / 2]], np.float32)
    targets = np.array([[8, 0, 0], [-8, 0, 0]], np.float32)

    def nearest(avoids):
        people = throng.Characters(bundle, starts, "approach", avoids=avoids)
        people.aim(targets)
        least = np.inf
        for _ in range(600):
            people.step()
            a, b = people.roots[:, :2]
            least = min(least, float(np.hypot(*(a - b))))
        return least

    apart, through = nearest(True), nearest(False)
    assert apart > 0.3 and apart > through + 0.1, (apart, through)
    with pytest.raises(throng.InputError):
        throng.Characters(bundle, np.zeros((2, 3), np.float32), avoids=True)


def test_records_are_where_people_are_and_change_no_motion(bundle):
    roots = np.array([[3 * k, 0, 0.1 * k] for k in range(9)], np.float32)
    posed, far = (throng.Characters(bundle, roots, avoids=True, instances=True) for _ in range(2))
    plain = throng.Characters(bundle, roots, avoids=True)
    far.set_detail((0.0, 0.0), full_m=-1, posed_m=-1)
    for people in (posed, far, plain):
        people.aim(np.array([[10, 0, 20]] * 9, np.float32))
    for _ in range(120):
        for people in (posed, far, plain):
            people.step()
    assert len(plain.instances) == 0 and posed.hash() == plain.hash()
    records = posed.instances
    np.testing.assert_array_equal(records, far.instances)
    np.testing.assert_array_equal(np.stack([records["x"], records["z"], records["heading"]], 1), posed.roots)
    assert records["row_a"].max() < bundle.sections()["FRAM"][0] and sorted(records["variant"]) == list(range(9))
    assert (far.poses == 0).all() and not (posed.poses == 0).all()
    with pytest.raises(throng.InputError, match="posed_m"):
        far.set_detail((0.0, 0.0), full_m=5, posed_m=4)


def test_instances_and_a_character_of_ones_own_are_exported(bundle, tmp_path):
    (file,) = throng.export(GOLDEN, tmp_path / "i.npz", "instances", characters=range(3), to_s=2)
    with np.load(file) as arrays:
        assert arrays["clip"].shape[0] == 3 and arrays["place"].shape == (*arrays["clip"].shape, 3)
    # A figure that this package writes is a character, too.
    (figure,) = throng.export(GOLDEN, tmp_path / "figure.glb", characters=[0], to_s=0.5)
    (worn,) = throng.export(GOLDEN, tmp_path / "worn.glb", characters=[0, 1], to_s=1, onto=figure)
    assert worn.read_bytes()[:4] == b"glTF"
    with pytest.raises(throng.InputError, match="glb"):
        throng.export(GOLDEN, tmp_path / "worn.usda", onto=figure)
    with pytest.raises(throng.Error):
        throng.export(GOLDEN, tmp_path / "worn.glb", onto=GOLDEN)


def test_everything_public_says_what_it_is():
    for name in throng.__all__:
        thing = getattr(throng, name)
        assert inspect.getdoc(thing), name
        for part, value in inspect.getmembers(thing) if inspect.isclass(thing) else []:
            own = any(part in c.__dict__ for c in thing.__mro__ if c.__module__.startswith("throng"))
            assert part.startswith("_") or not own or inspect.getdoc(value), f"{name}.{part}"


def test_a_missing_bundle_of_a_scene_is_built(tmp_path, caplog):
    (tmp_path / "walk.toml").write_text(WALKS)
    scene = tmp_path / "scene.toml"
    scene.write_text('bundle = "walk.throng"\nconfig = "walk.toml"\nseconds = 0.5\n' + CROWD)
    with pytest.raises(throng.InputError, match="no such bundle"):
        throng.Simulation(scene, untrusted=True)
    assert not (tmp_path / "walk.throng").exists()
    with pytest.raises(throng.InputError, match="outside of the folder"):
        throng.Simulation(scene, text='bundle = "../walk.throng"\n' + CROWD, untrusted=True)
    with caplog.at_level(logging.INFO, "throng"):
        sim = throng.Simulation(scene, cache=tmp_path / "cache")
    assert "walk.throng is not there" in caplog.text
    sim.step()
    poses = sim.poses
    assert poses.shape == (3, 22, 3, 4) and np.isfinite(poses).all()
    kept = poses.copy()
    for _ in range(30):
        sim.step()
    assert (poses == kept).all() and (sim.poses != kept).any()
    with pytest.raises(ValueError):
        poses[0] = 0

    bvh = throng.export(scene, tmp_path / "a.bvh", characters=[0, 2])
    assert bvh == [tmp_path / "a-0.bvh", tmp_path / "a-2.bvh"] and all(f.is_file() for f in bvh)
    back = throng.load_clip(bvh[1])
    assert back["rotations"].shape[1:] == (22, 4) and back["root_positions"][0, 1] > 0.5
    (whole,) = throng.export(scene, tmp_path / "all.npz", fps=60)
    (amass,) = throng.export(scene, tmp_path / "one.npz", "amass", characters=[1], fps=60)
    with np.load(whole) as a, np.load(amass) as b:
        assert a["positions"].shape == (3, 31, 22, 3) and b["poses"].shape == (31, 156)
        x, y, z = a["positions"][1, :, 0].T
        np.testing.assert_allclose(b["trans"], np.stack([x, -z, y], axis=1), atol=1e-5)
    with pytest.raises(throng.InputError, match="expected glb"):
        throng.export(scene, tmp_path / "a.doc")
    with pytest.raises(throng.InputError, match="there are 3"):
        throng.export(scene, tmp_path / "a.bvh", characters=[3])


def test_an_interrupt_ends_a_build(tmp_path):
    config = tmp_path / "walk.toml"
    longer = WALKS.split("[blend.ahead]")[0].replace("2.0", "20.0").replace("enabled = false", "enabled = true")
    config.write_text(longer)
    # Processes that a script starts in the background ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # It comes while the build runs: the timer of the process starts before it.
    threading.Timer(0.1, signal.raise_signal, [signal.SIGINT]).start()
    with pytest.raises(KeyboardInterrupt):
        throng.build(config, tmp_path / "walk.throng")
        time.sleep(60)  # A build that was faster than the signal.
    assert not list(tmp_path.glob("*.throng"))


def test_the_gym_environment(bundle):
    pytest.importorskip("gymnasium")
    from throng.gym import WalkToTargets

    def rollout(seed):
        env = WalkToTargets(bundle, num_envs=4, max_steps=5)
        out = [env.reset(seed=seed)[0]]
        assert env.observation_space.contains(out[0])
        for _ in range(8):
            observed, rewards, ended, cut, _ = env.step(env.baseline())
            assert env.observation_space.contains(observed)
            assert rewards.shape == ended.shape == cut.shape == (4,)
            out.append(observed)
        return np.stack(out)

    np.testing.assert_array_equal(rollout(3), rollout(3))
    assert (rollout(3) != rollout(4)).any()


def test_the_checker_of_gymnasium_is_content(bundle):
    gymnasium = pytest.importorskip("gymnasium")
    from gymnasium.utils.env_checker import check_env

    import throng.gym

    env = gymnasium.make("throng/WalkToTargets-v0", bundle=bundle, others=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # What a target is away has no bounds.
        warnings.filterwarnings("ignore", message=".*(minimum|maximum) value is -?infinity")
        check_env(env.unwrapped, skip_render_check=True)
    envs = gymnasium.make_vec("throng/WalkToTargets-v0", num_envs=3, bundle=bundle)
    assert isinstance(envs.unwrapped, throng.gym.WalkToTargets)
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(envs)
    envs.reset(seed=1)
    for _ in range(3):
        envs.step(envs.action_space.sample())


def test_the_baked_policy_comes_nearer_to_targets(bundle):
    pytest.importorskip("gymnasium")
    from throng.gym import WalkToTarget

    def rewards(act):
        env = WalkToTarget(bundle, others=0, max_steps=12)
        all_rewards = []
        for seed in range(8):
            env.reset(seed=seed)
            ended = cut = False
            while not (ended or cut):
                _, reward, ended, cut, _ = env.step(act(env))
                all_rewards.append(reward)
        return np.sum(all_rewards)

    assert rewards(lambda e: e.baseline()) > max(0.0, rewards(lambda e: -e.baseline()))


def test_the_example_runs(bundle, tmp_path):
    pytest.importorskip("gymnasium")
    example = ROOT / "python/examples/tour.py"
    subprocess.run([sys.executable, example, GOLDEN], cwd=tmp_path, check=True)


def test_a_type_checker_follows_the_stubs(tmp_path):
    pytest.importorskip("mypy")
    good = tmp_path / "good.py"
    good.write_text(
        "import numpy as np\nimport numpy.typing as npt\nimport throng\n"
        "b = throng.Bundle('a.throng')\ns = throng.Simulation('a.toml', b)\n"
        "roots: npt.NDArray[np.float32] = s.roots\nsaved: bytes = s.snapshot()\n"
        "s.step(1 / 60, parallel=True)\nn: int = b.sections()['FRAM'][0]\n"
    )
    bad = tmp_path / "bad.py"
    bad.write_text("import throng\nthrong.Simulation('a.toml').step('soon')\nthrong.Bundle('b').nothing\n")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache"]
    subprocess.run([*mypy, "-p", "throng"], cwd=tmp_path, check=True)
    subprocess.run([*mypy, good], cwd=tmp_path, check=True)
    told = subprocess.run([*mypy, bad], cwd=tmp_path, stdout=subprocess.PIPE, text=True).stdout
    assert "arg-type" in told and "attr-defined" in told
    subprocess.run([sys.executable, "-m", "mypy.stubtest", "throng._throng"], cwd=tmp_path, check=True)
