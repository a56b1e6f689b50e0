# SPDX-License-Identifier: MIT
"""Sessions and results of trilat in Python.

    import trilat
    errors = trilat.results("results").samples()          # a DataFrame
    means = trilat.numbers("results", statistic="mean")   # stored numbers, a dict each
    shown = trilat.tables("results")                      # every table that the report shows, as DataFrames
    bodies = trilat.session("session.h5")["k1"].bodies()  # arrays
    found = trilat.run("study.json", campaign="camp", output="results")

Lengths are metres, times seconds or nanoseconds as their names say. Converters of other people's recordings:
`python3 -m trilat.convert --help`.
"""
import sys

try:
    import h5py  # noqa: F401
    import numpy  # noqa: F401
except ImportError:
    MISSING = "trilat needs h5py and numpy: apt install python3-h5py python3-numpy"
    if sys.argv[0] == "-m":  # a command, as trilat.convert
        print(MISSING, file=sys.stderr)
        sys.exit(2)
    raise ImportError(MISSING) from None

from trilat.errors import InputError, ProgramError
from trilat.program import run
from trilat.read_numbers import NUMBER_KEYS, numbers
from trilat.read_results import Results, results
from trilat.read_session import Bodies, JointsInWorld, Sensor, Session, session
from trilat.read_tables import tables
from trilat.skeleton import JOINTS
from trilat.write_joints import write_joints
from trilat.write_session import SensorFrames, write_session

__all__ = ["Bodies", "InputError", "JOINTS", "JointsInWorld", "NUMBER_KEYS", "ProgramError", "Results", "Sensor", "SensorFrames", "Session",
           "numbers", "results", "run", "session", "tables", "write_joints", "write_session"]
