from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.photographs.xmp import number, numbers, read_xmp
from tests.unit.picture.photographs.photos import xmp


def test_a_tag_is_read_as_an_attribute_and_as_an_element() -> None:
    inner = "<drone-dji:GimbalYawDegree> +3.50 </drone-dji:GimbalYawDegree>"
    found = read_xmp(xmp({"drone-dji:RelativeAltitude": "+60.00"}, inner))
    assert found["drone-dji:RelativeAltitude"] == "+60.00"
    assert found["drone-dji:GimbalYawDegree"] == "+3.50"


def test_a_structure_is_read_in_each_of_its_three_forms() -> None:
    name = "drone-skydio:CalibratedFocalLength"
    forms = [
        f'<{name} drone-skydio:X="2376.5"/>',
        f'<{name} rdf:parseType="Resource"><drone-skydio:X>2376.5</drone-skydio:X></{name}>',
        f'<{name}><rdf:Description drone-skydio:X="2376.5"/></{name}>',
    ]
    for form in forms:
        assert read_xmp(xmp({}, form))[f"{name}/drone-skydio:X"] == "2376.5"


def test_the_items_of_a_list_have_commas_between() -> None:
    inner = "<Camera:PrincipalPoint><rdf:Seq><rdf:li>2.4</rdf:li><rdf:li>1.8</rdf:li></rdf:Seq></Camera:PrincipalPoint>"
    assert numbers(read_xmp(xmp({}, inner)), "Camera:PrincipalPoint") == (2.4, 1.8)


def test_a_prefix_is_that_of_the_file_whatever_its_namespace_is() -> None:
    packet = xmp({"Camera:Yaw": "5"}).replace(b"http://pix4d.com/camera/1.0/", b"http://ns.sensefly.com/Camera/1.0/")
    assert read_xmp(packet)["Camera:Yaw"] == "5"


@pytest.mark.parametrize("packet", [b"", b"no packet", b"</x:xmpmeta><x:xmpmeta>"])
def test_bytes_without_a_packet_hold_no_tags(packet: bytes) -> None:
    assert read_xmp(packet) == {}


def test_a_packet_that_is_no_xml_is_refused() -> None:
    with pytest.raises(ValueError, match="its XMP cannot be read"):
        read_xmp(xmp({}).replace(b"</rdf:RDF>", b""))


def test_entities_that_grow_are_refused() -> None:
    packet = xmp({}, "&a;").replace(b"<x:xmpmeta", b"<x:xmpmeta", 1)
    start = packet.index(b"<x:xmpmeta")
    bomb = packet[:start] + b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><!DOCTYPE a [<!ENTITY a "b">]></x:xmpmeta>'
    with pytest.raises(ValueError, match="its XMP cannot be read"):
        read_xmp(bomb)


@given(st.floats(-1e6, 1e6), st.sampled_from(["{:+.6f}", "{:.6f}"]))
def test_a_number_is_read_with_its_sign(value: float, form: str) -> None:
    assert number({"a": form.format(value)}, "missing", "a") == pytest.approx(value, abs=1e-6)


@given(st.text(max_size=12))
def test_a_text_that_is_no_number_is_none_and_raises_nothing(text: str) -> None:
    found = number({"a": text}, "a")
    assert found is None or isinstance(found, float)
