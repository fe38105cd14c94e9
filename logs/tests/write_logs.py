"""Writes logs with the writers that robots use, and beside them what each holds, bit by bit.

`python3 logs/tests/write_logs.py DIR` needs `pip install mcap mcap-ros2-support rosbags pyarrow numpy`.
`DIR/expected.json` holds, for each file, every column and time as the 64 bits of its numbers.
"""

import json
import pathlib
import random
import sqlite3
import struct
import sys

import numpy
import pyarrow
import pyarrow.parquet
from mcap.writer import CompressionType
from mcap.writer import Writer as RawWriter
from mcap_ros2.writer import Writer as RosWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ROWS = 40
NAMES = ["pan", "lift", "elbow"]
START_NS = 1_714_564_800_000_000_000
STEP_NS = 2_500_000
STATE = "control_msgs/msg/JointTrajectoryControllerState"
STATE_TEXT = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
trajectory_msgs/JointTrajectoryPoint error
trajectory_msgs/JointTrajectoryPoint output
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
string[] multi_dof_joint_names
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_reference
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_feedback
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_output
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual
"""
FOXY_STATE_TEXT = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
"""
FOXY_TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,
    serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL,
    data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""
PARTS = ["reference", "feedback", "error", "output", "desired", "actual"]

folder = pathlib.Path(sys.argv[1])
numbers = random.Random(7)
expected = {}


def bits(value):
    return struct.unpack("<Q", struct.pack("<d", value))[0]


def number():
    """A double of any size, now and then an odd one."""
    if numbers.random() < 0.1:
        return numbers.choice([0.0, -0.0, 5e-324, -1.7976931348623157e308, 1.0, 0.1])
    return numbers.uniform(-1.0, 1.0) * 10.0 ** numbers.randint(-12, 12)


def many(count):
    return [number() for _ in range(count)]


def rows():
    """Plain messages: type, fields, and the columns that they must give."""
    for k in range(ROWS):
        stamp = START_NS + k * STEP_NS
        header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "base" * (k % 3)}
        q, v, f = many(3), many(3), many(3)
        yield stamp, "/joint_states", "sensor_msgs/msg/JointState", {
            "header": header, "name": NAMES, "position": q, "velocity": v, "effort": f,
        }, {f"{field}[{name}]": x for field, values in (("position", q), ("velocity", v), ("effort", f))
            for name, x in zip(NAMES, values)}
        p, w = many(3), many(3)
        point = {"positions": p, "velocities": w, "accelerations": [], "effort": [],
                 "time_from_start": {"sec": 1, "nanosec": 5}}
        columns = {f"points[0].positions[{n}]": x for n, x in zip(NAMES, p)}
        columns |= {f"points[0].velocities[{n}]": x for n, x in zip(NAMES, w)}
        columns |= {"points[0].time_from_start.sec": 1.0, "points[0].time_from_start.nanosec": 5.0}
        yield stamp, "/arm/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", {
            "header": header, "joint_names": NAMES, "points": [point],
        }, columns
        parts, columns = {}, {}
        for part in PARTS:
            values = many(3)
            parts[f"multi_dof_{part}"] = {"transforms": [], "velocities": [], "accelerations": [],
                                          "time_from_start": {"sec": 2, "nanosec": 7}}
            columns |= {f"multi_dof_{part}.time_from_start.sec": 2.0,
                f"multi_dof_{part}.time_from_start.nanosec": 7.0}
            parts[part] = {**point, "positions": values, "velocities": []}
            columns |= {f"{part}.positions[{n}]": x for n, x in zip(NAMES, values)}
            columns |= {f"{part}.time_from_start.sec": 1.0, f"{part}.time_from_start.nanosec": 5.0}
        yield stamp, "/arm/state", STATE, {
            "header": header, "joint_names": NAMES, **parts, "multi_dof_joint_names": [],
        }, columns
        a, b = many(3), many(3)
        vector = lambda values: dict(zip("xyz", values))
        yield stamp, "/wrench", "geometry_msgs/msg/WrenchStamped", {
            "header": header, "wrench": {"force": vector(a), "torque": vector(b)},
        }, {f"wrench.{part}.{axis}": x for part, values in (("force", a), ("torque", b))
            for axis, x in zip("xyz", values)}
        x = number()
        yield stamp, "/command", "std_msgs/msg/Float64", {"data": x}, {"": x}
        values = many(4)
        dimension = {"label": "joints" + "x" * (k % 2), "size": 4, "stride": 4}
        yield stamp, "/commands", "std_msgs/msg/Float64MultiArray", {
            "layout": {"dim": [dimension], "data_offset": 0}, "data": values,
        }, {f"data[{i}]": x for i, x in enumerate(values)} | {
            "layout.dim[0].size": 4.0, "layout.dim[0].stride": 4.0, "layout.data_offset": 0.0}
        o, w, a, c = many(4), many(3), many(3), many(9)
        columns = {f"orientation.{axis}": x for axis, x in zip("xyzw", o)}
        for field, values in (("angular_velocity", w), ("linear_acceleration", a)):
            columns |= {f"{field}.{axis}": x for axis, x in zip("xyz", values)}
        for field in ("orientation", "angular_velocity", "linear_acceleration"):
            columns |= {f"{field}_covariance[{i}]": x for i, x in enumerate(c)}
        yield stamp, "/imu", "sensor_msgs/msg/Imu", {
            "header": header, "orientation": dict(zip("xyzw", o)), "orientation_covariance": c,
            "angular_velocity": vector(w), "angular_velocity_covariance": c,
            "linear_acceleration": vector(a), "linear_acceleration_covariance": c,
        }, columns


