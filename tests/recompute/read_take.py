# SPDX-License-Identifier: MIT
"""What a take's raw files say at the instants of a study: a second implementation, written from FORMATS.md.

It reads what `trilat simulate` writes: one person, clocks that never jump, ways of the network that queue alike,
no frozen markers, and takes that are too short for a clock to be bent.
"""
import csv
import itertools
import json
import pathlib

import h5py
import hdf5plugin  # noqa: F401, the filter of depth frames
import numpy as np

SIDES = ("shoulder", "elbow", "wrist", "hand")
JOINTS = (["spine_base", "spine_mid", "neck", "head"] + [f"{part}_left" for part in SIDES]
          + [f"{part}_right" for part in SIDES] + ["hip_left", "knee_left", "ankle_left", "foot_left", "hip_right",
          "knee_right", "ankle_right", "foot_right", "spine_shoulder", "hand_tip_left", "thumb_left", "hand_tip_right",
          "thumb_right"])
SWAPPED = {"left": "right", "right": "left"}
MIRROR = [JOINTS.index("_".join(SWAPPED.get(word, word) for word in joint.split("_"))) for joint in JOINTS]
HAS_MIRROR = np.array([MIRROR[j] != j for j in range(len(JOINTS))])
ONE_SIDE = ("spine_shoulder shoulder_* elbow_* wrist_* hand_* hand_tip_*", "wrist_* thumb_*",
            "spine_base hip_* knee_* ankle_* foot_*")
CHAINS = ["spine_base spine_mid spine_shoulder neck head"] + [c.replace("*", s) for s in SWAPPED for c in ONE_SIDE]
BONES = [(JOINTS.index(a), JOINTS.index(b)) for chain in CHAINS for a, b in zip(chain.split(), chain.split()[1:])]
SHORTEST_DRIFT_SPAN_NS = 10_000_000_000


def rounded(value_ns):
    """To whole nanoseconds, halves away from zero."""
    return (np.sign(value_ns) * np.floor(np.abs(value_ns) + 0.5)).astype(np.int64)


