# SPDX-License-Identifier: MIT
"""Errors and tables of a study from its samples: a second implementation, written from FORMATS.md.

`takes` are samples with truth_m, estimate_m, gdop, asked and answered, arrays instants x joints x methods.
"""
import collections

import numpy as np


def rigid(estimate_m, truth_m):
    """Rotation and translation of least squares (Kabsch 1976), without mirroring."""
    centre_m, truth_centre_m = estimate_m.mean(axis=0), truth_m.mean(axis=0)
    u, _, vt = np.linalg.svd((estimate_m - centre_m).T @ (truth_m - truth_centre_m))
    turn = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    return lambda points_m: (points_m - centre_m) @ turn.T + truth_centre_m


def errors_of(samples, m, alignment, chosen):
    """estimate - truth (instants x joints x 3) of the `chosen` samples, aligned on these; NaN elsewhere."""
    estimate_m = np.where(chosen[:, :, None], samples.estimate_m[:, :, m], np.nan)
    truth_m = np.where(chosen[:, :, None], samples.truth_m, np.nan)
    if alignment == "rigid" and chosen.any():
        return rigid(estimate_m[chosen], truth_m[chosen])(estimate_m) - truth_m
    errors_m = estimate_m - truth_m
    for j in np.flatnonzero(chosen.any(axis=0)):
        if alignment == "first":
            errors_m[:, j] -= errors_m[np.flatnonzero(chosen[:, j])[0], j]
        elif alignment == "mean":
            errors_m[:, j] -= np.nanmean(errors_m[:, j], axis=0)
    return errors_m


def group_of(joint):
    return joint.replace("_left", "").replace("_right", "")


def joints_of_groups(joints):
    groups = collections.defaultdict(list)
    for j, joint in enumerate(joints):
        groups[group_of(joint)].append(j)
    return groups


def mean_of(values):
    return np.mean(values) if len(values) else np.nan


def cell_of(takes, m, joints, errors_m, parts):
    """The numbers of one cell, of the samples in `parts`. Quantiles are of type 7 of Hyndman and Fan."""
    counted = [(s.answered[:, :, m] & part)[:, joints] for s, part in zip(takes, parts)]
    length_m = np.concatenate([np.linalg.norm(e[:, joints][c], axis=1) for e, c in zip(errors_m, counted)])
    asked = int(sum(part[:, joints].sum() for part in parts))
    quantiles_m = np.quantile(length_m, [0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 1.0]) if len(length_m) else 7 * [np.nan]
    return {"asked": asked, "answered": len(length_m), "coverage": len(length_m) / asked if asked else np.nan,
            "mae_m": mean_of(length_m), "rmse_m": np.sqrt(mean_of(length_m**2)),
            **dict(zip(["p05_m", "p25_m", "median_m", "p75_m", "p90_m", "p95_m", "max_m"], quantiles_m))}


def average_of(cells):
    """Mean of the groups' errors, but pooled counts."""
    asked, answered = sum(c["asked"] for c in cells), sum(c["answered"] for c in cells)
    return {"asked": asked, "answered": answered, "coverage": answered / asked,
            "mae_m": np.mean([c["mae_m"] for c in cells])}


def lengths_on_both(samples, m, reference, alignment):
    """Error lengths of a method and the reference, each aligned on the samples that both answer; NaN elsewhere."""
    both = samples.answered[:, :, m] & samples.answered[:, :, reference]
    return [np.linalg.norm(errors_of(samples, k, alignment, both), axis=2) for k in (m, reference)]


def differences_of(pairs, groups, parts):
    """The numbers of one difference a group, of the samples in `parts`, and of their average."""
    sums = {}
    for group, joints in groups.items():
        ours, theirs = (np.concatenate([pair[k][:, joints][part[:, joints]] for pair, part in zip(pairs, parts)])
                        for k in (0, 1))
        both = np.isfinite(ours)
        sums[group] = (int(both.sum()), mean_of((ours - theirs)[both]), mean_of(theirs[both]))
    n, difference_m, reference_m = zip(*sums.values())
    sums["average"] = (sum(n), np.mean(difference_m), np.mean(reference_m))
    return {group: {"n": n, "difference_m": d, "percent_of_reference": 100 * d / r,
                    "percent_of_method": 100 * d / (r + d)} for group, (n, d, r) in sums.items()}
