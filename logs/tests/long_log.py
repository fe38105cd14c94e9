"""Writes a log of 900 s with 40 channels at 1 kHz: `python3 logs/tests/long_log.py DIR`.

`DIR/long.mcap` and `DIR/long.db3` are ROS 2 bags of joint states (13 joints, position, velocity, effort) and
a command, `DIR/long.csv` a table, `DIR/long.parquet` the same. Needs `pip install mcap pyarrow numpy`.
"""

import pathlib
import sqlite3
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


def messages():
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
        yield 1_714_564_800_000_000_000 + k * 1_000_000, bytes(body)


with open(folder / "long.mcap", "wb") as file:
    writer = Writer(file, compression=CompressionType.LZ4)
    writer.start(profile="ros2")
    schema = writer.register_schema("demo/msg/State", "ros2msg", DEFINITION.encode())
    channel = writer.register_channel("/state", "cdr", schema)
    for stamp, body in messages():
        writer.add_message(channel, stamp, body, stamp)
    writer.finish()

# The tables of `ros2 bag record` since Iron.
(folder / "long.db3").unlink(missing_ok=True)
with sqlite3.connect(folder / "long.db3") as bag:
    bag.executescript("""
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
            serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
            type_description_hash TEXT NOT NULL);
        CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,
            encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL,
            type_description_hash TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
            timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);""")
    bag.execute("INSERT INTO topics VALUES (1, '/state', 'demo/msg/State', 'cdr', '', '')")
    definition = (DEFINITION,)
    bag.execute("INSERT INTO message_definitions VALUES (1, 'demo/msg/State', 'ros2msg', ?, '')", definition)
    bag.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?, ?)", messages())

columns = {"t_s": times}
for part, field in enumerate(("position", "velocity", "effort")):
    columns |= {f"j{j}_{field}": waves[:, part * JOINTS + j] for j in range(JOINTS)}
columns["j0_target"] = waves[:, -1]
table = pyarrow.table(columns)
pyarrow.parquet.write_table(table, folder / "long.parquet", compression="snappy")
pyarrow.csv.write_csv(table, folder / "long.csv")