def upper_median(values):
    """The middle one, of an even number the upper one of both."""
    return np.sort(values)[len(values) // 2]


def slope_of_pairs(time_ns, offset_ns):
    """Theil and Sen's slope over the pairs that are at least a third of the span apart."""
    step = max(1, len(time_ns) // 200)
    time_ns, offset_ns, least_ns = time_ns[::step], offset_ns[::step], (time_ns[-1] - time_ns[0]) / 3.0
    i, j = np.triu_indices(len(time_ns), 1)
    apart_ns = (time_ns[j] - time_ns[i]).astype(float)
    kept = (apart_ns >= least_ns) & (apart_ns > 0)
    return upper_median((offset_ns[j] - offset_ns[i])[kept] / apart_ns[kept])


def host_from_machine(exchanges_ns):
    """A function from the machine's clock to the host's, from the exchanges of least delay."""
    if len(exchanges_ns) == 0:
        return lambda t_ns: t_ns
    t1, t2, t3, t4 = exchanges_ns.T
    delay_ns = (t4 - t1) - (t3 - t2)
    used = np.sort(np.argsort(delay_ns, kind="stable")[:max(3, len(delay_ns) // 4)])
    middle_ns = (t1 + (t4 - t1) // 2)[used]
    twice_ns = ((t2 - t1) + (t3 - t4))[used]
    base_ns = int(twice_ns[0] / 2)
    offset_ns = (twice_ns - 2 * base_ns) / 2.0
    since_ns = middle_ns - middle_ns[0]
    slope = slope_of_pairs(middle_ns, offset_ns) if since_ns[-1] >= SHORTEST_DRIFT_SPAN_NS else 0.0
    intercept_ns = upper_median(offset_ns - slope * since_ns)
    origin_ns = middle_ns[0] + base_ns + rounded(intercept_ns)
    drift = -slope / (1.0 + slope)
    return lambda t_ns: middle_ns[0] + (t_ns - origin_ns) + rounded(drift * (t_ns - origin_ns))


def lower_hull(x, y):
    """The numbers of the points on the lower convex hull; x rises."""
    hull = []
    for k in range(len(x)):
        while len(hull) >= 2:
            a, b = hull[-2:]
            if (y[b] - y[a]) * (x[k] - x[a]) < (y[k] - y[a]) * (x[b] - x[a]):
                break
            hull.pop()
        hull.append(k)
    return hull


def arrivals_ns(sensor):
    """Host time at which every body frame came to its machine."""
    return host_from_machine(sensor["clock_exchanges_ns"][:])(sensor["body_frames/arrival_ns"][:])


def live_frame_times_ns(sensor):
    """The same of a live system: arrival by the exchange of least delay of the last eight that it had."""
    exchanges_ns, frames_ns = sensor["clock_exchanges_ns"][:], sensor["body_frames/arrival_ns"][:]
    t1, t2, t3, t4 = exchanges_ns[np.argsort(exchanges_ns[:, 2], kind="stable")].T
    delay_ns, twice_ns = (t4 - t1) - (t3 - t2), (t1 - t2) + (t4 - t3)
    host_ns = np.empty_like(frames_ns)
    for i, arrival_ns in enumerate(frames_ns):
        known = max(1, np.searchsorted(t3, arrival_ns, side="right"))
        first = max(0, known - 8)
        host_ns[i] = arrival_ns + int(twice_ns[first + np.argmin(delay_ns[first:known])] / 2)
    return host_ns - int(sensor.attrs["latency_ns"])


def frame_times_ns(sensor):
    """Host time of every body frame: the edge over the middle of the lower hull of arrivals against ticks."""
    device_ns = sensor["body_frames/device_ticks"][:] * int(sensor.attrs["tick_ns"])
    arrival_ns = arrivals_ns(sensor)
    late_ns = arrival_ns - device_ns
    x, y = (device_ns - device_ns[0]).tolist(), (late_ns - late_ns[0]).tolist()
    hull = lower_hull(x, y)
    middle = x[hull[-1]] // 2
    right = next(k for k in range(1, len(hull)) if x[hull[k]] >= middle)
    a, b = hull[right - 1], hull[right]
    drift = (y[b] - y[a]) / (x[b] - x[a])
    since_ns = device_ns - device_ns[a]
    return arrival_ns[a] + since_ns + rounded(drift * since_ns) - int(sensor.attrs["latency_ns"])


def bodies_of_frames(sensor):
    """Position (frames x 25 x 3, metres) and state (frames x 25) of the body with most tracked joints."""
    frames = len(sensor["body_frames/sequence"])
    position_m = np.full((frames, 25, 3), np.nan, np.float32)
    state, most = np.zeros((frames, 25), np.uint8), np.full(frames, -1)
    rows = zip(sensor["bodies/frame"][:], sensor["bodies/position_m"][:], sensor["bodies/tracking_state"][:])
    for frame, joint_m, joint_state in rows:
        tracked = np.count_nonzero(joint_state == 2)
        if tracked <= most[frame]:
            continue
        there = np.isin(joint_state, (1, 2)) & np.isfinite(joint_m).all(axis=1)
        most[frame] = tracked
        position_m[frame] = np.where(there[:, None], joint_m, np.nan)
        state[frame] = np.where(there, joint_state, 0)
    return position_m, state


def sides_change(earlier_m, later_m):
    """Whether the later frames' mirrored joints are far nearer to the earlier ones (frames x 25 x 3)."""
    mirrored_m = later_m[:, MIRROR]
    straight = np.linalg.norm(earlier_m.astype(float) - later_m, axis=2)
    across = np.linalg.norm(earlier_m.astype(float) - mirrored_m, axis=2)
    compared = np.isfinite(straight) & np.isfinite(across) & HAS_MIRROR
    return (across * compared).sum(axis=1, where=compared) < 0.5 * straight.sum(axis=1, where=compared)


def body_at(frame_ns, position_m, state, time_ns, longest_gap_ns):
    """Joints in the sensor's frame (f32) and states at the instants; NaN and 0 where there are none."""
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(frame_ns)) > 0])
    frame_ns, position_m, state = frame_ns[rising], position_m[rising], state[rising]
    before = np.clip(np.searchsorted(frame_ns, time_ns, side="right") - 1, 0, len(frame_ns) - 1)
    after = np.minimum(before + 1, len(frame_ns) - 1)
    gap_ns, since_ns = frame_ns[after] - frame_ns[before], time_ns - frame_ns[before]
    exact = since_ns == 0
    share = np.where(exact, 0.0, since_ns / np.maximum(gap_ns, 1))[:, None, None]
    a, b = position_m[before], position_m[after]
    joint_m = (a.astype(float) + share * (b.astype(float) - a)).astype(np.float32)
    joint_state = np.minimum(state[before], state[after])
    nearer = np.where(share[:, 0, 0] < 0.5, before, after)
    whole = exact | sides_change(a, b)
    joint_m = np.where(whole[:, None, None], position_m[np.where(exact, before, nearer)], joint_m)
    joint_state = np.where(whole[:, None], state[np.where(exact, before, nearer)], joint_state)
    there = exact | ((time_ns > frame_ns[0]) & (time_ns < frame_ns[-1]) & (gap_ns <= longest_gap_ns))
    there = there[:, None] & (joint_state > 0)
    return np.where(there[:, :, None], joint_m, np.float32(np.nan)), np.where(there, joint_state, 0)


def newest_body(frame_ns, position_m, state, arrived_ns, time_ns, longest_gap_ns, late_ns):
    """The same of the newest frame that had arrived by each instant, not too late after its exposure."""
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(frame_ns)) > 0]) & (arrived_ns - frame_ns <= late_ns)
    frame_ns, position_m, state, arrived_ns = (a[rising] for a in (frame_ns, position_m, state, arrived_ns))
    joint_m, joint_state = np.full((len(time_ns), 25, 3), np.nan, np.float32), np.zeros((len(time_ns), 25), np.uint8)
    for i, t_ns in enumerate(time_ns):
        there = np.flatnonzero((frame_ns <= t_ns) & (arrived_ns <= t_ns) & (t_ns - frame_ns <= longest_gap_ns))
        if len(there) > 0:
            joint_m[i], joint_state[i] = position_m[there[-1]], state[there[-1]]
    return joint_m, joint_state


