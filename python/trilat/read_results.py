# SPDX-License-Identifier: MIT
"""Reads a results folder of `trilat run` of an accuracy study."""
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from trilat.errors import InputError
from trilat.read_numbers import numbers
from trilat.read_session import open_hdf5
from trilat.read_tables import tables

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas

NEWEST_SUMMARY = 12
NEWEST_MANIFEST = 2
NEWEST_TAKE = 4
ANSWERS = ("converged", "closed_form", "clamped", "given")
AXES = "xyz"


def _pandas():
    try:
        import pandas
    except ImportError:
        raise ImportError("tables need pandas: apt install python3-pandas; columns() gives arrays without it") from None
    return pandas


class Results:
    """The results of one accuracy study. `summary` is its summary.json as it stands."""

    def __init__(self, folder: str | os.PathLike) -> None:
        self.folder = Path(folder)
        path = self.folder / "summary.json"
        if not path.exists():
            self._check_finished()
        self.summary: dict = _document(path)
        if self.summary.get("kind") != "accuracy":
            raise InputError(path, f'is of the kind "{self.summary.get("kind")}"; "accuracy" is expected')
        if self.summary.get("version", 0) > NEWEST_SUMMARY:
            raise InputError(path, f"has version {self.summary['version']}; this module reads up to {NEWEST_SUMMARY}: "
                                   "take the one of the trilat that wrote it")
        manifest = self._manifest()
        # the item of each take that could be evaluated
        self._items: dict[str, Path] = {
            take["id"]: self.folder / "items" / key for take in manifest["takes"]
            if (key := manifest["items"][f"takes/{take['id']}"]) is not None}
        self.takes: tuple[str, ...] = tuple(self._items)
        if not self.takes:
            raise InputError(self.folder, "holds no take that could be evaluated; summary.json says why under notes")
        with self._take(self.takes[0]) as file:
            self.methods, self.joints, self._statuses = (
                tuple(_text(name) for name in file.attrs[key]) for key in ("methods", "joints", "status_names"))

    def _manifest(self) -> dict:
        path = self.folder / "manifest.json"
        manifest = _document(path)
        if manifest.get("version", 0) != NEWEST_MANIFEST:
            raise InputError(path, f"has version {manifest.get('version')}; this module reads {NEWEST_MANIFEST}: take the "
                                   "one of the trilat that wrote it")
        return manifest

    def _check_finished(self) -> None:
        if (self.folder / "manifest.json").exists():
            items = self._manifest()["items"]
            there = sum(1 for item in self.folder.glob("items/*/item.json"))
            raise InputError(self.folder, f"is unfinished: {min(there, len(items))} of {len(items)} items are there; "
                                          "`trilat run` goes on from them")

    def _take(self, take: str) -> h5py.File:
        return open_hdf5(self._items[take] / "take.h5", "trilat.take", NEWEST_TAKE)

    def _files(self, take: str | None) -> Iterator[tuple[str, h5py.File]]:
        if take is not None and take not in self.takes:
            raise InputError(self.folder, f'has no take "{take}"; it has {", ".join(self.takes)}')
        for name in self.takes if take is None else (take,):
            with self._take(name) as file:
                yield name, file

    def columns(self, take: str | None = None) -> dict[str, np.ndarray]:
        """Every sample as arrays of equal length, of one take or of all.

        take, condition, track ("mocap", or the sensor that is left out and stands for the truth), time_s (since the take's
        first instant), joint, method, status; truth_x_m to _z_m and
        estimate_x_m to _z_m in the world, before alignment; error_x_m to _z_m and error_m (their length) after the
        study's first alignment. NaN where there is none.
        """
        parts = [self._columns_of(name, file, track) for name, file in self._files(take)
                 for track in range(len(file.attrs["tracks"]))]
        return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}

    def _columns_of(self, take: str, file: h5py.File, track: int) -> dict[str, np.ndarray]:
        group = file[f"samples/{track}"]
        time_ns = group["time_ns"][:]
        shape = (len(time_ns), len(self.joints), len(self.methods))

        def spread(values: np.ndarray, axis: int) -> np.ndarray:
            return np.broadcast_to(np.expand_dims(values, tuple({0, 1, 2} - {axis})), shape).ravel()

        truth_m = np.broadcast_to(group["truth_m"][:][:, :, None], (*shape, 3)).reshape(-1, 3)
        estimate_m = group["estimate_m"][:].astype(float).reshape(-1, 3)
        error_m = self._errors_of(file, track).reshape(-1, 3)
        columns = {"take": np.full(len(truth_m), take), "condition": np.full(len(truth_m), _text(file.attrs["condition"])),
                   "track": np.full(len(truth_m), _text(file.attrs["tracks"][track])),
                   "time_s": spread(1e-9 * (time_ns - time_ns[:1]), 0), "joint": spread(np.array(self.joints), 1),
                   "method": spread(np.array(self.methods), 2),
                   "status": np.array(self._statuses)[group["status"][:].ravel()]}
        for name, values in (("truth", truth_m), ("estimate", estimate_m), ("error", error_m)):
            columns.update({f"{name}_{axis}_m": values[:, i] for i, axis in enumerate(AXES)})
        columns["error_m"] = np.sqrt((error_m ** 2).sum(axis=1))
        return columns

    def _errors_of(self, file: h5py.File, track: int) -> np.ndarray:
        """estimate - truth after the first alignment, instants x joints x methods x 3; NaN where nothing is answered."""
        group = file[f"samples/{track}"]
        estimate_m = group["estimate_m"][:].astype(float)
        answered = np.isin(np.array(self._statuses)[group["status"][:]], ANSWERS)
        aligned_m = np.full_like(estimate_m, np.nan)
        for row in _rows(file["errors/laid_over"]):
            of_track, j = divmod(int(row["quantity"]), len(self.joints))
            if row["alignment"] != 0 or of_track != track:
                continue
            m, first = int(row["method"]), int(row["first_instant"])
            turn = _turn(*(row[f"rotation_{k}"] for k in range(4)))
            moved_m = estimate_m[first:, j, m] @ turn.T + [row[f"shift_m_{axis}"] for axis in AXES]
            x, y, z = (row[f"offset_m_{axis}"] for axis in AXES)
            if x or y or z:
                cos, sin = np.cos(group["heading_rad"][first:]), np.sin(group["heading_rad"][first:])
                moved_m -= np.stack([cos * x + sin * z, np.full(len(cos), y), cos * z - sin * x], axis=1)
            aligned_m[first:, j, m] = np.where(answered[first:, j, m, None], moved_m, np.nan)
        return aligned_m - group["truth_m"][:][:, :, None]

    def errors(self, take: str | None = None) -> "pandas.DataFrame":
        """The sums that all numbers are made of: one row a take, track, block of time, quantity (a joint, the body, an angle),
        method, alignment, subset of samples and measure (datasets/FORMATS.md), with n, sum, sum_abs, sum_squares and largest in
        SI units. Alignment "": before any; method "truth": the truth itself."""
        pandas = _pandas()
        parts = []
        for name, file in self._files(take):
            group = file["errors/sums"]
            table = pandas.DataFrame({**_columns(group, "counts"), **_columns(group, "sums")})
            names = {key: np.array([_text(text) for text in file["errors"].attrs[key]])
                     for key in ("alignments", "quantities", "subsets", "measures")}
            tracks = np.array([*(_text(text) for text in file.attrs["tracks"]), ""])
            table.insert(0, "track", tracks[np.minimum(table["quantity"] // len(self.joints), len(tracks) - 1)])
            for key, values in (("method", [*self.methods, "truth"]), ("alignment", [*names["alignments"], ""]),
                                ("quantity", names["quantities"]), ("subset", names["subsets"]), ("measure", names["measures"])):
                table[key] = np.array(values)[table[key]]
            table.insert(0, "take", name)
            table.insert(1, "condition", _text(file.attrs["condition"]))
            parts.append(table)
        return pandas.concat(parts, ignore_index=True)

    def tables(self) -> "dict[str, pandas.DataFrame]":
        """What `trilat.tables` gives: every table of the study by its name."""
        return tables(self.folder)

    def samples(self, take: str | None = None) -> "pandas.DataFrame":
        """The columns of `columns()` as a DataFrame: one row an instant, joint and method."""
        return _pandas().DataFrame(self.columns(take))

    def numbers(self, **keys: str) -> "pandas.DataFrame":
        """The rows that `trilat.numbers` gives, as a DataFrame."""
        return _pandas().DataFrame(numbers(self.folder, **keys))

    def table(self, statistic: str = "mean", measure: str = "distance", condition: str | None = None,
              alignment: str | None = None) -> "pandas.DataFrame":
        """Methods by joint groups: the mean distance in metres, or another number of `numbers()`.

        Of the study's first condition and first alignment unless others are named.
        """
        for key, wanted in (("condition", condition), ("alignment", alignment)):
            known = self.summary[f"{key}s"]
            if wanted is not None and wanted not in known:
                raise InputError(self.folder, f'has no {key} "{wanted}"; it has {", ".join(known)}')
        rows = self.numbers(condition=condition or self.summary["conditions"][0], alignment=alignment or self.summary["alignments"][0],
                            measure=measure, statistic=statistic, against="")
        if rows.empty:
            raise InputError(self.folder / "numbers.csv", f"has no {statistic} of {measure}")
        return rows.pivot(index="method", columns="group", values="value").reindex(
            index=rows["method"].unique(), columns=rows["group"].unique())

    def timeline(self, take: str, joint: str, track: str | None = None) -> "pandas.DataFrame":
        """Error in metres over time, a column a method; the index is time_s. NaN where a method has no answer.

        The errors are those against one track: the take's first unless another is named (see `columns()`).
        """
        if joint not in self.joints:
            raise InputError(self.folder, f'has no joint "{joint}"; it has {", ".join(self.joints)}')
        samples = self.samples(take)
        tracks = list(samples["track"].unique())
        if track is not None and track not in tracks:
            raise InputError(self.folder, f'has no track "{track}"; it has {", ".join(tracks)}')
        samples = samples[(samples["joint"] == joint) & (samples["track"] == (track or tracks[0]))]
        return samples.pivot(index="time_s", columns="method", values="error_m").reindex(columns=list(self.methods))

    def plot(self, take: str, joint: str, track: str | None = None) -> "matplotlib.axes.Axes":
        """Draws `timeline()` in centimetres and gives the axes; needs matplotlib."""
        axes = (100.0 * self.timeline(take, joint, track)).plot(linewidth=0.8)
        kind = "simulated" if self.summary.get("simulated") else "recorded"
        axes.set(xlabel="time (s)", ylabel="error (cm)", title=f"{take}, {joint}, {kind}")
        return axes


def _document(path: Path) -> dict:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, "cannot be read; a folder that `trilat run` wrote is expected") from error
    except ValueError as error:
        raise InputError(path, f"is not JSON: {error}") from error


def _columns(group: h5py.Group, part: str) -> dict[str, np.ndarray]:
    return {_text(name): group[part][:, k] for k, name in enumerate(group.attrs[f"{part}_columns"])}


def _rows(group: h5py.Group) -> Iterator[dict[str, float]]:
    columns = {**_columns(group, "counts"), **_columns(group, "sums")}
    for values in zip(*columns.values()):
        yield dict(zip(columns, values))


def _turn(w: float, x: float, y: float, z: float) -> np.ndarray:
    """The rotation matrix of a unit quaternion."""
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def _text(value: object) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def results(folder: str | os.PathLike) -> Results:
    """Opens the results of an accuracy study. InputError when they are none, or of a newer version."""
    return Results(folder)
