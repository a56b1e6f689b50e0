# SPDX-License-Identifier: MIT
"""Errors and tables of a study from its samples: a second implementation, written from FORMATS.md.

`takes` are samples with truth_m, estimate_m, heading_rad, asked and answered, arrays instants x joints x methods.
"""
import collections
import math

import numpy as np

from solve import ANSWERS


def rigid(estimate_m, truth_m):
    """Rotation and translation of least squares (Kabsch 1976), without mirroring."""
    centre_m, truth_centre_m = estimate_m.mean(axis=0), truth_m.mean(axis=0)
    u, _, vt = np.linalg.svd((estimate_m - centre_m).T @ (truth_m - truth_centre_m))
    turn = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    return lambda points_m: (points_m - centre_m) @ turn.T + truth_centre_m


TRAINED = ("held_out", "joint_offset")
TRAINING_SHARE = 0.5
QUANTILES = {"p05": 0.05, "p25": 0.25, "median": 0.5, "p75": 0.75, "p90": 0.9, "p95": 0.95}


def in_test_part(samples, alignment):
    """Instants x 1: those that the alignment does not learn from, half rounded away from zero."""
    instants = len(samples.time_ns)
    return (np.arange(instants) >= (math.floor(TRAINING_SHARE * instants + 0.5) if alignment in TRAINED else 0))[:, None]


def turned(vectors_m, heading_rad):
    """Vectors of a body that faces that way, from +z towards +x, in the world."""
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    x, y, z = np.moveaxis(vectors_m, -1, 0)
    return np.stack([cos * x + sin * z, np.broadcast_to(y, x.shape), cos * z - sin * x], axis=-1)


def without_offset(errors_m, samples):
    """Less the mean error in the body's own frame of the training part, and that part as NaN."""
    heading_rad, test = samples.heading_rad.astype(float), in_test_part(samples, "joint_offset")
    in_body_m = np.stack([turned(errors_m[:, j], -heading_rad) for j in range(errors_m.shape[1])], axis=1)
    learnt = np.where((~test & np.isfinite(heading_rad)[:, None])[:, :, None], in_body_m, np.nan)
    count = np.isfinite(learnt).sum(axis=0)
    offset_m = np.nansum(learnt, axis=0) / np.where(count == 0, np.nan, count)
    left_m = [errors_m[:, j] - turned(np.broadcast_to(offset_m[j], (len(heading_rad), 3)), heading_rad) for j in range(errors_m.shape[1])]
    return np.where(test[:, :, None], np.stack(left_m, axis=1), np.nan)


def errors_of(samples, m, alignment, chosen):
    """estimate - truth (instants x joints x 3) of the `chosen` samples, aligned on these; NaN elsewhere."""
    estimate_m = np.where(chosen[:, :, None], samples.estimate_m[:, :, m], np.nan)
    truth_m = np.where(chosen[:, :, None], samples.truth_m, np.nan)
    if alignment == "rigid" and chosen.any():
        return rigid(estimate_m[chosen], truth_m[chosen])(estimate_m) - truth_m
    errors_m = estimate_m - truth_m
    if alignment == "joint_offset":
        return without_offset(errors_m, samples)
    if alignment == "held_out":
        return np.where(in_test_part(samples, alignment)[:, :, None], errors_m, np.nan)
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
    asked = [part[:, joints] for part in parts]
    counted = [(s.answered[:, :, m] & np.isfinite(e[:, :, 0]))[:, joints] & part for s, part, e in zip(takes, asked, errors_m)]
    error_m = np.concatenate([e[:, joints][c] for e, c in zip(errors_m, counted)])
    length_m, n = np.linalg.norm(error_m, axis=1), sum(int(part.sum()) for part in asked)
    ended = collections.Counter()
    for s, part in zip(takes, asked):
        ended.update(s.status[:, joints, m][part])
    iterations = sum(int(s.iterations[:, joints, m][part].astype(np.int64).sum()) for s, part in zip(takes, asked))
    statistics = {("distance", "rms"): np.sqrt(mean_of(length_m**2)), ("iterations", "mean"): iterations / n if n else np.nan,
                  **{("distance", name): np.quantile(length_m, share) if len(length_m) else np.nan for name, share in QUANTILES.items()},
                  ("distance", "max"): length_m.max() if len(length_m) else np.nan}
    for axis, name in enumerate("xyz"):
        statistics[name, "mean_abs"] = mean_of(np.abs(error_m[:, axis]))
        statistics[name, "bias"] = mean_of(error_m[:, axis])
    return {"asked": n, "answered": len(length_m), "mean": mean_of(length_m), "statuses": ended, "statistics": statistics}


