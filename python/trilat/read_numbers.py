# SPDX-License-Identifier: MIT
"""The numbers that a study stored: what all of its tables are made of."""
import csv
import io
import json
import os
from pathlib import Path

from trilat.errors import InputError

NUMBER_KEYS = ("condition", "group", "method", "against", "alignment", "measure", "statistic", "take")
VALUES = {"value": float, "low": float, "high": float, "n": int, "clusters": int, "p": float}


def numbers(folder: str | os.PathLike, **keys: str) -> list[dict]:
    """The rows of numbers.csv that have these keys, in SI units; NaN where there is no interval or p value.

    Keys are condition, group, method, against, alignment, measure, statistic and take, which are empty where they do not
    apply: of all takes together `take` is empty, and so are the rows that are given unless `take` is named.
    """
    path = Path(folder) / "numbers.csv"
    for key in keys.keys() - set(NUMBER_KEYS):
        raise InputError(path, f'has no column "{key}"; it has {", ".join(NUMBER_KEYS)}')
    wanted = {"take": "", **keys}
    try:
        stated = json.loads(path.with_name("summary.json").read_text(encoding="utf-8"))["rows"]
        with open(path, newline="", encoding="utf-8") as file:
            text = file.read()
        read = list(csv.DictReader(io.StringIO(text, newline="")))
        if not text.endswith("\n") or any(None in row or None in row.values() for row in read):
            raise ValueError("a row is cut")
        if len(read) != stated:
            raise ValueError(f"has {len(read)} numbers, and {stated} were written")
        return [{**row, **{key: _value(row[key], kind) for key, kind in VALUES.items()}} for row in read
                if all(row[key] == value for key, value in wanted.items())]
    except OSError as error:
        raise InputError(path, "cannot be read; a results folder that `trilat run` wrote is expected") from error
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(path, f"is damaged: {error}; make the results again") from error


def _value(text: str, kind: type) -> float:
    return kind(text) if text else float("nan")