def crossings(in_sensor_m, rule):
    """How many bones cross before each joint's own bones: (... x 25 x 3) gives (... x 25). The paper's eq. 8.

    Bones are segments of the image, and 1 / z is linear along them; `printed`: of (x, y), with z.
    """
    x, y, z = np.moveaxis(in_sensor_m, -1, 0)
    z = np.where(z > 0.0, z, np.nan) if rule == "corrected" else z
    place, far = (np.stack([x / z, y / z], -1), -1.0 / z) if rule == "corrected" else (np.stack([x, y], -1), z)

    def share(a, b):  # of segment a, where the line of segment b cuts it; NaN where it does not
        along = place[..., b[1], :] - place[..., b[0], :]
        side = [np.cross(place[..., end, :] - place[..., b[0], :], along) for end in a]
        return np.where(side[0] * side[1] < 0.0, side[0] / (side[0] - side[1]), np.nan)

    count = np.zeros(x.shape, int)
    for a, b in itertools.combinations(BONES, 2):
        if rule == "corrected" and set(a) & set(b):
            continue
        on_a, on_b = share(a, b), share(b, a)
        far_a, far_b = ((1.0 - s) * far[..., i] + s * far[..., j] for s, (i, j) in ((on_a, a), (on_b, b)))
        for behind, bone in ((far_a > far_b, a), (far_b > far_a, b)):
            for end in bone:
                count[..., end] += behind
    return count


