"""People walk to targets among others: environments for gymnasium.

``gymnasium.make_vec("throng/WalkToTargets-v0", num_envs=16, bundle="walk.throng")`` has many learners in one square, and
``gymnasium.make("throng/WalkToTargets-v0", bundle="walk.throng")`` one, among others whom the baked policy moves.
"""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import Bundle, Characters, _Floats, _Pathlike

__all__ = ["WalkToTarget", "WalkToTargets"]


class WalkToTargets(VectorEnv[_Floats, _Floats, npt.NDArray[Any]]):
    """Each environment is one of ``num_envs`` characters, all of whom walk about one square.

    An action is where to go, in the character's own frame: X left, Z ahead, each from -1 to 1, times ``reach_m``. The baked
    policy of ``behaviour`` takes the steps there. ``baseline()`` gives the actions that let the policy walk straight to the
    targets, as nearly as an action can say it.

    An observation has the target and the nearest two others, in the character's own frame (x, z; m). The reward is how
    much nearer the target came (m), plus 1 for coming within ``arrived_m``, less 0.5 for a step that ends nearer than
    ``clear_m`` to somebody. An episode ends at the target, and is cut short after ``max_steps``. The next one begins at the
    next step, which has no reward.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}
    reach_m = 4.0
    arrived_m = 0.5
    clear_m = 0.5

    def __init__(
        self,
        bundle: Bundle | _Pathlike,
        num_envs: int = 16,
        behaviour: str | None = None,
        size_m: float = 10.0,
        step_s: float = 0.5,
        max_steps: int = 60,
    ) -> None:
        self.bundle = bundle if isinstance(bundle, Bundle) else Bundle(bundle)
        self.num_envs, self.behaviour = num_envs, behaviour
        self.size_m, self.max_steps = size_m, max_steps
        self._ticks = max(1, round(step_s * 30))
        self.render_mode, self.spec = None, None
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.single_observation_space = gym.spaces.Box(-np.inf, np.inf, (6,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Floats, dict[str, Any]]:
        """Puts everybody somewhere, with a target of its own."""
        super().reset(seed=seed)
        places = np.zeros((self.num_envs, 3), np.float32)
        places[:, :2] = self._somewhere(self.num_envs)
        places[:, 2] = self.np_random.uniform(-np.pi, np.pi, self.num_envs)
        number = int(self.np_random.integers(2**31))
        self.characters = Characters(self.bundle, places, self.behaviour, seed=number)
        self.targets = self._somewhere(self.num_envs)
        self._steps = np.zeros(self.num_envs, np.int64)
        self._done = np.zeros(self.num_envs, bool)
        return self._observe(), {}

    def step(
        self, actions: _Floats
    ) -> tuple[_Floats, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        """Lets everybody walk for a step."""
        actions = np.clip(np.asarray(actions, np.float32), -1.0, 1.0).reshape(self.num_envs, 2)
        fresh = self._done
        for who in np.flatnonzero(fresh):
            (x, z), heading = self._somewhere(1)[0], self.np_random.uniform(-np.pi, np.pi)
            self.characters.place(int(who), float(x), float(z), float(heading))
            self.targets[who] = self._somewhere(1)[0]
            self._steps[who] = 0
        roots = self.characters.roots
        before = self._left(roots)
        aims = np.zeros((self.num_envs, 3), np.float32)
        aims[:, [0, 2]] = roots[:, :2] + _turned(actions * self.reach_m, roots[:, 2])
        self.characters.aim(aims)
        if not fresh.all():
            for _ in range(self._ticks):
                self.characters.step(1 / 30)
        roots = self.characters.roots
        left = self._left(roots)
        gaps = np.linalg.norm(roots[:, None, :2] - roots[None, :, :2], axis=2)
        np.fill_diagonal(gaps, np.inf)
        arrived = (left < self.arrived_m) & ~fresh
        rewards = (before - left) + arrived - 0.5 * (gaps.min(axis=1) < self.clear_m)
        rewards[fresh] = 0.0
        self._steps[~fresh] += 1
        cut = (self._steps >= self.max_steps) & ~arrived & ~fresh
        self._done = arrived | cut
        return self._observe(), rewards.astype(np.float64), arrived, cut, {}

    def baseline(self) -> _Floats:
        """Actions of the baked policy: the target itself, or the farthest place towards it that an action can name."""
        roots = self.characters.roots
        ahead = _turned(self.targets - roots[:, :2], -roots[:, 2]) / self.reach_m
        actions: _Floats = (ahead / np.maximum(1.0, np.abs(ahead).max(axis=1, keepdims=True))).astype(np.float32)
        return actions

    def _somewhere(self, count: int) -> _Floats:
        return self.np_random.uniform(-self.size_m / 2, self.size_m / 2, (count, 2)).astype(np.float32)

    def _left(self, roots: _Floats) -> _Floats:
        left: _Floats = np.linalg.norm(self.targets - roots[:, :2], axis=1)
        return left

    def _observe(self) -> _Floats:
        roots = self.characters.roots
        places, headings = roots[:, :2], roots[:, 2]
        out = np.zeros((self.num_envs, 6), np.float32)
        out[:, :2] = _turned(self.targets - places, -headings)
        gaps = np.linalg.norm(places[:, None] - places[None], axis=2)
        np.fill_diagonal(gaps, np.inf)
        near = np.argsort(gaps, axis=1, kind="stable")
        for k in range(2):
            if self.num_envs > k + 1:
                out[:, 2 + 2 * k : 4 + 2 * k] = _turned(places[near[:, k]] - places, -headings)
        return out


class WalkToTarget(gym.Env[_Floats, _Floats]):
    """The first character of `WalkToTargets` is the learner's; the baked policy moves ``others``."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, bundle: Bundle | _Pathlike, others: int = 15, **settings: Any) -> None:
        self.all = WalkToTargets(bundle, 1 + others, **settings)
        self.action_space = self.all.single_action_space
        self.observation_space = self.all.single_observation_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Floats, dict[str, Any]]:
        """Puts everybody somewhere, with a target of its own."""
        super().reset(seed=seed)
        return self.all.reset(seed=seed)[0][0], {}

    def step(self, action: _Floats) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        """Lets everybody walk for a step."""
        actions = self.all.baseline()
        actions[0] = action
        observed, rewards, arrived, cut, _ = self.all.step(actions)
        return observed[0], float(rewards[0]), bool(arrived[0]), bool(cut[0]), {}

    def baseline(self) -> _Floats:
        """The action of the baked policy."""
        action: _Floats = self.all.baseline()[0]
        return action


def _turned(points: _Floats, headings: _Floats) -> _Floats:
    """Points (x, z) turned about the vertical."""
    cos, sin = np.cos(headings), np.sin(headings)
    return np.stack([points[:, 0] * cos + points[:, 1] * sin, points[:, 1] * cos - points[:, 0] * sin], axis=1)


gym.register(
    "throng/WalkToTargets-v0", entry_point="throng.gym:WalkToTarget", vector_entry_point="throng.gym:WalkToTargets"
)
