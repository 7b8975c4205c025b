"""Reads a bag with libraries of others, and prints as JSON what is in it: profile, topics with types, hashes and counts, and some values.

`mcap` reads the file; `rosbags` parses the definitions, computes the type hashes from them and decodes every message.
"""

import json
import sys

from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

store = get_typestore(Stores.EMPTY)
topics = {}
last = {}
# Angles of the wheels as the bag has them, and by integration of their speeds, rad.
angles, turned = [], []
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file)
    profile = reader.get_header().profile
    for schema, channel, message in reader.iter_messages():
        kind = schema.name
        if kind not in store.types:
            store.register(get_types_from_msg(schema.data.decode(), kind))
        assert schema.encoding == "ros2msg" and channel.message_encoding == "cdr", (schema.encoding, channel.message_encoding)
        topic = topics.setdefault(channel.topic, {"type": kind, "count": 0, "hash": channel.metadata["topic_type_hash"] == store.hash_rihs01(kind)})
        topic["count"] += 1
        decoded = store.deserialize_cdr(message.data, kind)
        if channel.topic == "/joint_states":
            step = (message.log_time - last.get(channel.topic, (message.log_time,))[0]) * 1e-9
            turned = [b + step * v for b, v in zip(turned or decoded.position, decoded.velocity)]
            angles = list(decoded.position)
        last[channel.topic] = (message.log_time, decoded)

time, truth = last["/ground_truth"]
position = truth.pose.pose.position
values = {
    "time": time,
    "stamp": truth.header.stamp.sec * 1_000_000_000 + truth.header.stamp.nanosec,
    "position": [position.x, position.y, position.z],
    "child": truth.child_frame_id,
    "joints": last["/joint_states"][1].name,
    "drift": max(abs(a - b) for a, b in zip(angles, turned)),
    "turned": min(abs(a) for a in angles),
}
if "/points" in last:
    cloud = last["/points"][1]
    values["cloud"] = [cloud.height, cloud.width, len(cloud.data), [f.name for f in cloud.fields]]
print(json.dumps({"profile": profile, "topics": topics, "values": values}))
