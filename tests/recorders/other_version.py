# SPDX-License-Identifier: MIT
"""other_version.py PORT: says hello to a recorder as an agent of version 4 would, and prints the reason of its refusal."""
import socket
import struct
import sys

with socket.create_connection(("127.0.0.1", int(sys.argv[1]))) as link:
    hello = struct.pack("<BIHB", 1, 0x4C495254, 4, 0)  # type, "TRIL", version, role
    link.sendall(struct.pack("<I", len(hello)) + hello)
    link.settimeout(5)
    answer = link.recv(4096)
length, kind, try_again, size = struct.unpack_from("<IBBH", answer)
print("refused" if kind == 3 and not try_again else "not refused", answer[8:8 + size].decode())
