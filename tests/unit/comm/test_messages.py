from __future__ import annotations

import pytest

from hawk.comm.messages import Ack, BadMessageError, Hold, parse_command


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('{"Type": "Fly", "Id": 7}', 7),
        ('{"Type": "Fly", "Id": "ü\\n"}', "ü\n"),
        ('{"Type": "Fly", "Id": true}', None),
        ('{"Type": "Fly", "Id": [1]}', None),
        ('{"Type": "Hold", "Id": "\\ud800"}', None),
        ('{"Type": "Hold", "Id": ' + "9" * 5000 + "}", None),
        ("{", None),
        ("[" * 5000, None),
    ],
)
def test_a_refusal_carries_the_id_if_it_can_be_sent_back(text: str, found: str | int | None) -> None:
    with pytest.raises(BadMessageError) as refused:
        parse_command(text)
    assert refused.value.message_id == found
    assert '"Accepted":false' in Ack(id=refused.value.message_id, accepted=False, reason=str(refused.value)).to_json()


def test_a_whole_pair_is_a_good_id() -> None:
    assert parse_command('{"Type": "Hold", "Id": "\\ud83d\\ude80"}') == Hold(id="\U0001f680")
