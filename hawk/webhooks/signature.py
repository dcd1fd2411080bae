"""Body and headers of a message as Standard Webhooks has them (standardwebhooks.com, version 1.0).

``webhook-id`` is the same each time that a message is sent: a receiver knows a message that it has. The signature is
HMAC-SHA256 over ``id.timestamp.body``, so that an old message cannot be sent once more as a new one.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import json
from datetime import UTC, datetime
from typing import Final

from hawk.lots.outbox import Message

PREFIX: Final = "whsec_"
"""Beginning of a secret in base64; a secret without it is taken as text."""
TYPES: Final = {"survey": "survey.stored", "layout": "layout.changed"}
"""Type of a message by its kind in the outbox."""


def key_of(secret: str) -> bytes:
    """Return the key of a secret. Raises ValueError for one that begins with `PREFIX` and is no base64."""
    if not secret.startswith(PREFIX):
        return secret.encode()
    try:
        return base64.b64decode(secret.removeprefix(PREFIX), validate=True)
    except binascii.Error as error:
        raise ValueError(f"is no base64 behind {PREFIX}: {error}") from error


def body_of(message: Message) -> bytes:
    """Return the JSON that is sent; the same bytes each time."""
    moment = datetime.fromtimestamp(message.made, UTC).isoformat(timespec="seconds")
    content = {"type": TYPES.get(message.kind, message.kind), "timestamp": moment, "data": json.loads(message.body)}
    return json.dumps(content, separators=(",", ":")).encode()


def id_of(message: Message) -> str:
    """Return the id of a message: it differs between stores, and after a backup was restored."""
    content = f"{message.seq} {message.kind} {message.made!r} {message.body}".encode()
    return f"msg_{hashlib.sha256(content).hexdigest()[:32]}"


def headers_of(message: Message, body: bytes, key: bytes, now: float) -> dict[str, str]:
    """Return the headers of a message that is sent now, Unix seconds."""
    named, moment = id_of(message), str(int(now))
    digest = hmac.new(key, f"{named}.{moment}.".encode() + body, hashlib.sha256).digest()
    return {
        "Content-Type": "application/json",
        "webhook-id": named,
        "webhook-timestamp": moment,
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }
