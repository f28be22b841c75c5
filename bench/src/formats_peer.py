"""The peer of formats.rs: writes the files into the folder that it is told, and reads them as Python programs do.

Prints one line per file: name, seconds of the best of several until every channel stands in an array of doubles, and the sum of
all numbers.
"""
import pathlib
import sys
import time
import warnings
import zipfile

import h5py
import nptdms
import numpy as np
import pyuff
import scipy.io
from scipy.io import wavfile

SIZE = 256 << 20
RATE = 10_000
SCALE = 0.001


def best(function, repeats=3):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        value = function()
        times.append(time.perf_counter() - start)
        total = float(sum(np.sum(channel) for channel in value))
        del value
    return min(times), total


def counts(channels, size=SIZE):
    """Rows of noise about a level, as a converter gives them."""
    rng = np.random.default_rng(1)
    noise = rng.normal(200, 100, (1 << 20, channels)).astype("<i2")
    rows = size // 2 // channels
    return np.resize(noise, (rows, channels))


def tdms_write(path, samples, interleaved):
    count = samples.shape[1]
    scale = {
        "wf_increment": 1.0 / RATE,
        "NI_Number_Of_Scales": 1,
        "NI_Scaling_Status": "unscaled",
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": SCALE,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
    }
    stored = samples.reshape(count, -1) if interleaved else samples.T
    channels = [nptdms.ChannelObject("group", f"channel {i}", np.ascontiguousarray(c), scale) for i, c in enumerate(stored)]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)
    if interleaved:
        # The same bytes, said to be one value of each channel after the other.
        with open(path, "r+b") as file:
            file.seek(4)
            flags = file.read(1)[0]
            file.seek(4)
            file.write(bytes([flags | 1 << 5]))


def tdms_read(path):
    with nptdms.TdmsFile.read(path) as file:
        return [channel[:] for channel in file["group"].channels()]


def uff_write(path, samples):
    uff = pyuff.UFF(str(path))
    for i, column in enumerate(samples.T):
        uff.write_sets(
            {
                "type": 58, "binary": 1, "func_type": 1, "rsp_node": i + 1, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0,
                "data": column.astype(float), "x": np.arange(len(column)) / RATE, "id1": "", "id2": "", "id3": "", "id4": "",
                "id5": "", "orddenom_spec_data_type": 0, "abscissa_spacing": 1,
                "abscissa_min": 0.0, "abscissa_inc": 1 / RATE, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 12,
            },
            "add",
        )


def cwa_write(path):
    """Blocks of 80 rows of three numbers, 100 a second."""
    blocks = SIZE // 512
    samples = counts(3, 80 * 6 * blocks).reshape(blocks, 240)
    block = np.zeros(blocks, np.dtype([
        ("mark", "S2"), ("length", "<u2"), ("fraction", "<u2"), ("session", "<u4"), ("sequence", "<u4"), ("stamp", "<u4"),
        ("light", "<u2"), ("temperature", "<u2"), ("events", "u1"), ("battery", "u1"), ("rate", "u1"), ("form", "u1"),
        ("offset", "<i2"), ("count", "<u2"), ("samples", "<i2", 240), ("sum", "<u2"),
    ]))
    number = np.arange(blocks, dtype=np.int64)
    hundredths = number * 80
    seconds, rest = hundredths // 100, hundredths % 100
    days, of_day = seconds // 86400, seconds % 86400
    date = np.datetime64("2024-01-01") + days
    years = date.astype("M8[Y]").astype(int) + 1970
    months = date.astype("M8[M]").astype(int) % 12 + 1
    of_month = (date - date.astype("M8[M]")).astype(int) + 1
    block["mark"], block["length"] = b"AX", 508
    block["sequence"] = number
    block["stamp"] = (
        (years - 2000) << 26 | months << 22 | of_month << 17 | of_day // 3600 << 12 | of_day // 60 % 60 << 6 | of_day % 60
    )
    # The stamp is that of the whole second; so many samples before it.
    block["offset"] = -rest
    block["temperature"], block["rate"], block["form"] = 266, 0x4A, 0x32
    block["count"], block["samples"] = 80, samples
    words = block.view("<u2").reshape(blocks, 256)
    block["sum"] = -np.sum(words, axis=1, dtype=np.int64) & 0xFFFF
    header = b"MD" + (1020).to_bytes(2, "little") + b"\xff" * 1020
    path.write_bytes(header + block.tobytes())