def rotation_of(xyzw):
    x, y, z, w = np.array(xyzw) / np.linalg.norm(xyzw)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def read_export(path):
    """Start-based time (ns) of an OptiTrack export's frames, and each marker's positions (frames x 3, metres)."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    head = dict(zip(rows[0][::2], rows[0][1::2]))
    assert head["Length Units"] == "Meters", head
    first = next(k for k, row in enumerate(rows) if row and row[0] == "Frame")
    names = next(row for row in rows if len(row) > 1 and row[1] == "Name")
    values = np.array([[float(v) if v else np.nan for v in row] for row in rows[first + 1:] if row])
    time_ns = rounded((values[:, 0] - values[0, 0]) * 1e9 / float(head["Export Frame Rate"]))
    first_column = {name: k for k, name in reversed(list(enumerate(names))) if k >= 2}
    return time_ns, {name: values[:, k:k + 3] for name, k in first_column.items()}


def truth_at(take_folder, mocap, mapping, joints, time_ns, longest_gap_ns):
    """Instants x joints x 3: the mean of a joint's markers, each interpolated between its nearest frames."""
    export_ns, markers = read_export(take_folder / mocap)
    of_joint = json.loads((take_folder / mapping).read_text())["joints"]

    def marker_at(name):
        known = np.isfinite(markers[name]).all(axis=1)
        known_ns, known_m = export_ns[known], markers[name][known]
        after = np.clip(np.searchsorted(known_ns, time_ns), 1, len(known_ns) - 1)
        a, b = after - 1, after
        share = (time_ns - known_ns[a]) / (known_ns[b] - known_ns[a])
        on_frame = (time_ns == known_ns[a]) | (time_ns == known_ns[b])
        inside = (time_ns >= known_ns[a]) & (time_ns <= known_ns[b]) & (known_ns[b] - known_ns[a] <= longest_gap_ns)
        point_m = known_m[a] + share[:, None] * (known_m[b] - known_m[a])
        return np.where((on_frame | inside)[:, None], point_m, np.nan)

    return np.stack([np.mean([marker_at(name) for name in of_joint[joint]], axis=0) if joint in of_joint
                     else np.full((len(time_ns), 3), np.nan) for joint in joints], axis=1)


class TakeAtInstants:
    """One take: time_ns, truth_m, and of each sensor what it gives in the world; arrays instants x joints x sensors."""

    def __init__(self, folder, take, joints, sensors, rate_hz=30.0, sensor_gap_s=0.11, truth_gap_s=0.055, late_s=0.033,
                 stage=None):
        stage = stage or {}
        folder = pathlib.Path(folder)
        self.id, self.participant, self.joints, self.sensors = take["id"], take["participant"], joints, sensors
        poses = {s["name"]: s for s in json.loads((folder / take["calibration"]).read_text())["sensors"]}
        self.sensor_m = np.array([poses[name]["position_m"] for name in sensors])
        with h5py.File(folder / take["session"]) as session:
            groups = [session["sensors"][name] for name in sensors]
            times_ns = live_frame_times_ns if stage.get("sensor_clocks") == "causal" else frame_times_ns
            frames = [(times_ns(group), *bodies_of_frames(group)) for group in groups]
            arrived_ns = [arrivals_ns(group) for group in groups]
        first_ns, last_ns = min(f[0][0] for f in frames), max(f[0][-1] for f in frames)
        count = int(np.floor((last_ns - first_ns) / 1e9 * rate_hz)) + 1
        self.time_ns = first_ns + rounded(np.arange(count) / rate_hz * 1e9)
        self.truth_m = truth_at(folder, take["mocap"], take["mapping"], joints,
                                self.time_ns - take["mocap_start_host_ns"], round(truth_gap_s * 1e9))
        gap_ns, late_ns = round(sensor_gap_s * 1e9), round(late_s * 1e9)
        if stage.get("frames") == "newest":
            seen = [newest_body(*frame, arrived, self.time_ns, gap_ns, late_ns)
                    for frame, arrived in zip(frames, arrived_ns)]
        else:
            seen = [body_at(*frame, self.time_ns, gap_ns) for frame in frames]
        self.all_state = np.stack([state for _, state in seen], axis=1)  # instants x sensors x 25
        in_sensor_m = np.stack([joint_m for joint_m, _ in seen], axis=1).astype(float)
        rotations = np.array([rotation_of(poses[name]["rotation_xyzw"]) for name in sensors])
        self.all_world_m = np.einsum("sab,isjb->isja", rotations, in_sensor_m) + self.sensor_m[:, None]
        wanted = [JOINTS.index(joint) for joint in joints]
        self.state = self.all_state[:, :, wanted].swapaxes(1, 2)
        self.world_m = self.all_world_m[:, :, wanted].swapaxes(1, 2)
        self.crossings = {rule: crossings(in_sensor_m, rule)[:, :, wanted].swapaxes(1, 2)
                          for rule in ("corrected", "printed")}
        self.range_m = np.linalg.norm(in_sensor_m[:, :, wanted], axis=3).swapaxes(1, 2)