def average_of(cells):
    """Mean of the groups' errors and biases, but pooled counts."""
    cells = list(cells)
    return {"asked": sum(c["asked"] for c in cells), "answered": sum(c["answered"] for c in cells), "mean": np.mean([c["mean"] for c in cells]),
            "statuses": sum((c["statuses"] for c in cells), collections.Counter()),
            "statistics": {(axis, "bias"): np.mean([c["statistics"][axis, "bias"] for c in cells]) for axis in "xyz"}}


def blocks_of(instants, rate_hz=30):
    """Block of time of each instant: five seconds, a twelfth of the take where that is longer."""
    return np.arange(instants) // max(5 * rate_hz, -(-instants // 12))


def limits_of(takes, errors_m, parts, joints, axis):
    """Standard deviation of a single difference and limits of agreement (Bland and Altman 1999, section 5.3), by one-way
    analysis of variance between the clusters: takes, of a single take its blocks of time."""
    differences = [np.where(part[:, joints], e[:, joints, axis], np.nan) for e, part in zip(errors_m, parts)]
    if len(takes) == 1:
        blocks = blocks_of(len(differences[0]))
        differences = [differences[0][blocks == b] for b in range(blocks[-1] + 1)]
    clusters = [values for values in (d[np.isfinite(d)] for d in differences) if len(values)]
    if not clusters:
        return {"sd": np.nan, "lower_limit": np.nan, "upper_limit": np.nan}
    sd, bias = spread_of(clusters), np.concatenate(clusters).mean()
    return {"sd": sd, "lower_limit": bias - 1.96 * sd, "upper_limit": bias + 1.96 * sd}


def spread_of(clusters):
    """Standard deviation of a single difference of any cluster."""
    clusters = [c for c in clusters if len(c)]
    sizes, everything, k = np.array([len(c) for c in clusters]), np.concatenate(clusters), len(clusters)
    n, bias = len(everything), everything.mean()
    within = sum(((c - c.mean())**2).sum() for c in clusters) / (n - k) if n > k else 0.0
    between = 0.0
    if k > 1:
        mean_square = sum(len(c) * (c.mean() - bias)**2 for c in clusters) / (k - 1)
        between = max(0.0, (mean_square - within) / ((n**2 - (sizes**2).sum()) / ((k - 1) * n)))
    return np.sqrt(within + between)


BONES = [(f"{a}_{side}", f"{b}_{side}") for side in ("left", "right")
         for a, b in (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))]


def similar(estimate_m, truth_m):
    """Mean distance after rotation, translation and scale of least squares (Umeyama 1991); NaN of points on a line."""
    x, y = estimate_m - estimate_m.mean(axis=0), truth_m - truth_m.mean(axis=0)
    if len(x) < 3 or any((s := np.linalg.svd(points, compute_uv=False))[1] <= 1e-6 * s[0] for points in (x, y)):
        return np.nan
    u, d, vt = np.linalg.svd(y.T @ x)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = (d * signs).sum() / (x**2).sum()
    return np.linalg.norm(scale * x @ (u @ np.diag(signs) @ vt).T - y, axis=1).mean()


def jerks_m_s3(points_m, known, rate_hz=30.0):
    """Lengths of the third difference of four points in a row, by the second of them."""
    four = known[:-3] & known[1:-2] & known[2:-1] & known[3:]
    third = points_m[3:] - 3 * points_m[2:-1] + 3 * points_m[1:-2] - points_m[:-3]
    return np.linalg.norm(third, axis=-1) * rate_hz**3, four