def cwa_read(path):
    """Accelerations, as the loaders with numpy do; without check sums and times."""
    words = np.memmap(path, "<i2", "r", 1024).reshape(-1, 256)
    samples = words[:, 15:255].reshape(-1, 3)
    return [samples[:, i] / 256.0 for i in range(3)]


def gt3x_write(path):
    """Records of 30 rows, one a second."""
    seconds = (SIZE // 4) // 189
    records = np.zeros(seconds, np.dtype([
        ("mark", "u1"), ("kind", "u1"), ("time", "<u4"), ("length", "<u2"), ("samples", "<i2", 90), ("sum", "u1"),
    ]))
    records["mark"], records["kind"], records["length"] = 0x1E, 26, 180
    records["time"] = np.arange(seconds) + 1_700_000_000
    records["samples"] = counts(3, 180 * seconds).reshape(-1, 90)
    octets = records.view("u1").reshape(seconds, -1)
    records["sum"] = ~np.bitwise_xor.reduce(octets[:, :-1], axis=1)
    info = "Serial Number: MOS2D00000000\r\nSample Rate: 30\r\nAcceleration Scale: 256.0\r\n"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=4) as archive:
        archive.writestr("info.txt", info)
        archive.writestr("log.bin", records.tobytes())


def gt3x_read(path):
    """Accelerations of records that are known to be alike; without check sums."""
    log = zipfile.ZipFile(path).read("log.bin")
    octets = np.frombuffer(log, "u1").reshape(-1, 189)[:, 8:188]
    samples = np.ascontiguousarray(octets).view("<i2").reshape(-1, 3)
    return [samples[:, i] / 256.0 for i in range(3)]


def hdf5_read(path):
    with h5py.File(path) as file:
        return [file["acc"].astype("f8")[:]]


def hdf5_write(path, size=SIZE, **how):
    with h5py.File(path, "w") as file:
        file.create_dataset("acc", data=counts(3, size), **how)


def numbers(array):
    return [array.astype("f8")]


def main():
    warnings.simplefilter("ignore")
    folder = pathlib.Path(sys.argv[1])
    chunks = {"chunks": (65_536, 3), "compression": "gzip", "compression_opts": 4}
    files = {
        "wav_2": (lambda p: wavfile.write(p, RATE, counts(2)), lambda p: numbers(wavfile.read(p)[1])),
        "wav_3": (lambda p: wavfile.write(p, RATE, counts(3)), lambda p: numbers(wavfile.read(p)[1])),
        "tdms_contiguous": (lambda p: tdms_write(p, counts(3), False), tdms_read),
        "tdms_interleaved": (lambda p: tdms_write(p, counts(3), True), tdms_read),
        "npy_int16": (lambda p: np.save(p, counts(3)), lambda p: numbers(np.load(p))),
        "mat_int16": (
            lambda p: scipy.io.savemat(p, {"acc": counts(3)}),
            lambda p: numbers(scipy.io.loadmat(p)["acc"]),
        ),
        "mat_double": (
            lambda p: scipy.io.savemat(p, {"acc": counts(3, SIZE // 4).astype("f8")}),
            lambda p: [scipy.io.loadmat(p)["acc"]],
        ),
        "uff58b_double": (
            lambda p: uff_write(p, counts(2, SIZE // 16)),
            lambda p: [s["data"] for s in pyuff.UFF(str(p)).read_sets()],
        ),
        "hdf5_contiguous": (hdf5_write, hdf5_read),
        "hdf5_deflate": (lambda p: hdf5_write(p, SIZE // 4, **chunks), hdf5_read),
        "hdf5_deflate_small": (lambda p: hdf5_write(p, SIZE // 32, **chunks), hdf5_read),
        "cwa": (cwa_write, cwa_read),
        "gt3x": (gt3x_write, gt3x_read),
    }
    for name, (write, read) in files.items():
        path = folder / f"{name}.npy" if name.startswith("npy") else folder / f"{name}.mat"
        write(path)
        path.read_bytes()
        print(name, *best(lambda: read(path)), flush=True)


main()
