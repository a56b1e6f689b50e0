# SPDX-License-Identifier: MIT
"""The methods of a study for all samples at once: a second implementation, written from FORMATS.md.

Samples are rows: world_m (N x sensors x 3), range_m, state and used (N x sensors): `used` are the sensors that see the
joint and that the method takes; positions and ranges are NaN where a sensor does not see it. A method returns
estimate_m (N x 3), status (N texts) and iterations (N numbers; -1 where FORMATS.md does not fix them).
"""
import itertools

import numpy as np

ANSWERS = ("converged", "closed_form", "clamped")
SAME_MINIMUM_M = 1e-6
LARGEST_GDOP2_N = 1e10  # square of GDOP times number of sensors, beyond which directions do not span space


def hint_of(world_m):
    """The mean of the sensors' own positions; NaN without any."""
    seen = np.isfinite(world_m[:, :, 0])
    count = seen.sum(axis=1)[:, None]
    return np.where(count > 0, np.nansum(world_m, axis=1) / np.maximum(count, 1), np.nan)


def decide(first_m, second_m, hint_m):
    """Whether the first is nearer to the hint, and whether by less than half of the other's distance."""
    to_first, to_second = (np.linalg.norm(hint_m - p, axis=-1) for p in (first_m, second_m))
    return to_first <= to_second, (to_first < 0.5 * to_second) | (to_second < 0.5 * to_first)


class Plane:
    """The plane that fits the sensors best."""

    def __init__(self, sensor_m):
        self.centroid_m = sensor_m.mean(axis=0)
        _, spread_m, axes = np.linalg.svd(sensor_m - self.centroid_m)
        self.across_m = spread_m[2] if len(spread_m) > 2 else 0.0  # root of the sum of squared distances
        self.normal = axes[2]

    def offset_m(self, x_m):
        return (x_m - self.centroid_m) @ self.normal

    def mirrored(self, x_m):
        return x_m - 2.0 * self.offset_m(x_m)[..., None] * self.normal


def by_sensors(solve_alike):
    """Groups the samples by the sensors used: `solve_alike` gets samples that all have the same."""
    def solve(sensor_m, world_m, range_m, state, used, **settings):
        n = len(range_m)
        estimate_m, status, iterations = np.full((n, 3), np.nan), np.full(n, "", object), np.zeros(n, int)
        hint_m = hint_of(np.where(used[:, :, None], world_m, np.nan))
        for pattern in np.unique(used, axis=0):
            rows = np.flatnonzero((used == pattern).all(axis=1))
            if pattern.sum() < 3:
                status[rows] = "too_few_ranges"
                continue
            estimate_m[rows], status[rows], iterations[rows] = solve_alike(
                sensor_m[pattern], range_m[np.ix_(rows, pattern)], hint_m[rows], np.flatnonzero(pattern), **settings)
        return estimate_m, status, iterations
    return solve


def failed(n, status):
    return np.full((n, 3), np.nan), np.full(n, status, object), np.zeros(n, int)


@by_sensors
def linear(s_m, r_m, hint_m, numbers, reference=0, range_sigma_m=0.05):
    """2 (s_i - s_0) . x = |s_i|^2 - |s_0|^2 - r_i^2 + r_0^2 in least squares; `reference` None: all pairs."""
    if len(s_m) < 4:
        return failed(len(r_m), "rank_deficient")
    if reference is None:
        pairs = list(itertools.combinations(range(len(s_m)), 2))
    else:
        zero = next((k for k, number in enumerate(numbers) if number >= reference), 0)
        pairs = [(k, zero) for k in range(len(s_m)) if k != zero]
    i, j = np.array(pairs).T
    square_m2 = (s_m**2).sum(axis=1) - r_m**2
    x_m = np.linalg.lstsq(2.0 * (s_m[i] - s_m[j]), (square_m2[:, i] - square_m2[:, j]).T, rcond=None)[0].T
    status = np.full(len(r_m), "closed_form", object)
    plane = Plane(s_m)
    if plane.across_m < 10.0 * range_sigma_m:
        image_m = plane.mirrored(x_m)
        nearer, decided = decide(x_m, image_m, hint_m)
        x_m, status = np.where(nearer[:, None], x_m, image_m), np.where(decided, status, "mirror_ambiguous")
    return x_m, status, np.zeros(len(r_m), int)


