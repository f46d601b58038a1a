"""Writes one recording into a file of each format, by libraries that share no code with palpate's readers; text exports of
test machines, which no library writes, by hand.

Call: write.py FOLDER. 200 samples: time i/100 s, displacement (i mod 50)/10 mm, force i*i/1000 N.
"""

import datetime
import gzip
import json
import pathlib
import sys

import h5py
import nptdms
import numpy as np
import odf.opendocument
import odf.table
import odf.text
import openpyxl
import pyarrow as pa
import pyarrow.parquet
import rosbags.rosbag2
import rosbags.typesys
import scipy.io
import zstandard
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2Writer

COUNT = 200
TIME = [i / 100 for i in range(COUNT)]
X = [(i % 50) / 10 for i in range(COUNT)]
FORCE = [i * i / 1000 for i in range(COUNT)]
ROWS = list(zip(TIME, X, FORCE))
# 2024-05-31 14:03:05 UTC
START_S = 1_717_164_185


def packed(folder):
    own = "# name = \"press\"\ntime_s,displacement_mm,force_N\n"
    own = (own + "".join(f"{t!r},{x!r},{f!r}\n" for t, x, f in ROWS)).encode()
    (folder / "own.csv.gz").write_bytes(gzip.compress(own))
    (folder / "own.csv.zst").write_bytes(zstandard.compress(own))
    german = "Maschine;A\nZeit;Weg;Kraft;\ns;µm;N;\n"
    german += "".join(f"{t!r};{x * 1000!r};{f!r};\n".replace(".", ",") for t, x, f in ROWS)
    (folder / "german.txt.gz").write_bytes(gzip.compress(german.encode("cp1252")))


def spreadsheets(folder):
    book = openpyxl.Workbook()
    book.active.title = "Notes"
    book.active.append(["pressed by", "hand"])
    sheet = book.create_sheet("Run 1")
    sheet.append(["Operator", "me"])
    sheet.append([])
    sheet.append([None, "Time [s]", "Position [mm]", "Normal Force [N]", "Remark"])
    for t, x, f in ROWS:
        sheet.append([None, t, x, f, "a, b"])
    sheet = book.create_sheet("Run 2")
    sheet.append(["Datum", "Weg", "Kraft"])
    sheet.append(["", "mm", "N"])
    start = datetime.datetime(2024, 5, 31, 23, 59, 59)
    for t, x, f in ROWS:
        sheet.append([start + datetime.timedelta(microseconds=round(t * 1e6)), x, f])
    book.save(folder / "book.xlsx")

    document = odf.opendocument.OpenDocumentSpreadsheet()
    table = odf.table.Table(name="Data")
    for cells in [["Time (s)", "Displacement (mm)", "Force (N)"], *ROWS]:
        row = odf.table.TableRow()
        for value in cells:
            if isinstance(value, str):
                cell = odf.table.TableCell(valuetype="string")
                cell.addElement(odf.text.P(text=value))
            else:
                cell = odf.table.TableCell(valuetype="float", value=repr(value))
            row.addElement(cell)
        table.addElement(row)
    document.spreadsheet.addElement(table)
    document.save(folder / "book.ods")


