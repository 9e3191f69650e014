#!/usr/bin/env python3
"""A controller of your own against twinhub's plant; crates/link/STREAM.md describes the stream.

twinhub ride --controller 'python3 controller.py'
twinhub ride --listen ride.sock          and then   python3 controller.py ride.sock
"""
import socket
import struct
import sys
import zlib

LAYOUT = 0x644437cfe60ef7bc  # of the messages that this file is written for
HELLO, PLANT, CONTROLLER = 1, 3, 4  # kinds of packets
HELLO_LAYOUT = struct.Struct("<4I Q 2I")
PLANT_FRAME = struct.Struct("<4Q2I Q6f Q2f Q2f Q3fI Q5fI Q2I4f")
CONTROLLER_FRAME = struct.Struct("<4Q2I 3f3I 8f")
SPEED_M_S, ASSIST_ON = 22, 32  # places in the plant's frame


def receive(stream):
    """Kind and payload of the next packet; kind 0 when the plant has left."""
    head = stream.read(8)
    if len(head) < 8:
        return 0, b""
    magic, kind, length = struct.unpack("<4sHH", head)
    payload, (checksum,) = stream.read(length), struct.unpack("<I", stream.read(4))
    if magic != b"TWHB" or zlib.crc32(head[4:] + payload) != checksum:
        sys.exit("controller.py: a broken packet")
    return kind, payload


def send(stream, kind, payload):
    head = struct.pack("<HH", kind, len(payload))
    stream.write(b"TWHB" + head + payload + struct.pack("<I", zlib.crc32(head + payload)))
    stream.flush()


def ride(source, sink):
    """One ride. The pair grows by 10 Nm/s to 20 Nm between 3 and 9 m/s, while it is asked for."""
    pair_nm = 0.0
    while True:
        kind, payload = receive(source)
        if kind == HELLO:
            fits = HELLO_LAYOUT.unpack(payload)[4] == LAYOUT
            mine = HELLO_LAYOUT.pack(1, 2, 1, not fits, LAYOUT, PLANT_FRAME.size, CONTROLLER_FRAME.size)
            send(sink, HELLO, mine)
        elif kind == PLANT:
            frame = PLANT_FRAME.unpack(payload)
            wanted = frame[ASSIST_ON] and 3.0 < frame[SPEED_M_S] < 9.0
            pair_nm = min(max(pair_nm + (0.01 if wanted else -0.01), 0.0), 20.0)
            # The header goes back as it came; then torques, demand, mode, health, limits, estimate.
            answer = frame[:6] + (pair_nm, pair_nm, pair_nm, 2, 0, 0) + (0.0,) * 8
            send(sink, CONTROLLER, CONTROLLER_FRAME.pack(*answer))
        elif kind == 0:
            return


if len(sys.argv) > 1:  # a socket: one connection for each ride, until the command has ended
    try:
        while True:
            with socket.socket(socket.AF_UNIX) as line:
                line.connect(sys.argv[1])
                with line.makefile("rb") as source, line.makefile("wb") as sink:
                    ride(source, sink)
    except (FileNotFoundError, ConnectionError):
        pass
else:
    ride(sys.stdin.buffer, sys.stdout.buffer)
