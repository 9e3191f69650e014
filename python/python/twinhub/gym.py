"""A Gymnasium environment: the pair of a ride as an action. Needs ``pip install gymnasium``."""

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, finite, name_or_path, seed_text
from .errors import InputError

__all__ = ["StabilizerEnv"]

#: Ticks of 1 ms between two actions.
_TICKS = 20


class StabilizerEnv(gymnasium.Env[npt.NDArray[np.float32], npt.NDArray[np.float32]]):
    """A ride in which the action is the pair of motor torques.

    Estimator, supervisor, allocation and guard of the stabilizer stay in place: no action breaks a
    limit. An action holds for 20 ms. The observation is the controller's estimate (roll, rad; roll
    rate, rad/s; steer, rad; steer rate, rad/s; speed, m/s; yaw rate, rad/s) and the front brake torque
    that goes out (Nm). The action runs from -1 (no pair) to 1 (``pair_max_nm``). The reward of a step
    is minus the rider's squared effort (Nm^2) and ``energy_weight`` times the power (W), and -100 for a
    fall. The episode ends with a fall, and is cut off at the end of the course.

    Parameters
    ----------
    course : str or os.PathLike
        As for `twinhub.ride`.
    set : mapping or list of str, optional
        Values to change, as for `twinhub.ride`.
    pair_max_nm : float
        Largest pair, Nm; limits of the course's law hold besides.
    energy_weight : float
        Weight of the power, Nm^2/W.

    Raises
    ------
    InputError
        If an argument or the course is wrong.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        course: NameOrPath = "three_to_eight",
        set: Assignments | None = None,
        pair_max_nm: float = 40.0,
        energy_weight: float = 1e-3,
    ) -> None:
        self._course = name_or_path("course", course)
        self._set = assignments(set)
        self._pair_max_nm = finite("pair_max_nm", pair_max_nm)
        if self._pair_max_nm <= 0.0:
            raise InputError(f"pair_max_nm={pair_max_nm!r}: accepted: above 0 Nm")
        self._energy_weight = finite("energy_weight", energy_weight)
        high = np.array([4.0, 50.0, 4.0, 50.0, 50.0, 50.0, 100.0], dtype=np.float32)
        self.observation_space = spaces.Box(-high, high, dtype=np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, shape=(1,), dtype=np.float32)
        self._stepper: _twinhub._Stepper | None = None
        self._seen = np.zeros(7, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Begin a ride; ``seed`` sets its noise and disturbances, else they are drawn."""
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(2**31))
        self._stepper = _twinhub._Stepper(self._course, True, [*self._set, seed_text(drawn)])
        answer = self._stepper.step(1, 0.0)
        self._seen = self._observe(answer)
        return self._seen, {"seed": drawn}

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Go on by 20 ms."""
        if self._stepper is None:
            raise InputError("step before reset; accepted: reset() first")
        try:
            asked = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            asked = np.empty(0)
        if asked.size != 1 or not np.isfinite(asked).all():
            raise InputError(f"action={action!r}: accepted: an array of shape (1,), from -1 to 1")
        share = float(np.clip(asked.item(), -1.0, 1.0))
        answer = self._stepper.step(_TICKS, 0.5 * (share + 1.0) * self._pair_max_nm)
        ridden = max(int(answer["ridden"]), 1)
        power_w = float(answer["energy_j"]) / (ridden * 1e-3)
        reward = -float(answer["effort_nm2"]) / ridden - self._energy_weight * power_w
        fell = bool(answer["fell"])
        if fell:
            reward -= 100.0
        self._seen = self._observe(answer)
        cut_off = bool(answer["finished"]) and not fell
        info = {"t_s": answer["t_s"]}
        if fell or cut_off:
            info["metrics"] = self._stepper.metrics()
        return self._seen, reward, fell, cut_off, info

    def _observe(self, answer: dict[str, Any]) -> npt.NDArray[np.float32]:
        if "estimate" not in answer:
            return self._seen
        seen = np.array([*answer["estimate"][:6], answer["front_brake_nm"]], dtype=np.float32)
        space = self.observation_space
        assert isinstance(space, spaces.Box)
        return np.clip(seen, space.low, space.high)