def hdf5(folder):
    with h5py.File(folder / "run.h5", "w") as file:
        run = file.create_group("press/1")
        for name, unit, values in [("time", "ms", np.array(TIME) * 1000), ("load", "N", FORCE), ("stroke", "mm", X)]:
            data = run.create_dataset(name, data=values, chunks=(64,), compression="gzip", shuffle=True, fletcher32=True)
            data.attrs["units"] = unit
        file["press"].attrs["operator"] = "me"
        file["image"] = np.zeros((2, 30, 30))
    kinds = np.dtype([("time_s", "<f8"), ("label", "S4"), ("turns", "<u2"), ("force_N", ">f8"), ("displacement_mm", "<f8")])
    records = np.array([(t, b"ok", 7, f, x) for t, x, f in ROWS], dtype=kinds)
    with h5py.File(folder / "records.h5", "w", libver="latest") as file:
        file["table"] = records
    # What MATLAB's `save -v7.3` writes: a block of 512 bytes of its own, then HDF5 with matrices transposed.
    path = folder / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("press")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in [("time_s", TIME), ("displacement_mm", X), ("force_N", FORCE)]:
            data = group.create_dataset(name, data=np.array(values).reshape(1, COUNT))
            data.attrs["MATLAB_class"] = np.bytes_("double")
        text = group.create_dataset("remark", data=np.array([[104], [105]], dtype="uint16"))
        text.attrs["MATLAB_class"] = np.bytes_("char")
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM"
    with open(path, "r+b") as file:
        file.write(header)


def matlab(folder):
    data = {"Time": np.array(TIME).reshape(-1, 1), "Force": np.array(FORCE), "remark": "pressed by hand"}
    press = {"time_s": TIME, "displacement_mm": X, "force_N": FORCE, "cells": np.array([1, "a"], dtype=object)}
    scipy.io.savemat(folder / "press.mat", {"press": press}, do_compression=True)
    scipy.io.savemat(folder / "plain.mat", data, do_compression=False, oned_as="column")


