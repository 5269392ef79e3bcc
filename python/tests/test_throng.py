"""The package against the promises of its documentation."""

import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

import throng

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = sorted((ROOT / "data/golden").glob("*.throng"), key=lambda p: int(p.stem.split("_v")[1]))[-1]
SQUARE = ROOT / "data/scenes/square.toml"


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
    with pytest.raises(throng.InputError, match="behaviour"):
        bundle.query([0], [[0, 0, 1]], "fly")
    with pytest.raises(throng.InputError, match="dt_s"):
        throng.Simulation(SQUARE).step(-1.0)


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
    assert sim.poses.shape == (200, 22, 3, 4) and np.isnan(sim.poses).all()


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


def test_the_gym_environment(bundle):
    gym = pytest.importorskip("gymnasium")
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

    assert gym is not None
    np.testing.assert_array_equal(rollout(3), rollout(3))
    assert (rollout(3) != rollout(4)).any()