@by_sensors
def geometric(s_m, r_m, hint_m, numbers):
    """Three spheres: the point of their plane with the right differences, and the height over it that remains."""
    edges = s_m[1:] - s_m[0]
    square_m2 = (s_m**2).sum(axis=1) - r_m**2
    normal = np.cross(*edges) / np.linalg.norm(np.cross(*edges))
    right = np.column_stack([(square_m2[:, 1:] - square_m2[:, :1]) / 2.0, np.full(len(r_m), s_m[0] @ normal)])
    foot_m = np.linalg.solve(np.vstack([edges, normal]), right.T).T
    height_m2 = r_m[:, 0]**2 - ((foot_m - s_m[0])**2).sum(axis=1)
    up_m = np.sqrt(np.maximum(height_m2, 0.0))[:, None] * normal
    nearer, decided = decide(foot_m + up_m, foot_m - up_m, hint_m)
    status = np.where(height_m2 < 0.0, "clamped", np.where(decided, "closed_form", "mirror_ambiguous"))
    return np.where(nearer[:, None], foot_m + up_m, foot_m - up_m), status, np.zeros(len(r_m), int)


def terms_of(x_m, s_m, r_m):
    """Unit vectors u_i, distances d_i, residuals f_i = d_i - r_i and F = sum f_i^2."""
    away_m = x_m[:, None] - s_m
    d_m = np.linalg.norm(away_m, axis=2)
    f_m = d_m - r_m
    return away_m / d_m[:, :, None], d_m, f_m, (f_m**2).sum(axis=1)


def minimum_from(x_m, s_m, r_m):
    """Damped Newton from each row's start, until no step lowers F or, where F is flat, its gradient.

    Half the Hessian of F is J^T J + sum (1 - r_i / d_i) (I - u_i u_i^T); where it is not positive definite, J^T J.
    """
    x_m, share = x_m.copy(), np.full(len(x_m), 1e-3)
    for _ in range(300):
        u, d_m, f_m, cost_m2 = terms_of(x_m, s_m, r_m)
        normal = np.einsum("nia,nib->nab", u, u)
        bend = np.einsum("ni,niab->nab", f_m / d_m, np.eye(3) - u[:, :, :, None] * u[:, :, None])
        convex = np.linalg.eigvalsh(normal + bend)[:, 0] > 0.0
        gradient = np.einsum("nia,ni->na", u, f_m)
        damped = normal + np.where(convex[:, None, None], bend, 0.0) + (share * len(s_m))[:, None, None] * np.eye(3)
        step_m = -np.linalg.solve(damped, gradient[:, :, None])[:, :, 0]
        there = terms_of(x_m + step_m, s_m, r_m)
        flat = np.abs(there[3] - cost_m2) <= 1e-15 * np.abs(f_m * d_m).sum(axis=1)
        shrinks = np.linalg.norm(np.einsum("nia,ni->na", there[0], there[2]), axis=1) < np.linalg.norm(gradient, axis=1)
        taken = np.where(flat, shrinks, there[3] < cost_m2)
        x_m[taken] += step_m[taken]
        share = np.where(taken, np.maximum(share / 5.0, 1e-18), share * 4.0)
        if np.linalg.norm(step_m, axis=1).max() < 1e-13:
            break
    return x_m


def rises_between(a_m, b_m, s_m, r_m):
    """Whether F at any 32nd of the way between two points is above its value at both."""
    between_m2 = np.max([terms_of(a_m + t * (b_m - a_m), s_m, r_m)[3] for t in np.arange(1, 32) / 32], axis=0)
    return between_m2 > np.maximum(terms_of(a_m, s_m, r_m)[3], terms_of(b_m, s_m, r_m)[3])


@by_sensors
def nonlinear(s_m, r_m, hint_m, numbers, range_sigma_m=0.05):
    """The minimum of F; between minima on both sides of the plane F decides at a likelihood ratio of 100."""
    plane, in_one_plane = Plane(s_m), len(s_m) == 3
    offset_m = plane.offset_m(hint_m)
    least_m = 0.3 * r_m.mean(axis=1)
    start_m = hint_m + (np.where(np.abs(offset_m) < least_m, np.copysign(least_m, offset_m), offset_m)
                        - offset_m)[:, None] * plane.normal
    one_m = minimum_from(start_m, s_m, r_m)
    other_m = plane.mirrored(one_m) if in_one_plane else minimum_from(plane.mirrored(start_m), s_m, r_m)
    one_m2, other_m2 = (terms_of(x, s_m, r_m)[3] for x in (one_m, other_m))
    alike = np.abs(one_m2 - other_m2) <= 2.0 * np.log(100.0) * range_sigma_m**2
    if not in_one_plane:
        alike &= rises_between(one_m, other_m, s_m, r_m)
    alike &= plane.offset_m(one_m) * plane.offset_m(other_m) <= 0.0
    alike &= np.linalg.norm(one_m - other_m, axis=1) > SAME_MINIMUM_M
    nearer, decided = decide(one_m, other_m, hint_m)
    first = np.where(alike & decided, nearer, one_m2 < other_m2)
    x_m = np.where(first[:, None], one_m, other_m)
    status = np.where(alike & ~decided, "mirror_ambiguous", "converged").astype(object)
    spread = np.maximum(np.linalg.svd(terms_of(x_m, s_m, r_m)[0], compute_uv=False), 1e-100)
    status[len(s_m) * (spread**-2).sum(axis=1) > LARGEST_GDOP2_N] = "rank_deficient"
    return x_m, status, np.full(len(r_m), -1)