MESSAGES = list(rows())
STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg(STATE_TEXT, STATE))
FOXY = get_typestore(Stores.ROS2_FOXY)
FOXY.register(get_types_from_msg(FOXY_STATE_TEXT, STATE))


def expect(file, messages=MESSAGES):
    tables = {}
    for stamp, topic, _, _, columns in messages:
        table = tables.setdefault(topic, {"times_ns": [], "columns": {}})
        table["times_ns"].append(stamp)
        for name, value in columns.items():
            table["columns"].setdefault(name, []).append(bits(value))
    expected[file] = tables


def of_class(kind, value, store=STORE):
    """A message as the class that rosbags makes of its definition."""
    made = store.types[kind]
    fields = {}
    for name, (code, inner) in store.fielddefs[kind][1]:
        item = value[name]
        if int(code) == 2:
            item = of_class(inner, item, store)
        elif int(code) in (3, 4):
            (inner_code, inner_kind), _ = inner
            if int(inner_code) == 2:
                item = [of_class(inner_kind, one, store) for one in item]
            elif inner_kind[0] != "string":
                item = numpy.array(item, dtype=numpy.float64)
        fields[name] = item
    return made(**fields)


def definition(kind):
    return STORE.generate_msgdef(kind, ros_version=2)[0]


def with_mcap_ros2_support(name, compression):
    with open(folder / name, "wb") as file:
        writer = RosWriter(file, chunk_size=4096, compression=compression)
        schemas = {}
        for stamp, topic, kind, message, _ in MESSAGES:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, definition(kind))
            writer.write_message(topic, schemas[kind], message, log_time=stamp + 1000, publish_time=stamp)
        writer.finish()
    expect(name)


def big_endian(name):
    with open(folder / name, "wb") as file:
        writer = RawWriter(file, compression=CompressionType.LZ4)
        writer.start(profile="ros2")
        channels = {}
        for stamp, topic, kind, message, _ in MESSAGES:
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", definition(kind).encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = bytes(STORE.serialize_cdr(of_class(kind, message), kind, little_endian=False))
            writer.add_message(channels[topic], stamp + 1000, data, stamp)
        writer.finish()
    expect(name)


def with_rosbags(name, version, plugin, compression=CompressionMode.NONE):
    bag = BagWriter(folder / name, version=version, storage_plugin=plugin)
    if compression != CompressionMode.NONE:
        bag.set_compression(compression, CompressionFormat.ZSTD)
    with bag as writer:
        connections = {}
        for stamp, topic, kind, message, _ in MESSAGES:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], stamp, STORE.serialize_cdr(of_class(kind, message), kind))
    expect(name)


def without_definitions(name):
    """A bag as those before ROS 2 Iron: nothing says what its messages are made of."""
    with_rosbags(name, 9, StoragePlugin.SQLITE3)
    with sqlite3.connect(next((folder / name).glob("*.db3"))) as bag:
        bag.execute("DROP TABLE message_definitions")


def like_foxy(name):
    """A bag as the recorder of ROS 2 Foxy lays it out, with its messages: no definitions, no hashes."""
    root = folder / name
    root.mkdir()
    messages, topics = [], {}
    with sqlite3.connect(root / f"{name}_0.db3") as bag:
        bag.executescript(FOXY_TABLES)
        for stamp, topic, kind, message, columns in MESSAGES:
            if topic not in topics:
                topics[topic] = len(topics) + 1
                row = (topics[topic], topic, kind, "cdr", "")
                bag.execute("INSERT INTO topics VALUES (?, ?, ?, ?, ?)", row)
            data = bytes(FOXY.serialize_cdr(of_class(kind, message, FOXY), kind))
            row = (topics[topic], stamp, data)
            bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", row)
            if kind == STATE:
                known = ("desired.", "actual.", "error.")
                columns = {path: x for path, x in columns.items() if path.startswith(known)}
            messages.append((stamp, topic, kind, message, columns))
    (root / "metadata.yaml").write_text(f"""rosbag2_bagfile_information:
  version: 4
  storage_identifier: sqlite3
  relative_file_paths:
    - {name}_0.db3
  duration:
    nanoseconds: {(ROWS - 1) * STEP_NS}
  starting_time:
    nanoseconds_since_epoch: {START_NS}
  message_count: {len(messages)}
  compression_format: ""
  compression_mode: ""
""")
    expect(name, messages)


