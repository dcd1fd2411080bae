from __future__ import annotations

import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import text

from hawk.exports.ground import Ground
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import pictures_of
from hawk.report.canvas import lot_drawing
from hawk.report.document import MOST_ROWS, content_policy, document
from hawk.report.options import LANGUAGES, PAPERS, Form, Language, Paper, Wanted
from hawk.report.picture import MOST_BYTES, _about_stalls, _jpeg, _Sheet
from hawk.report.queries import read_report
from hawk.report.values import DrawnZone
from hawk.report.words import Words
from hawk.stats.use_query import asked_of
from tests.unit.report.conftest import Read
from tests.unit.report.read_back import Page
from tests.unit.report.week import NAME, NOW, ZONE, Week, mosaic

ENGLISH = Form()
NBSP = "\N{NO-BREAK SPACE}"


@pytest.mark.slow
def test_the_first_page_says_lot_question_answer_and_figures_each_with_its_range(read: Read) -> None:
    report = read()
    page = Page.of(document(report, ENGLISH))
    share = report.asked.occupancy
    assert page.attributes("html")[0]["lang"] == "en"
    assert NAME in page.words
    assert "4 to 11 May 2026" in page.words
    assert "Times are those of Europe/Amsterdam." in page.words
    assert page.words.count("Europe/Amsterdam") == 1
    assert "how many stalls of the lot are taken, on any day, at any hour. 11 surveys on 7 days" in page.words
    low, high = round((share.low or 0) * 100), round((share.high or 0) * 100)
    assert f"On average {round((share.value or 0) * 100)}{NBSP}% were taken ({low} to {high}{NBSP}%)" in page.words
    assert "Newest survey, Mon 11 May 2026, 08:59" in page.words
    assert "Letters and numbers are our guess." in page.words
    assert "Row B" in page.words
    rows = {row[0]: row for row in page.tables["Rows"]}
    assert rows.keys() == {"Row", "A", "B", "C", "Lot"}
    assert all(" to " in rows[name][3] for name in ("A", "B", "C", "Lot"))
    assert re.fullmatch(r"1\d+ to \d+", rows["A"][4])
    assert rows["Lot"][1] == "60"


@pytest.mark.nightly
def test_the_picture_has_the_letters_of_its_figures_also_where_a_row_was_named_after_the_survey(tmp_path: Path) -> None:
    week = Week(tmp_path)
    week.edit({"do": "rename", "row": "A", "to": "P"}, {"do": "confirm", "row": "B"})
    with week.store.reading() as connection:
        report = read_report(connection, week.pictures, Wanted(week.lot, asked_of(None, None)), NOW)
    week.store.close()
    assert report.newest is not None
    assert report.newest.picture is not None
    assert {row.name for row in report.newest.picture.rows} == {row.name for row in report.rows} == {"P", "B", "C"}
    assert report.newest.named == 40


@pytest.mark.slow
def test_the_name_of_a_zone_lies_within_the_picture_however_long_it_is_and_wherever_the_zone_lies(read: Read) -> None:
    report = read()
    assert report.newest is not None
    assert report.newest.picture is not None
    picture = report.newest.picture
    for left, top in ((0.0, 0.0), (-900.0, picture.height - 1.0), (picture.width + 900.0, picture.height + 900.0)):
        zone = DrawnZone("x" * 200, ((left, top), (left + 9, top), (left + 9, top + 9), (left, top + 9)))
        drawn = str(lot_drawing(replace(picture, zones=(zone,)), Words("en"), 680, 330))
        plate = re.search(r'<rect x="([-\d.]+)" y="([-\d.]+)" width="([\d.]+)" height="14"', drawn)
        ground = re.search(r'height="([\d.]+)"[^>]*fill="#ececec"', drawn)
        assert plate is not None
        assert ground is not None
        x, y, wide = map(float, plate.groups())
        assert x >= 0
        assert x + wide <= 680
        assert 0 <= y <= float(ground[1]) - 14


@pytest.mark.slow
def test_the_heat_map_has_every_hour_of_the_week_and_ranges_of_those_that_were_flown(read: Read) -> None:
    page = Page.of(document(read(), ENGLISH))
    head, *hours = page.tables["Weekday by hour"]
    assert len(head) == 8
    assert [len(row) for row in hours] == [8] * 24
    flown = [cell for row in hours for cell in row[1:] if cell]
    assert len(flown) == 10  # two Mondays at 8:00 are one
    assert all(re.fullmatch(rf"\d+{NBSP}%\d+ to \d+{NBSP}%", cell) for cell in flown)