WRENCH_STAMPED = """std_msgs/Header header
Wrench wrench
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Wrench
Vector3 force
Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def stamp(i):
    return {"sec": START_S + i // 100, "nanosec": (i % 100) * 10_000_000}


def bags(folder):
    with open(folder / "robot.mcap", "wb") as file:
        writer = Ros2Writer(file, chunk_size=4096)
        wrench = writer.register_msgdef("geometry_msgs/msg/WrenchStamped", WRENCH_STAMPED)
        joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for i, (_, x, f) in enumerate(ROWS):
            now = (START_S * 100 + i) * 10_000_000 + 1234
            header = {"stamp": stamp(i), "frame_id": "tip" + "x" * (i % 3)}
            message = {"header": header, "wrench": {"force": {"x": 0.5, "y": -1.0, "z": f}, "torque": {"x": 0.0, "y": 0.0, "z": 0.1}}}
            writer.write_message("/tip/wrench", wrench, message, now, now, i)
            state = {"header": header, "name": ["slide", "finger"], "position": [x, -x], "velocity": [], "effort": [f, 0.0]}
            writer.write_message("/joint_states", joints, state, now, now, i)
        writer.finish()
    with open(folder / "plain.mcap", "wb") as file:
        writer = McapWriter(file, chunk_size=2048)
        writer.start()
        schema = writer.register_schema("press", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/press", "json", schema)
        for i, (t, x, f) in enumerate(ROWS):
            body = json.dumps({"time_s": t, "tip": {"force_N": f}, "displacement_mm": x, "label": "a"}).encode()
            now = (START_S * 100 + i) * 10_000_000
            writer.add_message(channel, now, body, now)
        writer.finish()

    store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_HUMBLE)
    wrench = store.types["geometry_msgs/msg/Wrench"]
    vector = store.types["geometry_msgs/msg/Vector3"]
    header = store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    name = "geometry_msgs/msg/WrenchStamped"
    array = "std_msgs/msg/Float64MultiArray"
    layout = store.types["std_msgs/msg/MultiArrayLayout"]
    for folder_name, version in [("bag8", 8), ("bag9", 9)]:
        with rosbags.rosbag2.Writer(folder / folder_name, version=version) as bag:
            topic = bag.add_connection("/tip/wrench", name, typestore=store)
            other = bag.add_connection("/tip/array", array, typestore=store)
            for i, (_, x, f) in enumerate(ROWS):
                now = (START_S * 100 + i) * 10_000_000
                force = vector(x=0.5, y=-1.0, z=f)
                torque = vector(x=0.0, y=0.0, z=0.1)
                head = header(stamp=time(**stamp(i)), frame_id="tip")
                message = store.types[name](header=head, wrench=wrench(force=force, torque=torque))
                bag.write(topic, now, store.serialize_cdr(message, name))
                values = store.types[array](layout=layout(dim=[], data_offset=0), data=np.array([x, f]))
                bag.write(other, now, store.serialize_cdr(values, array))
        next((folder / folder_name).glob("*.db3")).rename(folder / f"{folder_name}.db3")


def labview(folder):
    def channel(name, unit, values):
        return nptdms.ChannelObject("Press", name, values, properties={"unit_string": unit})

    with nptdms.TdmsWriter(folder / "run.tdms") as writer:
        for start in range(0, COUNT, 80):
            part = slice(start, start + 80)
            writer.write_segment([
                channel("Time", "s", np.array(TIME[part])),
                channel("Position", "mm", np.array(X[part], dtype="f8")),
                channel("Force", "N", np.array(FORCE[part])),
                nptdms.ChannelObject("Notes", "Remark", ["pressed", "by hand"]),
            ])
    # A waveform: no time, but the step between its samples; and a scale from what was converted, 2 N each.
    scaled = {
        "unit_string": "N", "wf_increment": 0.01, "wf_start_offset": 0.0, "NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled",
        "NI_Scale[0]_Scale_Type": "Linear", "NI_Scale[0]_Linear_Slope": 0.001, "NI_Scale[0]_Linear_Y_Intercept": 5.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }
    position = {"unit_string": "mm", "wf_increment": 0.01}
    with nptdms.TdmsWriter(folder / "waveform.tdms") as writer:
        writer.write_segment([
            nptdms.ChannelObject("Press", "Force", np.array([i * i for i in range(COUNT)], dtype="i4"), properties=scaled),
            nptdms.ChannelObject("Press", "Position", np.array(X), properties=position),
        ])
    lines = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t.",
        "Multi_Headings\tYes", "X_Columns\tOne", "Time_Pref\tRelative", "Operator\tme", "Date\t2024/05/31",
        "Time\t14:03:05.25", "***End_of_Header***\t", "\t", "Channels\t2\t\t\t", "Samples\t200\t200\t\t",
        "Date\t2024/05/31\t2024/05/31\t\t", "Time\t14:03:05.25\t14:03:05.25\t\t", "Y_Unit_Label\tmm\tN\t\t",
        "X_Dimension\tTime\tTime\t\t", "X0\t0.0E+0\t0.0E+0\t\t", "Delta_X\t0.01\t0.01\t\t", "***End_of_Header***\t\t\t\t",
        "X_Value\tPosition\tForce\tComment",
    ]
    lines += [f"{t!r}\t{x!r}\t{f!r}\t" for t, x, f in ROWS]
    (folder / "run.lvm").write_text("\r\n".join(lines) + "\r\n")


def parquet(folder):
    table = pa.table({
        "Time (ms)": pa.array([t * 1000 for t in TIME]),
        "Force [N]": pa.array(FORCE),
        "Travel [mm]": pa.array(X, pa.float64()),
        "remark": pa.array(["a"] * COUNT),
        "sometimes": pa.array([None if i % 7 else i for i in range(COUNT)], pa.int32()),
    })
    pyarrow.parquet.write_table(table, folder / "foreign.parquet", compression="gzip", row_group_size=90)
    # As LeRobot's data sets are: lists of one length, two episodes in one file.
    half = COUNT // 2
    table = pa.table({
        "observation.state": pa.array(list(zip(X, FORCE)), pa.list_(pa.float64(), 2)),
        "action": pa.array([[x, f, -x] for _, x, f in ROWS], pa.list_(pa.float32())),
        "timestamp": pa.array([i % half / 100 for i in range(COUNT)], pa.float32()),
        "frame_index": pa.array([i % half for i in range(COUNT)], pa.int64()),
        "episode_index": pa.array([i // half for i in range(COUNT)], pa.int64()),
        "index": pa.array(range(COUNT), pa.int64()),
    })
    pyarrow.parquet.write_table(table, folder / "lerobot.parquet", compression="snappy")


def instruments(folder):
    """Text exports of test machines, made by hand after what their programs write."""
    def comma(value):
        return repr(value).replace(".", ",")

    # RheoCompass: UTF-16, an interval a table, below a line that names its columns.
    lines = ["Project:\tGel", "Test:\tRelaxation", "", "Result:\tRelaxation 1", ""]
    for interval in range(2):
        rows = ROWS[interval * 100:(interval + 1) * 100]
        lines += [f"Interval and data points:\t{interval + 1}\t{len(rows)}", "Interval data:\tPoint No.\tTime\tGap\tNormal Force\tStatus"]
        lines += ["\t\t\t\t\t", "\t\t[s]\t[mm]\t[N]\t[1]"]
        lines += [f"\t{i + 1}\t{comma(t)}\t{comma(x)}\t{comma(f)}\tMe-" for i, (t, x, f) in enumerate(rows)]
        lines += [""]
    (folder / "rheocompass.csv").write_bytes("\r\n".join(lines).encode("utf-16"))

    # TRIOS: a step a table, with the time of the step beside that of the test.
    lines = ["Filename\tC:\\gel.tri", "Instrument type\tDiscovery HR-3", "Time zone\tUTC", ""]
    for step in range(2):
        lines += ["[step]", f"Relaxation - {step + 1}", "Time\tStep time\tGap\tAxial force", "s\ts\tmm\tN"]
        lines += [f"{t!r}\t{t - step!r}\t{x!r}\t{f!r}" for t, x, f in ROWS[step * 100:(step + 1) * 100]]
        lines += [""]
    (folder / "trios.txt").write_bytes("\r\n".join(lines).encode("utf-8-sig"))

    # Bluehill: cells in quotes, units in brackets below the names.
    lines = ['"Specimen label","1"', '"Width","10.0","mm"', "", "Time,Extension,Load", "(s),(mm),(N)"]
    lines += [f'"{t!r}","{x!r}","{f!r}"' for t, x, f in ROWS]
    (folder / "bluehill.csv").write_text("\n".join(lines) + "\n")

    # testXpert: semicolons and decimal commas in the code page of Windows.
    lines = ['"Prüfer";"me"', '"Prüfzeit";"Standardweg";"Standardkraft"', '"s";"mm";"N"']
    lines += [";".join(map(comma, row)) for row in ROWS]
    (folder / "testxpert.tra").write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))

    # A bioindenter: nm and mN, in one table for each of its segments.
    lines = ["Bioindenter\tUNHT3 Bio", "Indenter\tSphere, 100 µm", ""]
    for segment in ["Loading", "Unloading"]:
        rows = ROWS[:120] if segment == "Loading" else ROWS[120:]
        lines += [f"Segment:\t{segment}", "Time [s]\tPd [nm]\tFn [mN]"]
        lines += [f"{t!r}\t{x * 1e6!r}\t{f * 1000!r}" for t, x, f in rows]
        lines += [""]
    (folder / "bioindenter.txt").write_bytes("\r\n".join(lines).encode("cp1252"))

    # Machines of Japan and China, in their own encodings.
    lines = ["試験名,押し込み", "時間,力,ストローク", "sec,N,mm", *(f"{t!r},{f!r},{x!r}" for t, x, f in ROWS)]
    (folder / "trapezium.csv").write_bytes("\r\n".join(lines).encode("shift_jis"))
    lines = ["操作员;张", "时间(s);位移(mm);载荷(N)", *(f"{t!r};{x!r};{f!r}" for t, x, f in ROWS)]
    (folder / "chinese.txt").write_bytes("\r\n".join(lines).encode("gbk"))


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True)
    for write in [packed, spreadsheets, hdf5, matlab, bags, labview, parquet, instruments]:
        write(folder)


main()