def tables():
    times = [k * 0.02 for k in range(ROWS)]
    q = [many(3) for _ in range(ROWS)]
    x = many(ROWS)
    columns = {f"q[{i}]": [bits(row[i]) for row in q] for i in range(3)} | {"x": [bits(v) for v in x]}
    for compression in ("none", "snappy", "gzip", "lz4", "zstd"):
        name = f"{compression}.parquet"
        table = pyarrow.table({
            "timestamp": times,
            "q": pyarrow.array(q, type=pyarrow.list_(pyarrow.float64())),
            "x": x,
            "what": ["a"] * ROWS,
        })
        pyarrow.parquet.write_table(table, folder / name, compression=compression, row_group_size=7)
        expected[name] = {"": {"times_s": [bits(t) for t in times], "columns": columns}}
    arrays = {"time": numpy.array(times), "q": numpy.array(q), "x": numpy.array(x)}
    numpy.savez(folder / "plain.npz", **arrays)
    numpy.savez_compressed(folder / "packed.npz", **arrays)
    numpy.savez(folder / "fortran.npz", **(arrays | {"q": numpy.asfortranarray(arrays["q"])}))
    for name in ("plain.npz", "packed.npz", "fortran.npz"):
        expected[name] = {"": {"times_s": [bits(t) for t in times], "columns": columns}}
    fields = numpy.zeros(ROWS, dtype=[("t_s", "<f8"), ("x", ">f8"), ("n", "<i4")])
    fields["t_s"], fields["x"], fields["n"] = times, x, range(ROWS)
    numpy.save(folder / "fields.npy", fields)
    expected["fields.npy"] = {"": {"times_s": [bits(t) for t in times], "columns": {
        "x": columns["x"], "n": [bits(float(k)) for k in range(ROWS)]}}}


def lerobot(name):
    root = folder / name
    (root / "meta").mkdir(parents=True)
    (root / "data" / "chunk-000").mkdir(parents=True)
    info = {"codebase_version": "v3.0", "fps": 50, "features": {
        "action": {"dtype": "float32", "shape": [2], "names": ["pan.pos", "lift.pos"]},
        "observation.state": {"dtype": "float32", "shape": [2], "names": ["pan.pos", "lift.pos"]}}}
    (root / "meta" / "info.json").write_text(json.dumps(info))
    single = lambda: struct.unpack("<f", struct.pack("<f", numbers.uniform(-2.0, 2.0)))[0]
    action = [[single(), single()] for _ in range(ROWS)]
    state = [[single(), single()] for _ in range(ROWS)]
    half = ROWS // 2
    as_list = lambda values: pyarrow.array(values, type=pyarrow.list_(pyarrow.float32(), 2))
    table = pyarrow.table({
        "action": as_list(action),
        "observation.state": as_list(state),
        "timestamp": pyarrow.array([k % half / 50 for k in range(ROWS)], type=pyarrow.float32()),
        "frame_index": [k % half for k in range(ROWS)],
        "episode_index": [k // half for k in range(ROWS)],
        "index": list(range(ROWS)),
        "task_index": [0] * ROWS,
    })
    pyarrow.parquet.write_table(table, root / "data" / "chunk-000" / "file-000.parquet")
    expected[name] = {f"episode-{e}": {"times_s": [bits(k / 50) for k in range(half)], "columns": {
        f"{field}[{joint}.pos]": [bits(row[i]) for row in values[e * half:(e + 1) * half]]
        for field, values in (("action", action), ("observation.state", state))
        for i, joint in enumerate(("pan", "lift"))}} for e in range(2)}


with_mcap_ros2_support("none.mcap", CompressionType.NONE)
with_mcap_ros2_support("lz4.mcap", CompressionType.LZ4)
with_mcap_ros2_support("zstd.mcap", CompressionType.ZSTD)
big_endian("big_endian.mcap")
with_rosbags("bag_8", 8, StoragePlugin.SQLITE3)
with_rosbags("bag_9", 9, StoragePlugin.SQLITE3)
without_definitions("bag_undefined")
like_foxy("bag_foxy")
with_rosbags("bag_mcap", 9, StoragePlugin.MCAP)
with_rosbags("bag_packed", 8, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
with_rosbags("bag_packed_mcap", 9, StoragePlugin.MCAP, CompressionMode.MESSAGE)
with_rosbags("bag_chunks", 9, StoragePlugin.MCAP, CompressionMode.STORAGE)
with_rosbags("bag_file", 8, StoragePlugin.SQLITE3, CompressionMode.FILE)
with_rosbags("bag_file_mcap", 9, StoragePlugin.MCAP, CompressionMode.FILE)
tables()
lerobot("lerobot")
(folder / "expected.json").write_text(json.dumps(expected))
