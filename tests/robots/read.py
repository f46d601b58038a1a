"""Reads what a fingertip publishes, by libraries that share no code with the program that sends it.

Call: read.py FILE.mcap ws://HOST:PORT ROWS. Prints as JSON what the file holds, read by two libraries,
and the first ROWS rows of the first finger that come over the WebSocket.
"""

import asyncio
import json
import struct
import sys

import websockets
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TOPIC = "/palpate/finger_1/fingertip"


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def described(message):
    """The numbers of a row, as JSON has them."""
    return {
        "number": message.number,
        "stamp_s": seconds(message.header.stamp),
        "frame_id": message.header.frame_id,
        "fa": [float(value) for value in message.fa],
        "sa": [float(value) for value in message.sa],
        "region": [int(value) for value in message.region],
    }


def store_of(schemas):
    """ROS 2 as it comes, and the types that the topics bring."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in schemas.items():
        own = text.split("=" * 80)[0]
        store.register(get_types_from_msg(own, name))
    return store


def from_file(path):
    """Every message by mcap-ros2-support, and every row also by rosbags."""
    topics, rows, same, store = {}, [], True, None
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2", reader.get_header()
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
            if channel.topic == TOPIC:
                store = store or store_of({schema.name: schema.data.decode()})
                row = described(decoded)
                other = described(store.deserialize_cdr(message.data, schema.name))
                same = same and row == other
                assert abs(message.log_time * 1e-9 - row["stamp_s"]) < 1e-6
                rows.append(row)
    return {"topics": topics, "rows": rows, "same": same}


async def live(url, count):
    """The first rows of the first finger."""
    async with websockets.connect(url, subprotocols=["foxglove.sdk.v1"]) as socket:
        while True:
            said = await socket.recv()
            if isinstance(said, str) and json.loads(said)["op"] == "advertise":
                break
        channels = json.loads(said)["channels"]
        channel = next(one for one in channels if one["topic"] == TOPIC)
        store = store_of({channel["schemaName"]: channel["schema"]})
        wish = {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channel["id"]}]}
        await socket.send(json.dumps(wish))
        rows = []
        while len(rows) < count:
            said = await socket.recv()
            if isinstance(said, bytes) and said[0] == 1:
                subscription, _ = struct.unpack_from("<IQ", said, 1)
                assert subscription == 1, subscription
                rows.append(described(store.deserialize_cdr(said[13:], channel["schemaName"])))
        return {"topics": sorted(one["topic"] for one in channels), "rows": rows}


def main():
    path, url, count = sys.argv[1:]
    print(json.dumps({"file": from_file(path), "live": asyncio.run(live(url, int(count)))}))


main()