@by_sensors
def as_printed(s_m, r_m, hint_m, numbers, unit_m=0.01, threshold_m2=1e-8, max_iterations=1000):
    """Equations 14, 17 and 19 as the paper prints them, from the hint; of three sensors' two images it decides."""
    x_m, status = hint_m.copy(), np.full(len(r_m), "iteration_limit", object)
    iterations = np.full(len(r_m), max_iterations)
    for k in range(1, max_iterations + 1):
        goes_on = np.flatnonzero(status == "iteration_limit")
        if len(goes_on) == 0:
            break
        u, d_m, f_m, before_m2 = terms_of(x_m[goes_on], s_m, r_m[goes_on])
        gradient = unit_m * np.einsum("nia,ni->na", u, f_m / d_m)
        x_m[goes_on] -= np.linalg.solve(np.einsum("nia,nib->nab", u, u), gradient[:, :, None])[:, :, 0]
        stops = goes_on[terms_of(x_m[goes_on], s_m, r_m[goes_on])[3] - before_m2 < threshold_m2]
        status[stops], iterations[stops] = "converged", k
    if len(s_m) > 3:
        return x_m, status, iterations
    image_m = Plane(s_m).mirrored(x_m)
    nearer, decided = decide(x_m, image_m, hint_m)
    apart = np.linalg.norm(x_m - image_m, axis=1) > SAME_MINIMUM_M
    status[(status == "converged") & apart & ~decided] = "mirror_ambiguous"
    return np.where(nearer[:, None], x_m, image_m), status, iterations


def weighted(world_m, weight):
    """The mean with weights (N x sensors), 0 for those that do not count."""
    total = weight.sum(axis=1)
    x_m = (np.nan_to_num(world_m) * weight[:, :, None]).sum(axis=1) / np.where(total > 0.0, total, np.nan)[:, None]
    return x_m, np.where(total > 0.0, "closed_form", "no_observation").astype(object), np.zeros(len(total), int)


def mean(sensor_m, world_m, range_m, state, used):
    return weighted(world_m, used.astype(float))


def tracked_mean(sensor_m, world_m, range_m, state, used):
    tracked = (state == 2) & used
    return weighted(world_m, np.where(tracked.any(axis=1)[:, None], tracked, used).astype(float))


def median_of_points(points_m):
    """The point of least summed distance (Vardi and Zhang 2000) and its status."""
    if len(points_m) <= 2:
        return points_m.mean(axis=0), "closed_form"
    for point_m in points_m:
        away_m = points_m[(points_m != point_m).any(axis=1)] - point_m
        pull = (away_m / np.linalg.norm(away_m, axis=1)[:, None]).sum(axis=0)
        if np.linalg.norm(pull) <= len(points_m) - len(away_m):
            return point_m, "closed_form"
    x_m = points_m.mean(axis=0)
    for _ in range(1000):
        away_m = points_m - x_m
        d_m = np.linalg.norm(away_m, axis=1)
        u = away_m / d_m[:, None]
        curvature = ((np.eye(3) - u[:, :, None] * u[:, None]) / d_m[:, None, None]).sum(axis=0)
        newton_m = np.linalg.solve(curvature, u.sum(axis=0))
        tried_m = np.array([(points_m / d_m[:, None]).sum(axis=0) / (1.0 / d_m).sum(),
                            *(x_m + newton_m * 0.5**k for k in range(13))])
        next_m = tried_m[np.linalg.norm(points_m - tried_m[:, None], axis=2).sum(axis=1).argmin()]
        moved_m, x_m = np.linalg.norm(next_m - x_m), next_m
        if moved_m < 1e-9:
            return x_m, "converged"
    return x_m, "iteration_limit"


def median(sensor_m, world_m, range_m, state, used):
    x_m, status = np.full((len(state), 3), np.nan), np.full(len(state), "no_observation", object)
    for n in range(len(state)):
        points_m = world_m[n, used[n]]
        if len(points_m) > 0:
            x_m[n], status[n] = median_of_points(points_m)
    return x_m, status, np.full(len(state), -1)
