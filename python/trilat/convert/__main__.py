# SPDX-License-Identifier: MIT
"""python3 -m trilat.convert FORMAT FILES -o OUT: other people's recordings to a session or a campaign."""
import argparse
import sys
from pathlib import Path

from trilat.convert import arena, azure_kinect, c3d, keraal, kimore, kinectmultitrack, labanotation, ntu, ui_prmd
from trilat.errors import InputError

FORMATS = {"arena": arena, "azure-kinect": azure_kinect, "c3d": c3d, "keraal": keraal, "kimore": kimore, "kinectmultitrack": kinectmultitrack,
           "labanotation": labanotation, "ntu": ntu, "ui-prmd": ui_prmd}


def arguments_of(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python3 -m trilat.convert", description="Converts other people's recordings to a session.",
        epilog="What a format does not say is assumed as docs/how-to/other_formats.md has it, and is written in the session's note. Exit codes: "
               "0 done; 1 done, but rows were left out, and it says which; 2 the input cannot be used.")
    formats = parser.add_subparsers(dest="format", required=True, metavar="FORMAT")
    for name, module in FORMATS.items():
        verb = formats.add_parser(name, help=module.HELP, description=module.HELP)
        verb.add_argument("files", nargs="+", type=Path, metavar="FILE", help="the recording")
        verb.add_argument("-o", "--output", type=Path, required=True,
                          help="session.h5; of ui-prmd, keraal and kinectmultitrack a folder; of arena and c3d a CSV")
        verb.add_argument("--rate-hz", type=float, help="frames a second, where the files have no time stamps")
        verb.add_argument("--force", action="store_true", help="replace whatever has the output's name")
        verb.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else there")
        if hasattr(module, "add_options"):
            module.add_options(verb)
    return parser.parse_args(words)


def refuse_placeholders(files: list[Path]) -> None:
    """Refuses what was downloaded in place of a recording, also within folders."""
    kinds = {b"version https://git-lfs": "is a pointer of Git LFS; `git lfs pull` fetches the file itself",
             b"<!DOCTYPE": "is a web page, saved in place of the file; download the file itself",
             b"<html": "is a web page, saved in place of the file; download the file itself"}
    for path in files:
        for file in [path] if path.is_file() else sorted(path.rglob("*")):
            if not file.is_file():
                continue
            with open(file, "rb") as opened:
                begin = opened.read(32)
            for start, kind in kinds.items():
                if begin.lower().startswith(start.lower()) and file.suffix.lower() not in (".html", ".htm"):
                    raise InputError(file, kind)


def main(words: list[str] | None = None) -> int:
    arguments = arguments_of(sys.argv[1:] if words is None else words)
    try:
        if arguments.rate_hz is not None and not 0.1 <= arguments.rate_hz <= 1000:
            raise InputError("--rate-hz", "goes from 0.1 to 1000")
        if arguments.output.resolve() in [file.resolve() for file in arguments.files]:
            raise InputError(arguments.output, "is also read; an output is never an input, whatever is forced")
        refuse_placeholders(arguments.files)
        return FORMATS[arguments.format].convert(arguments)
    except InputError as error:
        print(f"trilat.convert: {error}", file=sys.stderr)
    except BrokenPipeError:  # whoever read what is printed has gone
        sys.stdout = None
        return 1
    except OSError as error:
        print(f"trilat.convert: {error.filename or arguments.output}: {error.strerror or error}", file=sys.stderr)
    except ModuleNotFoundError as error:
        print(f"trilat.convert: {error.name}: is missing; install it (Debian: python3-{error.name.lower()})", file=sys.stderr)
    except Exception as error:  # a file that no check foresaw: its place, and nothing is left behind
        print(f"trilat.convert: {', '.join(map(str, arguments.files))}: cannot be read as {arguments.format}: "
              f"{type(error).__name__}: {error}; is the file damaged, or in another format?", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