def bodies_of(takes, m, alignment="none"):
    """By measure, statistic and alignment the numbers of whole bodies and how many they are of: at instants at which every
    joint that has a truth is answered."""
    mpjpe_m, pa_mpjpe_m, near, spreads_m, jerks, truth_jerks, most_bones = [], [], [], [], [], [], 0
    for s in takes:
        errors_m = np.linalg.norm(errors_of(s, m, alignment, s.answered[:, :, m]), axis=2)
        near.append(np.array([np.where(s.answered[:, :, m], errors_m < limit, False)[s.asked] for limit in (0.05, 0.10, 0.15)]))
        bones = 0
        for i in np.flatnonzero(s.asked.any(axis=1) & (s.answered[:, :, m] | ~s.asked).all(axis=1)):
            mpjpe_m.append(errors_m[i, s.asked[i]].mean())
            pa_mpjpe_m.append(similar(s.estimate_m[i, s.asked[i], m], s.truth_m[i, s.asked[i]]))
        for a, b in BONES:
            if a in s.joints and b in s.joints:
                j, k = s.joints.index(a), s.joints.index(b)
                both = s.answered[:, j, m] & s.answered[:, k, m]
                if both.sum() > 1:
                    bones += 1
                    spreads_m.append(np.std(np.linalg.norm(s.estimate_m[both, j, m] - s.estimate_m[both, k, m], axis=1), ddof=1))
        most_bones = max(most_bones, bones)
        for j in range(len(s.joints)):
            usable = np.isin(s.status[:, j, m], ANSWERS)
            lengths, four = jerks_m_s3(s.estimate_m[:, j, m], usable)
            jerks += list(lengths[four & s.asked[1:-2, j]])
            lengths, four = jerks_m_s3(s.truth_m[:, j], s.asked[:, j])
            truth_jerks += list(lengths[four])
    near = np.concatenate(near, axis=1)
    return {("mpjpe", "mean", alignment): (mean_of(mpjpe_m), len(mpjpe_m)),
            ("pa_mpjpe", "mean", ""): (mean_of([x for x in pa_mpjpe_m if np.isfinite(x)]), len(mpjpe_m)),
            **{("within", radius, alignment): (share, near.shape[1]) for radius, share in zip(("5_cm", "10_cm", "15_cm"), near.mean(axis=1))},
            ("bone", "sd", ""): (mean_of(spreads_m), most_bones), ("jerk", "mean", ""): (mean_of(jerks), len(jerks)),
            ("truth", "mean", ""): (mean_of(truth_jerks), len(truth_jerks))}


STUDENT = {1: 12.7062, 2: 4.30265, 3: 3.18245, 4: 2.77645}  # 97.5 % quantiles by degrees of freedom


def interval_of_blocks(s, m, joints, alignment, rate_hz=30):
    """95 % interval of the mean error of a single take, whose blocks of five seconds are the clusters; and their number."""
    errors_m = np.linalg.norm(errors_of(s, m, alignment, s.answered[:, :, m]), axis=2)
    block = blocks_of(len(errors_m), rate_hz)
    sums, counts = (np.array([part(errors_m[block == b][:, joints]) for b in range(block[-1] + 1)])
                    for part in (np.nansum, lambda part_m: np.isfinite(part_m).sum()))
    clusters, mean_m = int((counts > 0).sum()), sums.sum() / counts.sum()
    error_m = np.sqrt(clusters / (clusters - 1) * (((sums - mean_m * counts) / counts.sum())**2).sum())
    return mean_m - STUDENT[clusters - 1] * error_m, mean_m + STUDENT[clusters - 1] * error_m, clusters


ANGLES = {f"{joint} flexion": (above, joint, below)
          for above, joint, below in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist"), ("shoulder", "hip", "knee"))}


def angles_of(s, m, names):
    """Left and right, in radians, at the instants at which truth and estimate have the angle: its errors, a list a block of
    time, and both themselves."""
    blocks = blocks_of(len(s.time_ns))
    found = {"error": [[] for _ in range(blocks[-1] + 1)], "truth": [], "estimate": []}
    for side in ("left", "right"):
        j = [s.joints.index(f"{name}_{side}") for name in names]
        truth, estimate = (flexion_rad(points[:, j]) for points in (s.truth_m, np.where(s.usable[:, :, m, None], s.estimate_m[:, :, m], np.nan)))
        for i in np.flatnonzero(np.isfinite(truth) & np.isfinite(estimate)):
            found["error"][blocks[i]].append(estimate[i] - truth[i])
            found["truth"].append(truth[i])
            found["estimate"].append(estimate[i])
    return found


def flexion_rad(points_m):
    up_m, down_m = points_m[:, 0] - points_m[:, 1], points_m[:, 2] - points_m[:, 1]
    cosine = (up_m * down_m).sum(axis=1) / np.linalg.norm(up_m, axis=1) / np.linalg.norm(down_m, axis=1)
    return np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))


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
    return {group: (n, d, d / r) for group, (n, d, r) in sums.items()}