@pytest.mark.slow
def test_the_curve_joins_points_of_a_day_alone_and_hatches_what_nobody_flew(read: Read) -> None:
    report = read()
    page = Page.of(document(report, ENGLISH))
    assert len(page.attributes("circle")) == 11
    joined = [each["d"] or "" for each in page.attributes("path") if each.get("stroke") == "#c05000"]
    assert sorted(line.count("L") for line in joined) == [1, 1, 2]
    assert [each for each in page.attributes("rect") if each.get("fill") == "url(#nobody)"]
    assert {day.isoformat() for day in report.empty} == {"2026-05-10"}
    assert "Hatched: nobody flew." in page.words


@pytest.mark.slow
def test_a_day_that_was_flown_at_another_hour_is_not_one_that_nobody_flew(read: Read) -> None:
    report = read("sat-sun", "0-3")
    assert {day.isoformat() for day in report.empty} == {"2026-05-10"}
    assert "nobody flew then, or every survey was left out" in Page.of(document(report, ENGLISH)).words


@pytest.mark.slow
def test_a_question_about_a_part_says_that_part_alone_beside_the_other_rows(read: Read) -> None:
    report = read("mon-fri", "7-11", rows=("B",))
    page = Page.of(document(report, ENGLISH))
    assert (
        "of row B are taken, Monday to Friday, from 7:00 to 11:00. 6 surveys on 6 days looked at its 20" in page.words
    )
    assert [row[0] for row in page.tables["Rows, at the hours asked"]] == ["Row", "A", "B", "C"]
    assert len(page.tables["Surveys"][0]) == 3  # counts of the lot would be of other stalls
    assert sum("in" in (each.get("class") or "").split() for each in page.attributes("td")) == 5 * 4
    assert not report.zones
    assert "Left out" not in page.tables  # it was deleted, and flown at another hour


@pytest.mark.slow
def test_surveys_that_are_left_out_and_layouts_are_listed_with_their_reason(read: Read) -> None:
    page = Page.of(document(read(), ENGLISH))
    assert page.tables["Left out"][1] == ["Tue 5 May 2026, 16:00", "deleted by a person"]
    assert [row[1] for row in page.tables["Changes of the layout"]] == [
        "Why", "found by the first survey", "corrected by hand",
    ]  # fmt: skip
    assert len(page.tables["Surveys"]) == 12


@pytest.mark.nightly
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("paper", PAPERS)
def test_the_document_holds_all_that_it_shows_and_no_script(read: Read, language: Language, paper: Paper) -> None:
    html = document(read(), Form(language, paper))
    page = Page.of(html)
    assert not {"script", "link", "iframe", "object", "embed"} & {tag for tag, _ in page.tags}
    assert not [attrs for _, attrs in page.tags if any(name == "style" or name.startswith("on") for name in attrs)]
    links = [attrs[name] for _, attrs in page.tags for name in ("href", "src") if name in attrs]
    assert len(links) == 1
    assert (links[0] or "").startswith("data:image/jpeg;base64,")
    assert len(html) < 1_400_000
    assert "http" not in html
    assert ("8.5in 11in" if paper == "letter" else "210mm 297mm") in html
    assert html.count("<style>") == 1
    assert html.count("</style>") == 1
    assert ZONE in page.words
    policy = content_policy(html)
    assert "default-src 'none'" in policy
    assert "script" not in policy


@pytest.mark.slow
def test_a_link_shows_stalls_without_the_ground(read: Read) -> None:
    page = Page.of(document(read(has_ground=False), ENGLISH))
    assert "The ground is not shown by a link." in page.words
    assert not page.attributes("image")
    taken = [each["d"] or "" for each in page.attributes("path") if each.get("fill") == "url(#taken)"]
    assert max(each.count("Z") for each in taken) >= 20, "they are drawn, all that are taken as one"


@pytest.mark.nightly
def test_stalls_beyond_the_picture_are_on_the_sheet_too(read: Read, folder: Path) -> None:
    whole = read().newest
    assert whole is not None
    tiles = {key: tile for key, tile in mosaic().items() if key == (0, 0)}
    pictures_of(folder / "lots.db").write(whole.use.id, tiles)
    newest = read().newest
    assert newest is not None
    assert newest.picture is not None
    assert newest.picture.jpeg
    at = np.array([corner for stall in newest.picture.stalls for corner in stall.corners])
    assert (at >= 0).all()
    assert (at <= (newest.picture.width, newest.picture.height)).all()


