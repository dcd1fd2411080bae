from __future__ import annotations

import base64
import hashlib
import hmac
import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.outbox import Message
from hawk.webhooks.signature import body_of, headers_of, id_of, key_of

MESSAGE = Message(7, "survey", '{"survey": "abc", "lot": null}', 1_794_823_200.25, 0)


def test_the_signature_is_that_of_the_standard() -> None:
    """The example of the specification (standardwebhooks.com, "Signature scheme")."""
    key = key_of("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    signed = b'msg_p5jXN8AQM9LWM0D4loKWxJek.1614265330.{"test": 2432232314}'
    digest = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
    assert digest == "g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


@given(st.text(min_size=24), st.floats(0, 4e9))
def test_a_receiver_proves_a_message_by_its_headers(secret: str, now: float) -> None:
    body = body_of(MESSAGE)
    try:
        key = key_of(secret)
    except ValueError:
        return
    headers = headers_of(MESSAGE, body, key, now)
    signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
    version, _, given_ = headers["webhook-signature"].partition(",")
    assert version == "v1"
    assert base64.b64decode(given_) == hmac.new(key, signed, hashlib.sha256).digest()


def test_the_body_says_what_happened_and_when() -> None:
    assert json.loads(body_of(MESSAGE)) == {
        "type": "survey.stored", "timestamp": "2026-11-16T10:00:00+00:00", "data": {"survey": "abc", "lot": None},
    }  # fmt: skip
    assert json.loads(body_of(replace(MESSAGE, kind="layout")))["type"] == "layout.changed"


def test_a_message_keeps_its_id_and_another_one_has_another() -> None:
    assert id_of(MESSAGE) == id_of(replace(MESSAGE, tries=5))
    others = {
        id_of(replace(MESSAGE, **each)) for each in ({"seq": 8}, {"kind": "layout"}, {"made": 1.0}, {"body": "{}"})
    }
    assert len(others | {id_of(MESSAGE)}) == 5


def test_a_secret_that_is_no_base64_is_refused() -> None:
    with pytest.raises(ValueError, match="is no base64 behind whsec_"):
        key_of("whsec_%%%")
