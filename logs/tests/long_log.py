"""Writes a log of 900 s with 40 channels at 1 kHz: `python3 logs/tests/long_log.py DIR`.

`DIR/long.mcap` is a ROS 2 bag of joint states (13 joints, position, velocity, effort) and a command,
`DIR/long.csv` a table, `DIR/long.parquet` the same. Needs `pip install mcap pyarrow numpy`.
"""

import pathlib
import struct
import sys

import numpy
import pyarrow
import pyarrow.csv
import pyarrow.parquet
from mcap.writer import CompressionType, Writer

ROWS = 900_000
JOINTS = 13
DEFINITION = "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\nfloat64 j0_target"

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
times = numpy.arange(ROWS) * 1e-3
generator = numpy.random.default_rng(1)
waves = numpy.stack([numpy.sin((1.0 + 0.3 * j) * times + j) for j in range(3 * JOINTS + 1)], axis=1)
waves += 1e-4 * generator.standard_normal(waves.shape)
names = [f"j{j}" for j in range(JOINTS)]

head = struct.pack("<I", JOINTS) + b"".join(
    struct.pack("<I", len(name) + 1) + (name.encode() + b"\0").ljust((len(name) + 4) // 4 * 4,
        b"\0") for name in names)
head = bytes([0, 1, 0, 0]) + head
with open(folder / "long.mcap", "wb") as file:
    writer = Writer(file, compression=CompressionType.LZ4)
    writer.start(profile="ros2")
    schema = writer.register_schema("demo/msg/State", "ros2msg", DEFINITION.encode())
    channel = writer.register_channel("/state", "cdr", schema)
    for k in range(ROWS):
        body = bytearray(head)
        for part in range(3):
            while (len(body) - 4) % 4:
                body.append(0)
            body += struct.pack("<I", JOINTS)
            while (len(body) - 4) % 8:
                body.append(0)
            body += waves[k, part * JOINTS:(part + 1) * JOINTS].tobytes()
        body += waves[k, -1:].tobytes()
        stamp = 1_714_564_800_000_000_000 + k * 1_000_000
        writer.add_message(channel, stamp, bytes(body), stamp)
    writer.finish()

columns = {"t_s": times}
for part, field in enumerate(("position", "velocity", "effort")):
    columns |= {f"j{j}_{field}": waves[:, part * JOINTS + j] for j in range(JOINTS)}
columns["j0_target"] = waves[:, -1]
table = pyarrow.table(columns)
pyarrow.parquet.write_table(table, folder / "long.parquet", compression="snappy")
pyarrow.csv.write_csv(table, folder / "long.csv")
