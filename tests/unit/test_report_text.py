"""Strings made fit for a page: every character that must not stay is found, one by one."""

from __future__ import annotations

import re
import sys

from shaderlab.report.text import clean

ALL = [chr(code) for code in range(sys.maxunicode + 1)]
UNFIT = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def test_no_character_that_a_page_can_not_hold_comes_through_alone_or_among_others() -> None:
    for character in ALL:
        for text in (character, f"a{character}é"):
            shown = clean(text)
            assert not UNFIT.search(shown), hex(ord(character))
            assert "\r" not in shown


def test_hidden_characters_are_made_visible_and_all_others_stay() -> None:
    changed = [c for c in ALL if clean(c) != c and not UNFIT.match(c) and c != "\r"]
    assert all(clean(c) == f"[U+{ord(c):04X}]" for c in changed)
    codes = {ord(c) for c in changed}
    marks = {0x200B, 0x200E, 0x200F, 0xFEFF}
    assert codes == marks | set(range(0x2028, 0x202F)) | set(range(0x2060, 0x206A))


def test_other_values_are_written_out_first() -> None:
    class Text(str):
        def __str__(self) -> str:
            return "\x00"

    assert clean(7) == "7" and clean(Text("fine")) == "\ufffd"
