"""Measured rides of a third simulator, in numpy: the Whipple model with effects of its own, at 200 Hz.

Nothing of it is shared with the package but the matrices of the published model: it rides all rides of all
cases side by side, holds nothing between its steps, and declares no clock jitter.
"""

import gzip
from pathlib import Path

import numpy as np
import twinhub

STEP_S, SAMPLE_S, DURATION_S = 1e-3, 5e-3, 30.0
SPEEDS_M_S = (3.4, 4.4, 5.2, 6.3, 3.9, 4.8, 5.8)
FIT = 4
PULL_AT_M = (0.3, -0.95)
SYMBOLS = "IBxx IBxz IBzz IFxx IFyy IHxx IHxz IHzz IRxx IRyy c lam mB mF mH mR rF rR w xB xH xF zB zH".split()


def gains(a, b):
    """Feedback of the least cost, from the stable half of the Hamiltonian's eigenvectors."""
    weight, price = np.diag([100.0, 5.0, 5.0, 0.1]), 5.0
    hamiltonian = np.block([[a, -b @ b.T / price], [-weight, -a.T]])
    values, vectors = np.linalg.eig(hamiltonian)
    stable = vectors[:, values.real < 0]
    p = np.real(stable[4:] @ np.linalg.inv(stable[:4]))
    return (b.T @ p)[0] / price


