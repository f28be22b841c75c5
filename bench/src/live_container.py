"""What a torn tail and a damaged byte cost in containers that a live recording could be written to (DESIGN.md has the figures).

Twenty seconds of three axes at 1 kHz are written as MCAP (AccelStamped of ROS 2) and as an Arrow stream, then cut at places that are
drawn, and read: MCAP by `proofmass inspect`, whose path is the argument, Arrow by pyarrow. Needs mcap, mcap-ros2-support, pyarrow, numpy.
"""

import io
import json
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import pyarrow
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

SAMPLES, RATE, CUTS = 20_000, 1000, 100
BEGIN = 1_700_000_000_000_000_000
STEP = 1_000_000_000 // RATE
LINE = "=" * 80
SCHEMA = f"""std_msgs/Header header
geometry_msgs/Accel accel
{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{LINE}
MSG: geometry_msgs/Accel
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
{LINE}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def mcap(samples, chunk, compression):
    file = io.BytesIO()
    writer = Writer(file, chunk_size=chunk, compression=compression)
    schema = writer.register_msgdef("geometry_msgs/msg/AccelStamped", SCHEMA)
    for i, sample in enumerate(samples):
        stamp = BEGIN + i * STEP
        header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": ""}
        accel = {"linear": dict(zip("xyz", sample)), "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
        writer.write_message("/acc", schema, {"header": header, "accel": accel}, log_time=stamp, publish_time=stamp)
    writer.finish()
    return file.getvalue()


def arrow(samples, rows):
    file = io.BytesIO()
    fields = [("time", pyarrow.timestamp("ns")), *((axis, pyarrow.float64()) for axis in "xyz")]
    schema = pyarrow.schema(fields)
    with pyarrow.ipc.new_stream(file, schema) as writer:
        for begin in range(0, SAMPLES, rows):
            part = samples[begin : begin + rows]
            stamps = BEGIN + STEP * numpy.arange(begin, begin + len(part))
            columns = [pyarrow.array(stamps, pyarrow.timestamp("ns")), *(pyarrow.array(part[:, axis]) for axis in range(3))]
            writer.write_batch(pyarrow.record_batch(columns, schema=schema))
    return file.getvalue()


def rows_of_mcap(program, data):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "recording.mcap")
        path.write_bytes(data)
        said = subprocess.run([program, "inspect", "--json", path], capture_output=True, text=True)
    return json.loads(said.stdout)["rows"] if said.stdout else 0


def rows_of_arrow(_program, data):
    rows = 0
    try:
        with pyarrow.ipc.open_stream(data) as reader:
            for batch in reader:
                rows += batch.num_rows
    except (pyarrow.ArrowInvalid, OSError):
        pass
    return rows


def main():
    random.seed(3)
    counts = numpy.random.default_rng(1).integers(-2000, 2000, (SAMPLES, 3))
    samples = counts * 9.80665 / 4096
    for name, data, rows in [
        ("MCAP, chunks of 64 KiB", mcap(samples, 1 << 16, CompressionType.NONE), rows_of_mcap),
        ("MCAP, chunks of 64 KiB, zstd", mcap(samples, 1 << 16, CompressionType.ZSTD), rows_of_mcap),
        ("MCAP, chunks of 1 MiB, zstd", mcap(samples, 1 << 20, CompressionType.ZSTD), rows_of_mcap),
        ("Arrow stream, 1 s a batch", arrow(samples, RATE), rows_of_arrow),
    ]:
        size = len(data)
        torn, missing = [], []
        for _ in range(CUTS):
            at = random.randrange(size // 4, size)
            torn.append(max(0.0, at / size * SAMPLES - rows(sys.argv[1], data[:at])))
            damaged = bytearray(data)
            damaged[random.randrange(size // 4, size * 9 // 10)] ^= 0xFF
            missing.append(SAMPLES - rows(sys.argv[1], bytes(damaged)))
        print(f"{name}: {size / SAMPLES:.0f} bytes a sample; samples lost behind a cut {sum(torn) / CUTS:.0f} on average, {max(torn):.0f} at most; "
              f"left out for a damaged byte {sum(missing) / CUTS:.0f} on average, none in {missing.count(0)} of {CUTS}")


main()