@pytest.mark.slow
def test_a_high_lot_lies_on_its_side_with_north_to_the_right() -> None:
    ground = Ground(np.zeros((400, 100, 3), np.uint8), np.full((400, 100), 255, np.uint8), 40.0, 0.0, 0.1)
    corners = np.array([[(38.0, 1.0), (38.0, 9.0), (2.0, 9.0), (2.0, 1.0)]])
    sheet = _Sheet.of(_about_stalls(ground, corners))
    height, width = sheet.image.shape[:2]
    assert sheet.is_turned
    assert width > height
    northern, southern = sheet.places(np.array([(38.0, 5.0), (2.0, 5.0)]))
    assert northern[0] > southern[0]
    assert northern[1] == pytest.approx(southern[1])


@pytest.mark.nightly
@pytest.mark.parametrize("damage", ["no zip", "no tile", "gone"])
def test_a_picture_that_cannot_be_read_is_left_out_and_said(read: Read, folder: Path, damage: str) -> None:
    report = read()
    assert report.newest is not None
    path = pictures_of(folder / "lots.db").folder / f"{report.newest.use.id}.zip"
    if damage == "no zip":
        path.write_bytes(b"PK\x05\x06 damaged")
    elif damage == "gone":
        path.unlink()
    else:
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("0_0.jpg", b"no picture")
    page = Page.of(document(read(), ENGLISH))
    words = "is not kept any more" if damage == "gone" else "The picture of this survey is damaged"
    assert words in page.words
    assert not page.attributes("image")
    assert "11 surveys on 7 days" in page.words


@pytest.mark.slow
def test_a_layout_and_a_survey_that_are_damaged_are_counted_and_the_rest_is_shown(read: Read, folder: Path) -> None:
    whole = read()
    store = Database(folder / "lots.db")
    with store.writing() as connection:
        connection.execute(text("update layout set valid_from = 'never' where version = 2"))
        first = whole.surveys[0].id
        connection.execute(text("update survey set limits = '[7]' where id = :id"), {"id": first})
    store.close()
    report = read()
    page = Page.of(document(report, ENGLISH))
    assert report.unreadable == 2
    assert "2 surveys or versions of the layout are damaged" in page.words
    assert len(page.tables["Changes of the layout"]) == 2
    assert len(page.tables["Surveys"]) == 11
    assert report.asked.occupancy == whole.asked.occupancy


@pytest.mark.slow
def test_a_period_without_surveys_is_a_document_that_says_so(read: Read) -> None:
    for language in LANGUAGES:
        page = Page.of(document(read(begin="2031-01-01"), Form(language)))
        assert not page.tables
    page = Page.of(document(read(begin="2031-01-01"), ENGLISH))
    assert "No survey of this period counts" in page.words
    assert "1 Jan 2031" in page.words


@pytest.mark.nightly
def test_one_survey_is_the_only_one_and_has_no_rivals(read: Read) -> None:
    page = Page.of(document(read(begin="2026-05-11", end="2026-05-11"), ENGLISH))
    assert "One survey on one day looked at its 60 stalls." in page.words
    assert "only survey: Mon 11 May, 08:59" in page.words
    assert "may have been as full" not in page.words


@pytest.mark.slow
def test_a_period_ends_now_at_the_latest_and_days_before_it_are_hatched(read: Read) -> None:
    report = read(begin="2026-05-01", end="2026-06-30")
    assert (str(report.first), str(report.last)) == ("2026-05-01", "2026-05-11")
    assert {day.day for day in report.empty} == {1, 2, 3, 10}


@pytest.mark.slow
def test_a_picture_of_noise_is_no_larger_than_it_may_be() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (1600, 1600, 3)).astype(np.uint8)
    assert 0 < len(_jpeg(noise)) <= MOST_BYTES


@pytest.mark.slow
def test_a_long_list_is_cut_with_words(read: Read) -> None:
    report = read()
    surveys = report.asked.surveys * 20
    page = Page.of(document(replace(report, asked=report.asked.model_copy(update={"surveys": surveys})), ENGLISH))
    assert len(page.tables["Surveys"]) == MOST_ROWS + 1
    assert f"The newest {MOST_ROWS} of 220 surveys. The workbook lists all." in page.words


@pytest.mark.slow
def test_surveys_of_a_simulator_and_by_pictures_of_others_are_named_as_such(read: Read, folder: Path) -> None:
    whole = read()
    store = Database(folder / "lots.db")
    with store.writing() as connection:
        first, second = (use.id for use in whole.surveys[:2])
        connection.execute(text("update survey set simulated = 1 where id = :id"), {"id": first})
        connection.execute(
            text("update survey set kind = 'picture', source = 'orthophoto' where id = :id"), {"id": second}
        )
    store.close()
    page = Page.of(document(read(), ENGLISH))
    assert "One survey was flown by a simulator: its cars are drawn, not real." in page.words
    assert "One survey was made of pictures that others took" in page.words
    assert [row[-1] for row in page.tables["Surveys"][1:4]] == ["simulated", "by pictures of others", ""]
