# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Streams every log once and sorts what comes by sensor."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from hullrecon.dive.logs.messages.decode import decode, type_name
from hullrecon.dive.logs.messages.samples import TYPES, stamp_ns
from hullrecon.dive.logs.readers.protocol import Channel, Log, Loss, Message
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import ImageSample, Sample
from hullrecon.errors import InputError

TakeImage = Callable[[ImageSample, int], None]  # the sample and when it was logged, ns
Watch = Callable[[Iterable[Message]], Iterable[Message]]
LIMIT_NS = 1 << 63  # of int64, the year 2262
SENSORS = tuple(TYPES)


@dataclass
class LogContents:
    """What the logs held. samples and logged_ns by sensor ("dvl", ...; images go to their sinks); counts by topic."""

    samples: dict[str, list[Sample]] = field(default_factory=lambda: {name: [] for name in SENSORS})
    logged_ns: dict[str, list[int]] = field(default_factory=lambda: {name: [] for name in SENSORS})
    counts: Counter[Channel] = field(default_factory=Counter)
    undecoded: Counter[tuple[str, str]] = field(default_factory=Counter)
    unstamped: Counter[str] = field(default_factory=Counter)
    passed_over: Counter[Channel] = field(default_factory=Counter)
    losses: list[tuple[str, Loss]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def read_streams(logs: Sequence[Log], topics: Mapping[str, str], take_image: TakeImage, watch: Watch = iter) -> LogContents:
    """topics: sensor by topic; a sensor named there comes from that topic, not from a PD0 file or a table beside the log.
    Streams; only small samples are kept. `watch` sees every message pass (progress)."""
    out = LogContents()
    for log in logs:
        for message in watch(log.messages()):
            out.counts[message.channel] += 1
            for sensor, sample in _samples(message, topics, out):
                if isinstance(sample, ImageSample):
                    take_image(sample, message.t_ns)
                else:
                    out.samples[sensor].append(sample)
                    out.logged_ns[sensor].append(message.t_ns)
        out.losses += [(log.path.name, loss) for loss in log.losses()]
        out.remarks += [f"{log.path.name}: {remark}" for remark in log.remarks]
    out.remarks += [f"{topic}: {n} messages could not be used: {why}" for (topic, why), n in sorted(out.undecoded.items())]
    out.remarks += [
        f"{topic}: {n} messages have no stamp; their logging time was used" for topic, n in sorted(out.unstamped.items())
    ]
    out.remarks += [
        f"{c.type}: its {n} readings were left aside, as topics.{c.topic} is set" for c, n in out.passed_over.items()
    ]
    return out


def _samples(message: Message, topics: Mapping[str, str], out: LogContents) -> Iterator[tuple[str, Sample]]:
    channel = message.channel
    if not isinstance(message.data, bytes):
        if channel.topic in topics.values():
            out.passed_over[channel] += 1
        else:
            yield channel.topic, message.data
        return
    sensor = topics.get(channel.topic)
    if sensor is None:
        return
    translate = TYPES[sensor].get(type_name(channel))
    if translate is None:
        raise InputError(
            f"topic {channel.topic} holds {channel.type}, which is not read as {sensor}",
            where=f"topics.{sensor}", remedy=f"name a topic of {' or '.join(sorted(TYPES[sensor]))}",
        )  # fmt: skip
    try:
        fields = decode(channel, message.data)
        stamp = stamp_ns(fields.header)
        if stamp == 0:
            out.unstamped[channel.topic] += 1
        if not (abs(stamp) < LIMIT_NS and abs(message.t_ns) < LIMIT_NS):
            raise DamagedError("their stamps lie beyond the year 2262")
        found = translate(fields, stamp or message.t_ns, sensor)
    except DamagedError as error:
        out.undecoded[channel.topic, str(error)] += 1
        return
    yield from ((sensor, sample) for sample in found)
