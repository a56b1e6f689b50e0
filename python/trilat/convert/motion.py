# SPDX-License-Identifier: MIT
"""Two recordings of one movement: how their clocks and their axes lie to each other, from the motion alone."""
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trilat.errors import InputError

STEP_S = 0.01             # between the offsets that are tried
BLOCK_S = 0.5             # of the block bootstrap
RESAMPLES = 300
LEAST_OVERLAP = 0.6       # of the shorter recording
LEAST_CORRELATION = 0.5   # below, the recordings are not of one movement
WIDEST_INTERVAL_S = 0.2   # beyond, the motion does not tell the offset
FEWEST_SAMPLES = 20


@dataclass
class Motion:
    """Joints over time: time_s (N,) rises, joint_m (N, J, 3); NaN where a joint is missing."""
    time_s: np.ndarray
    joint_m: np.ndarray

    def at(self, time_s: np.ndarray, longest_gap_s: float = 0.1) -> np.ndarray:
        """Linear between samples; NaN outside, and where samples are farther apart than `longest_gap_s`."""
        before = np.clip(np.searchsorted(self.time_s, time_s, "right") - 1, 0, len(self.time_s) - 2)
        gap_s = self.time_s[before + 1] - self.time_s[before]
        share = ((time_s - self.time_s[before]) / gap_s)[:, None, None]
        inside = (time_s >= self.time_s[0]) & (time_s <= self.time_s[-1]) & (gap_s <= longest_gap_s)
        between = (1 - share) * self.joint_m[before] + share * self.joint_m[before + 1]
        return np.where(inside[:, None, None], between, np.nan)


@dataclass(frozen=True)
class Pairing:
    """second's time = ratio * first's time + offset_s. The interval is 95 %, by a bootstrap over half seconds."""
    offset_s: float
    low_s: float
    high_s: float
    ratio: float
    ratio_low: float
    ratio_high: float
    correlation: float
    at_edge: bool = False  # no candidate beyond: what is there was not tried

    @property
    def problem(self) -> str:
        """Why the two cannot be set beside each other; empty where they can."""
        if not self.correlation >= LEAST_CORRELATION:
            return f"show no motion in common (correlation {self.correlation:.2f}); are they of the same take?"
        if self.at_edge:
            return f"fit best {self.offset_s:.2f} s apart, where they begin to overlap too little to be compared"
        if not self.high_s - self.low_s <= WIDEST_INTERVAL_S:
            return (f"show a motion that does not tell their offset in time: {self.offset_s:.2f} s, 95 % interval "
                    f"{self.low_s:.2f} to {self.high_s:.2f} s")
        return ""


def centred_pair(first: Motion, second: Motion, ratio: float, offset_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(which samples of `first`, its joints, the second's), joints less their means; 0 where one of them is missing.

    So constant differences between the joints of both do not count.
    """
    other = second.at(ratio * first.time_s + offset_s)
    both = np.isfinite(first.joint_m + other).all(axis=2)
    rows = both.any(axis=1)
    pair = []
    for joint_m in (first.joint_m, other):
        known = np.where(both[:, :, None], joint_m, 0.0)
        mean_m = known.sum(axis=0) / np.maximum(both.sum(axis=0), 1)[:, None]
        pair.append(np.where(both[:, :, None], known - mean_m, 0.0)[rows])
    return np.flatnonzero(rows), *pair


def enough(first: Motion, second: Motion, ratio: float, rows: np.ndarray) -> bool:
    """Whether so many samples of `first` have a counterpart that the two can be compared."""
    period_s, other_period_s = (float(np.median(np.diff(motion.time_s))) for motion in (first, second))
    shortest = min(len(first.time_s), len(second.time_s) * other_period_s / (ratio * period_s))
    return len(rows) >= max(FEWEST_SAMPLES, LEAST_OVERLAP * shortest)


def rotation_of(covariance: np.ndarray) -> np.ndarray:
    """The rotation R that maximises tr(R^T covariance), covariance = sum of second first^T (Kabsch): second = R first."""
    u, _, vt = np.linalg.svd(covariance)
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt


class Comparison:
    """All candidates of offset and ratio, compared once; what rotation lies between the axes is asked afterwards."""

    def __init__(self, first: Motion, second: Motion, search_s: float, ratios: Sequence[float] = (1.0,)) -> None:
        if min(len(first.time_s), len(second.time_s)) < FEWEST_SAMPLES:
            raise InputError("motion", f"have {len(first.time_s)} and {len(second.time_s)} samples; {FEWEST_SAMPLES} are needed")
        offsets_s = np.arange(-search_s, search_s + STEP_S / 2, STEP_S)
        self.candidates = np.array([(ratio, offset_s) for ratio in ratios for offset_s in offsets_s])
        block = ((first.time_s - first.time_s[0]) / BLOCK_S).astype(int)
        self.blocks = int(block[-1]) + 1
        # By candidate and block: the sum of second first^T, and of the squares of both.
        self.products = np.full((len(self.candidates), self.blocks, 3, 3), np.nan)
        self.squares = np.full((2, len(self.candidates), self.blocks), np.nan)
        for i, (ratio, offset_s) in enumerate(self.candidates):
            rows, a, b = centred_pair(first, second, ratio, offset_s)
            if not enough(first, second, ratio, rows):
                continue
            self.products[i], self.squares[:, i] = 0.0, 0.0
            np.add.at(self.products[i], block[rows], np.einsum("njx,njy->nxy", b, a))
            for k, joint_m in enumerate((a, b)):
                np.add.at(self.squares[k, i], block[rows], (joint_m**2).sum((1, 2)))
        if np.isnan(self.squares).all():
            raise InputError("motion", f"overlap too little within {search_s:g} s of each other")

    def pairing(self, second_from_first: np.ndarray | None = None) -> Pairing:
        """The candidate under which the joints' movements correlate most; without a rotation each has its own best."""
        if second_from_first is None:
            turns = np.array([rotation_of(total) if np.isfinite(total).all() else total for total in self.products.sum(axis=1)])
            products = np.einsum("cbxy,cxy->cb", self.products, turns)
        else:
            products = np.einsum("cbxy,xy->cb", self.products, second_from_first)

        def correlations(weight: np.ndarray) -> np.ndarray:
            with np.errstate(invalid="ignore", divide="ignore"):
                return np.nan_to_num(products @ weight / np.sqrt((self.squares[0] @ weight) * (self.squares[1] @ weight)), nan=-1.0)

        correlation = correlations(np.ones(self.blocks))
        best = int(np.argmax(correlation))
        weights = np.random.default_rng(1).multinomial(self.blocks, np.full(self.blocks, 1 / self.blocks), RESAMPLES).T
        found = self.candidates[np.argmax(correlations(weights), axis=0)]
        low, high = np.percentile(found, [2.5, 97.5], axis=0)
        ratio, offset_s = self.candidates[best]
        return Pairing(float(offset_s), float(low[1]), float(high[1]), float(ratio), float(low[0]), float(high[0]),
                       float(correlation[best]), self._at_edge(best))

    def _at_edge(self, best: int) -> bool:
        known = np.flatnonzero(np.isfinite(self.squares[0, :, 0]) & (self.candidates[:, 0] == self.candidates[best, 0]))
        return best in (known[0], known[-1])

    def covariance(self, pairing: Pairing) -> np.ndarray:
        """(3, 3) sum of second first^T under this pairing."""
        at = np.argmin(np.abs(self.candidates - [pairing.ratio, pairing.offset_s]).sum(axis=1))
        return self.products[at].sum(axis=0)
