# SPDX-License-Identifier: MIT
"""The tables that a study of any kind stored: what its report shows."""
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

from trilat.errors import InputError

if TYPE_CHECKING:
    import pandas


def tables(folder: str | os.PathLike) -> "dict[str, pandas.DataFrame]":
    """Every table of a results folder by its name, such as "errors-walking": the columns of its CSV in the report, with
    units in their names ("head_mae_cm", and its interval's ends "head_mae_from_cm" and "head_mae_to_cm"), numbers
    unrounded. `attrs` has its "title" and "notes". InputError without tables: an older program's results."""
    try:
        import pandas
    except ImportError:
        raise ImportError("tables need pandas: apt install python3-pandas") from None
    path = Path(folder) / "tables.json"
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(path, "cannot be read; a folder that `trilat run` of this version wrote is expected") from error
    found = {}
    for table in document["tables"]:
        if table["rows_in"]:
            frame = pandas.read_csv(Path(folder) / table["rows_in"])
        else:
            cells = [[value for column, cell in zip(table["columns"], row) for value in _values(column, cell)] for row in table["rows"]]
            frame = pandas.DataFrame(cells, columns=[key for column in table["columns"] for key in _keys(column)])
        frame.attrs.update(title=table["title"] + (f" ({table['about']})" if "about" in table else ""), notes=table["notes"])
        found[table["id"]] = frame
    return found


def _keys(column: dict) -> list[str]:
    return [column["key"], column["from_key"], column["to_key"]] if column["has_interval"] else [column["key"]]


def _values(column: dict, cell: dict) -> list:
    nothing = "" if column["is_text"] else float("nan")
    value = cell.get("text", cell.get("number"))
    ends = [cell.get(end) for end in ("low", "high")] if column["has_interval"] else []
    return [nothing if value is None else value, *(float("nan") if end is None else end for end in ends)]
