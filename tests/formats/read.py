"""Reads what palpate wrote for MATLAB and for the viewers of robots, by libraries that share no code with its writers.

Call: read.py FILE.mat FILE.mcap. Prints the columns and the head of each as JSON.
"""

import json
import sys

import h5py
from mcap.reader import make_reader


def mat(path):
    with open(path, "rb") as file:
        first = file.read(128)
    # What MATLAB looks at before it takes a file for HDF5: the text, the version 0x0200 and the order of bytes.
    assert first.startswith(b"MATLAB 7.3 MAT-file") and first[124:128] == b"\x00\x02IM", first
    with h5py.File(path) as file:
        columns, head = {}, None
        for name, values in file.items():
            kind = values.attrs["MATLAB_class"].decode()
            if kind == "char":
                head = values[...].tobytes().decode("utf-16-le")
            else:
                # MATLAB keeps a column of n numbers as one row of n.
                assert kind == "double" and values.shape[0] == 1, (name, kind, values.shape)
                columns[name] = values[0].tolist()
        return {"columns": columns, "head": head}


def mcap(path):
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        (about,) = reader.iter_metadata()
        assert about.name == "palpate"
        columns, before = {}, -1
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            row = json.loads(message.data)
            assert set(row) == set(json.loads(schema.data)["properties"])
            assert message.log_time > before
            before = message.log_time
            for name, value in row.items():
                columns.setdefault(name, []).append(value)
        return {"columns": columns, "head": about.metadata["head"]}


print(json.dumps([mat(sys.argv[1]), mcap(sys.argv[2])]))
