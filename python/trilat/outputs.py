# SPDX-License-Identifier: MIT
"""Files and folders that appear whole or not at all: written aside under a fresh name, then renamed."""
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from trilat.errors import InputError


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """A fresh name beside `path` to write a file to; it becomes `path` at the end, or is removed after an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    os.close(handle)
    aside = Path(name)
    try:
        aside.chmod(0o666 & ~current_umask())
        yield aside
        os.replace(aside, path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


@contextmanager
def folder_aside(path: Path) -> Iterator[Path]:
    """The same for a folder; one that is there is exchanged for the new one, which the caller must have checked."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    aside.chmod(0o777 & ~current_umask())
    try:
        yield aside
        if path.exists():
            older = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent)) / path.name
            os.replace(path, older)
            os.replace(aside, path)
            shutil.rmtree(older.parent)
        else:
            os.replace(aside, path)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        raise


def current_umask() -> int:
    """The permissions that new files do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def refuse_inputs_within(output: Path, inputs: list[Path]) -> None:
    """InputError when an input is the output or lies in it: it would be replaced with it."""
    whole = output.resolve()
    for path in inputs:
        if whole in (path.resolve(), *path.resolve().parents):
            raise InputError(output, f"holds {path}, which is read; an output is never an input, whatever is forced")
