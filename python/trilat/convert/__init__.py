# SPDX-License-Identifier: MIT
"""Other people's recordings to sessions and campaigns. A format is a module with `HELP` and `convert(arguments)`, and
with `add_options(parser)` when it has options of its own. The table is in __main__.py; recording.py has what all need."""