class Rides:
    """All rides of all cases; a case maps effects to their sizes."""

    def __init__(self, cases, seed):
        self.cases, self.rng = cases, np.random.default_rng(seed)
        count = len(cases) * len(SPEEDS_M_S)
        declared = twinhub.parameters("meijaard2007_benchmark")
        self.size = {
            name: np.repeat([case.get(name, 0.0) for case in cases], len(SPEEDS_M_S)) for case in cases for name in case
        }
        self.mass, self.c1, self.k0, self.k2 = (np.zeros((count, 2, 2)) for _ in range(4))
        self.feedback, self.lever, self.wheelbase, self.trail = np.zeros((count, 4)), *np.zeros((3, count))
        for k in range(count):
            if k % len(SPEEDS_M_S) == 0:
                # One bicycle a case, within the declared two percent.
                drawn = {s: declared[s] * (1 + 0.02 * self.rng.standard_normal()) for s in SYMBOLS if s in declared}
                model = twinhub.linearise("meijaard2007_benchmark", 4.0, set=drawn)
            self.mass[k], self.c1[k], self.k0[k], self.k2[k] = model.mass, model.c1, model.k0, model.k2
            self.wheelbase[k], self.trail[k] = drawn["w"], drawn["c"]
            self.lever[k] = np.cos(drawn["lam"]) / drawn["w"]
            speed, inverse = SPEEDS_M_S[k % len(SPEEDS_M_S)], np.linalg.inv(model.mass)
            a = np.zeros((4, 4))
            a[:2, 2:] = np.eye(2)
            a[2:] = -inverse @ np.hstack([9.81 * model.k0 + speed**2 * model.k2, speed * model.c1])
            self.feedback[k] = gains(a, np.vstack([np.zeros((2, 1)), inverse[:, 1:]]))
        self.inverse = np.linalg.inv(self.mass)
        self.cruise = np.tile(SPEEDS_M_S, len(cases))
        self.phases = {name: self.rng.uniform(0, 2 * np.pi, (count, n)) for name, n in (("wish", 12), ("pull", 6), ("speed", 1))}

    def of(self, name):
        return self.size.get(name, 0.0)

    def multisine(self, name, hz, rms, t):
        hz = np.geomspace(*hz, self.phases[name].shape[1])
        return rms * np.sqrt(2 / len(hz)) * np.sin(2 * np.pi * hz * t + self.phases[name]).sum(1)

    def pull_n(self, t):
        return self.multisine("pull", (0.15, 1.1), 12.0, t)

    def speed_m_s(self, t):
        return self.cruise + 0.3 * np.sin(2 * np.pi * t / 23 + self.phases["speed"][:, 0])

    def rate(self, x, t, torque_nm, noise_nm):
        v, side = self.speed_m_s(t), self.trail * self.lever
        wind_n = 0.5 * 1.2 * 0.6 * self.of("crosswind") * np.hypot(v, self.of("crosswind"))
        force = self.pull_n(t)
        roll = -PULL_AT_M[1] * force + wind_n + 9.81 * self.of("lateral_offset")
        steer = (PULL_AT_M[0] * force + 0.5 * self.wheelbase * wind_n) * side
        steer = steer + torque_nm - self.of("steer_damping") * x[:, 3]
        q, rates = x[:, :2], x[:, 2:]
        torque = np.stack([roll, steer], 1) + noise_nm
        torque -= np.einsum("nij,nj->ni", v[:, None, None] * self.c1, rates)
        torque -= np.einsum("nij,nj->ni", 9.81 * self.k0 + (v * v)[:, None, None] * self.k2, q)
        return np.concatenate([rates, np.einsum("nij,nj->ni", self.inverse, torque)], 1)

    def ride(self):
        """Time, and by sample and ride: states, torque, pull, speed."""
        count, every = len(self.cruise), round(SAMPLE_S / STEP_S)
        x, torque, decided = np.zeros((count, 4)), np.zeros(count), np.zeros(count)
        kept = []
        h = STEP_S
        for k in range(round(DURATION_S / h)):
            t = k * h
            if k % every == 0:
                kept.append((x, torque, self.pull_n(t), self.speed_m_s(t)))
            if k % 20 == 0:
                decided = -(self.feedback * x).sum(1)
            wished = decided + self.multisine("wish", (0.3, 3.5), 0.5, t)
            after = torque + (wished - torque) * -np.expm1(-h / 0.03)
            middle = 0.5 * (torque + after)
            noise = self.rng.standard_normal((count, 2)) * np.array([0.25, 0.012]) / np.sqrt(h)
            k1 = self.rate(x, t, torque, noise)
            k2 = self.rate(x + h / 2 * k1, t + h / 2, middle, noise)
            k3 = self.rate(x + h / 2 * k2, t + h / 2, middle, noise)
            k4 = self.rate(x + h * k3, t + h, after, noise)
            x, torque = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), after
        assert np.abs(x).max() < 0.6, "a rider fell"
        states, torques, pulls, speeds = (np.array(column) for column in zip(*kept))
        return np.arange(len(kept)) * SAMPLE_S, states, torques, pulls, speeds

    def write(self, folder: Path):
        """Studies and rides of every case, in folders of their own: paths of the studies."""
        t, states, torques, pulls, speeds = self.ride()
        noise = self.rng.standard_normal
        studies = []
        for c in range(len(self.cases)):
            place = folder / str(c)
            place.mkdir()
            text = 'schema_version = 1\nname = "third simulator"\n[bicycle]\nmodel = "benchmark"\n'
            text += 'parameters = "meijaard2007_benchmark"\ntolerance_ratio = 0.02\n'
            for r in range(len(SPEEDS_M_S)):
                k = c * len(SPEEDS_M_S) + r
                roll, steer, roll_rate, steer_rate = states[:, k].T
                yaw_rate = self.lever[k] * (speeds[:, k] * steer + self.trail[k] * steer_rate)
                roll_rate = np.interp(t - self.cases[c].get("roll_rate_sensor_delay", 0.0), t, roll_rate)
                columns = {
                    "t": t,
                    "v": speeds[:, k] + 0.01 * noise(len(t)),
                    "torque": torques[:, k] + 0.02 * noise(len(t)),
                    "pull": pulls[:, k] + 0.5 * noise(len(t)),
                    "phi": roll + 0.003 * noise(len(t)) + 0.008 * noise(),
                    "p": roll_rate + 0.008 * noise(len(t)) + 0.008 * noise(),
                    "delta": steer + 0.002 * noise(len(t)) + 0.004 * noise(),
                    "r": yaw_rate + 0.008 * noise(len(t)) + 0.008 * noise(),
                }
                with gzip.open(place / f"{r}.csv.gz", "wt", compresslevel=1) as file:
                    np.savetxt(file, np.stack(list(columns.values()), 1), "%.6g", ",", header=",".join(columns), comments="")
                text += f'[[ride]]\nfile = "{r}.csv.gz"\nuse = "{"fit" if r < FIT else "held_out"}"\nrider = "one"\n'
                text += 'hands = "on"\nground = "road"\ntime = { column = "t" }\n'
                for column, quantity, rest in (
                    ("v", "speed_m_s", 'role = "input"'),
                    ("torque", "steer_torque_nm", 'role = "input"\nnoise_sd = 0.02'),
                    ("pull", "lateral_force_n", f'role = "input"\nnoise_sd = 0.5\npoint_m = [{PULL_AT_M[0]}, {PULL_AT_M[1]}]'),
                    ("phi", "roll_rad", 'role = "output"\nbias_sd = 0.01'),
                    ("p", "roll_rate_rad_s", 'role = "output"\nbias_sd = 0.01'),
                    ("delta", "steer_rad", 'role = "output"\nbias_sd = 0.005'),
                    ("r", "yaw_rate_rad_s", 'role = "output"\nbias_sd = 0.01'),
                ):
                    text += f'[[ride.channel]]\ncolumn = "{column}"\nquantity = "{quantity}"\n{rest}\n'
            studies.append(place / "STUDY.toml")
            studies[-1].write_text(text)
        return studies
